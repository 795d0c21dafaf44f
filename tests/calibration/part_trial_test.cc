// What is held out is not seen: neither by the choice nor by the fit.
#include "calibration/trace/part_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/split.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

using calibration::Baseline;
using calibration::CandidateSet;
using calibration::ChannelProblem;
using calibration::ChannelRequest;
using calibration::Recording;
using calibration::RestOf;
using calibration::RowRange;
using calibration::SearchedChannel;
using calibration::Split;
using calibration::StateHistory;

constexpr std::size_t kZ = 2;

class HeldOutRows : public ::testing::Test {
 protected:
  HeldOutRows() { Measure({}); }

  void Measure(const Injection& injection) {
    recording_ = SyntheticBench(EveryMotion(), {}).Measure(injection, 3);
    histories_.clear();
    histories_.push_back(MakeStateHistory(recording_, RoughSensitivity(recording_), true, {}));
    histories_.front().recording = &recording_;
    rest_rows_.clear();
    request_.histories = histories_;
    request_.channel = kZ;
    request_.false_discovery = 0.003;
    const ChannelProblem problem = Problem();
    split_ = *EveryThirdBlock(problem, problem.MakeBaseline());
    for (const RowRange& range : split_.rest) {
      for (Eigen::Index i = range.begin; i < range.end; ++i) rest_rows_.push_back(i);
    }
    references_ = problem.row_refs();
  }

  ChannelProblem Problem() const { return ChannelProblem(histories_, kZ, 1.0); }

  // The output turns by `deg` in a row, and stays there.
  void Turn(Eigen::Index row, double deg) {
    std::vector<calibration::Node>& nodes = histories_.front().epochs;
    for (std::size_t k = references_[static_cast<std::size_t>(row)].interval + 1; k < nodes.size();
         ++k) {
      nodes[k].at.z[kZ] += deg;
    }
  }

  struct Outcome {
    std::vector<std::string> by_all;
    calibration::PartTrial trial;
  };
  Outcome Try() const {
    const ChannelProblem problem = Problem();
    const Baseline baseline = problem.MakeBaseline();
    const auto candidates = std::make_shared<const CandidateSet>(AllCandidates(problem, {}, false));
    std::vector<std::string> remarks;
    const std::optional<SearchedChannel> found =
        SearchChannel(problem, baseline, candidates, request_, &remarks);
    const calibration::ChannelFit fit = FitChannel(problem, baseline, found->selection);
    Outcome out{{},
                TryOnRest(*Train(problem, baseline, *candidates, request_, split_),
                          NamedEffects(found->selection, fit), request_.seed, RestOf::kBetween)};
    for (const auto& member : found->selection.members()) out.by_all.push_back(member.id);
    return out;
  }

  Recording recording_;
  std::vector<StateHistory> histories_;
  ChannelRequest request_;
  Split split_;
  std::vector<Eigen::Index> rest_rows_;
  std::vector<calibration::ProblemRow> references_;
};

TEST_F(HeldOutRows, AndTrainingAreAllRowsAndEachOnce) {
  std::vector<Eigen::Index> all = split_.training;
  all.insert(all.end(), rest_rows_.begin(), rest_rows_.end());
  std::ranges::sort(all);
  std::vector<Eigen::Index> expected(static_cast<std::size_t>(Problem().rows()));
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(all, expected);
  EXPECT_GT(5 * rest_rows_.size(), all.size());
  EXPECT_LT(2 * rest_rows_.size(), all.size());
  for (std::size_t i = 1; i < split_.rest.size(); ++i)
    EXPECT_GT(split_.rest[i].begin, split_.rest[i - 1].end);
}

