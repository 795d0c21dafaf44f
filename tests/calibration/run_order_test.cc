// Several measurements of one sensor: the result is that of the set, not of the order in which they
// were given.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "calibration/state/inputs_together.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::OrderedRun;
using calibration::OrderRuns;
using calibration::Recording;
using calibration::Traced;
using calibration::TraceResult;
using ::testing::HasSubstr;

struct Spec {
  std::string source, power_on;
  double begin_s, end_s;
};

// What the order depends on.
std::vector<Recording> Empty(const std::vector<Spec>& specs) {
  std::vector<Recording> out(specs.size());
  for (std::size_t i = 0; i < specs.size(); ++i) {
    out[i].info.source = specs[i].source;
    out[i].info.power_on = specs[i].power_on;
    out[i].first_time_s = specs[i].begin_s;
    out[i].last_time_s = specs[i].end_s;
  }
  return out;
}

struct Ordered {
  std::string text;  // names in order, with an exclamation mark where the sensor restarts
  std::vector<std::string> remarks;
};

Ordered OrderOf(const std::vector<Recording>& recordings, const std::vector<std::size_t>& given) {
  std::vector<const Recording*> list;
  for (const std::size_t i : given) list.push_back(&recordings[i]);
  Ordered out;
  for (const OrderedRun& run : OrderRuns(list, &out.remarks))
    out.text += list[run.index]->info.source + (run.restart ? "! " : " ");
  return out;
}

void ExpectInEveryOrder(const std::vector<Spec>& specs, const std::string& expected,
                        const std::string& remark) {
  const std::vector<Recording> recordings = Empty(specs);
  std::vector<std::size_t> given(specs.size());
  std::iota(given.begin(), given.end(), 0u);
  do {
    const Ordered ordered = OrderOf(recordings, given);
    EXPECT_EQ(ordered.text, expected);
    if (remark.empty()) {
      EXPECT_TRUE(ordered.remarks.empty());
    } else {
      EXPECT_THAT(ordered.remarks, ::testing::ElementsAre(HasSubstr(remark)));
    }
  } while (std::next_permutation(given.begin(), given.end()));
}

TEST(OrderOfRuns, IsByTimeWithinAPowerOnWhoseFirstRestarts) {
  ExpectInEveryOrder({{"late", "A", 500, 600},
                      {"early", "A", 0, 100},
                      {"middle", "A", 100, 400},
                      {"other", "B", 50, 90}},
                     "early! middle late other! ", "");
}

TEST(OrderOfRuns, RestartsAllOfAPowerOnWhoseTimesOverlap) {
  ExpectInEveryOrder({{"a", "A", 0, 100}, {"b", "A", 0, 90}, {"c", "A", 200, 300}}, "b! a! c! ",
                     "overlap");
}

TEST(OrderOfRuns, RestartsEachThatNamesNoPowerOn) {
  ExpectInEveryOrder({{"a", "", 0, 100}, {"b", "", 100, 200}, {"c", "C", 0, 10}}, "a! b! c! ", "");
}

Story StoryOf(const std::string& source, std::uint64_t seed, double duration_s) {
  Story story;
  story.info.source = source;
  story.seed = seed;
  story.duration_s = duration_s;
  return story;
}

// All numbers of a result by name, those of a measurement by its file; what is not determined has
// none.
std::map<std::string, double> Numbers(const Traced& traced) {
  std::map<std::string, double> out;
  const TraceResult& result = traced.result;
  for (const calibration::ChannelTrace& channel : result.channels) {
    const std::string axis(1, "xyz"[static_cast<std::size_t>(channel.axis)]);
    for (const calibration::ModelParameter& parameter : channel.baseline.parameters) {
      const std::string run = "zero_rate_offset_run_";
      std::string name = parameter.name;
      if (name.starts_with(run))
        name = run + result.inputs.at(std::stoul(name.substr(run.size())) - 1).file;
      out[axis + name] = parameter.value;
      out[axis + name + "_std_error"] = parameter.std_error;
    }
    for (const calibration::TracedEffect& effect : channel.effects) {
      for (const calibration::ModelParameter& parameter : effect.parameters) {
        if (parameter.name != "run" && !parameter.because)
          out[axis + effect.id + parameter.name] = parameter.value;
      }
    }
    out[axis + "before"] = channel.heldout_angle_rms_deg.before;
    out[axis + "noise"] = channel.noise.angle_random_walk_deg_sqrt_s;
  }
  return out;
}

TEST(TraceOfSeveralRuns, IsTheSameInWhateverOrderTheyAreGiven) {
  Story late = StoryOf("a.csv", 3, 120.0);
  late.spoil_gyro = [](GyroSample* sample) {
    sample->t_s += 0.02;
    return true;
  };
  const std::vector<Recording> recordings = {StoryOf("b.csv", 2, 90.0).Collect(), late.Collect(),
                                             StoryOf("c.csv", 4, 100.0).Collect()};
  const auto trace = [&](const std::vector<std::size_t>& order) {
    std::vector<const Recording*> list;
    for (const std::size_t i : order) list.push_back(&recordings[i]);
    return Numbers(calibration::Trace(list));
  };
  const std::map<std::string, double> first = trace({0, 1, 2});
  ASSERT_TRUE(first.contains("zzero_rate_offset_run_a.csv"));
  EXPECT_NEAR(first.at("zangle.latency_of_runtau"), 0.02, 0.002);
  EXPECT_EQ(first, trace({2, 1, 0}));
  EXPECT_EQ(first, trace({1, 2, 0}));
}

// What is left of the number of a run when one of them cannot be used.
TEST(TraceOfSeveralRuns, NumbersThemAsTheyWereGiven) {
  Story broken = StoryOf("broken.csv", 5, 60.0);
  broken.spoil_gyro = [](GyroSample* sample) {
    sample->xi[2] = kMissing;
    return true;
  };
  const Recording a = StoryOf("z.csv", 2, 90.0).Collect(), b = broken.Collect(),
                  c = StoryOf("a.csv", 4, 100.0).Collect();
  const Recording* const list[] = {&a, &b, &c};
  const Traced traced = calibration::Trace(list);
  EXPECT_EQ(traced.result.inputs[2].file, "a.csv");
  std::vector<std::string> names;
  for (const auto& parameter : traced.result.channels.back().baseline.parameters)
    names.push_back(parameter.name);
  EXPECT_THAT(names, ::testing::IsSupersetOf({"zero_rate_offset_run_1", "zero_rate_offset_run_3"}));
  EXPECT_THAT(names, ::testing::Not(::testing::Contains("zero_rate_offset_run_2")));
}

}  // namespace
}  // namespace gyrobench::testing