TEST_F(HeldOutRows, AreATimeInWhichNothingWasMeasured) {
  const ChannelProblem whole = Problem(), part = whole.Part(split_.training);
  ASSERT_EQ(part.rows(), static_cast<Eigen::Index>(split_.training.size()));
  double measured_s = 0.0, missing_s = 0.0;
  for (const auto& interval : part.intervals()) {
    measured_s += interval.duration_s;
    missing_s += interval.gap_before_s;
  }
  double whole_s = 0.0;
  for (const auto& interval : whole.intervals())
    whole_s += interval.duration_s + interval.gap_before_s;
  EXPECT_NEAR(measured_s + missing_s, whole_s, 1e-6);
  for (Eigen::Index i = 0; i < part.rows(); ++i) {
    const Eigen::Index row = split_.training[static_cast<std::size_t>(i)];
    EXPECT_EQ(part.begin_s(i), whole.begin_s(row));
    EXPECT_EQ(part.output_deg()(i), whole.output_deg()(row));
  }
  std::vector<Eigen::Index> all(static_cast<std::size_t>(whole.rows()));
  std::iota(all.begin(), all.end(), 0);
  const ChannelProblem same = whole.Part(all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(same.intervals()[i].gap_before_s, whole.intervals()[i].gap_before_s);
    EXPECT_EQ(same.intervals()[i].new_reference, whole.intervals()[i].new_reference);
  }
}

// Each power-on has an offset of its own, which training must be able to know.
TEST_F(HeldOutRows, LeaveEveryPowerOnItsBegin) {
  histories_.push_back(MakeStateHistory(recording_, RoughSensitivity(recording_), true, {}));
  histories_.back().recording = &recording_;
  const ChannelProblem problem = Problem();
  const Split split = *EveryThirdBlock(problem, problem.MakeBaseline());
  const ChannelProblem part = problem.Part(split.training);
  ASSERT_EQ(problem.power_on_begins().size(), 2U);
  ASSERT_EQ(part.power_on_begins().size(), 2U);
  const auto second = static_cast<std::size_t>(part.power_on_begins()[1]);
  EXPECT_EQ(split.training[second], problem.power_on_begins()[1]);
  for (std::size_t i = 0; i < part.intervals().size(); ++i)
    EXPECT_EQ(part.intervals()[i].new_run, i == second);
}

// Whatever the sensor says in them, what is chosen and fitted on the others is the same.
TEST_F(HeldOutRows, HaveNoPartInWhatIsChosen) {
  Measure({[](const BenchState& s) { return 6e-7 * std::pow(s.rate_deg_s[kZ], 3.0); }, {}, {}});
  const Outcome clean = Try();
  ASSERT_EQ(clean.by_all, std::vector<std::string>{"scale.cubic"});
  EXPECT_EQ(clean.trial.chosen, clean.by_all);
  EXPECT_TRUE(clean.trial.same.front().has_value());
  EXPECT_LT(clean.trial.all.whitened_rms.after, clean.trial.all.whitened_rms.before);
  double sign = 1.0;
  for (const Eigen::Index row : rest_rows_) Turn(row, 0.02 * (sign = -sign));
  const Outcome spoiled = Try();
  EXPECT_EQ(spoiled.trial.chosen, clean.trial.chosen);
  EXPECT_GT(spoiled.trial.all.whitened_rms.after, 2.0 * clean.trial.all.whitened_rms.after);
}

// What happens in them alone is chosen on all data, and marked so.
TEST_F(HeldOutRows, AloneShowAStepThatTrainingCannotKnow) {
  const ChannelProblem problem = Problem();
  const auto turning = std::ranges::find_if(rest_rows_, [&](Eigen::Index row) {
    return std::fabs(problem.half(row, 0).rate_deg_s[kZ]) > 10.0;
  });
  ASSERT_NE(turning, rest_rows_.end());
  Turn(*turning, 0.2);
  const Outcome outcome = Try();
  // A jump between two nodes, each the mean of readings: one step or two near to each other.
  ASSERT_FALSE(outcome.by_all.empty());
  for (const std::string& id : outcome.by_all) EXPECT_EQ(id, "angle.step");
  EXPECT_TRUE(outcome.trial.chosen.empty());
  EXPECT_FALSE(outcome.trial.same.front().has_value());
  EXPECT_EQ(outcome.trial.all.whitened_rms.before, outcome.trial.all.whitened_rms.after);
}

}  // namespace
}  // namespace gyrobench::testing
