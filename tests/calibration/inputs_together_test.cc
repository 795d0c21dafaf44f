// Measurements that are given together and do not go together: named by file and line.
#include "calibration/state/inputs_together.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::CheckTogether;
using calibration::Recording;
using ::testing::AllOf;
using ::testing::HasSubstr;

Recording Table(const std::string& file, double begin_s, double end_s) {
  Recording out;
  out.info.source = file;
  out.info.gyro_present = {true, true, true};
  out.info.gyro_units_per_deg_s = 131.0;
  out.info.power_on = "A";
  out.info.key_lines = {{"power_on", 2}, {"gyro_lsb_per_deg_s", 3}};
  out.info.first_row_line = 5;
  out.first_time_s = begin_s;
  out.last_time_s = end_s;
  return out;
}

// What is said in every order in which they can be given: it is the same.
std::string Message(const std::vector<Recording>& tables) {
  std::vector<std::size_t> order(tables.size());
  std::iota(order.begin(), order.end(), 0u);
  std::string said;
  bool first = true;
  do {
    std::vector<const Recording*> list;
    for (const std::size_t i : order) list.push_back(&tables[i]);
    std::string now;
    try {
      CheckTogether(list);
    } catch (const DataError& error) {
      now = error.what();
    }
    if (!first) {
      EXPECT_EQ(now, said);
    }
    said = now;
    first = false;
  } while (std::next_permutation(order.begin(), order.end()));
  return said;
}

TEST(TablesOfOnePowerOn, MayLieOneAfterTheOtherInAnyOrder) {
  EXPECT_EQ(Message({Table("b.csv", 100, 200), Table("a.csv", 0, 100), Table("c.csv", 250, 300)}),
            "");
}

TEST(TablesOfOnePowerOn, ThatOverlapAreNamedByFileAndLine) {
  EXPECT_THAT(Message({Table("b.csv", 90, 200), Table("a.csv", 0, 100), Table("c.csv", 250, 300)}),
              AllOf(HasSubstr("b.csv:2: power_on = A"), HasSubstr("a.csv:2"),
                    HasSubstr("ends at t_s = 100"), HasSubstr("t_s = 90 (b.csv:5)"),
                    HasSubstr("name of its own")));
}

// A table whose clock was set back begins inside of the one before.
TEST(TablesOfOnePowerOn, WhoseClockWasSetBackAreNamed) {
  EXPECT_THAT(Message({Table("a.csv", 0, 100), Table("b.csv", 0, 50)}),
              HasSubstr("names the same power-on"));
}

TEST(TablesOfTwoPowerOns, MayHaveTheSameTimes) {
  Recording other = Table("b.csv", 0, 100);
  other.info.power_on = "B";
  EXPECT_EQ(Message({Table("a.csv", 0, 100), other}), "");
  other.info.power_on = "";
  EXPECT_EQ(Message({Table("a.csv", 0, 100), other}), "");
}

std::string MessageOf(const Recording& a, const Recording& b) {
  const Recording* const list[] = {&a, &b};
  try {
    CheckTogether(list);
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(TablesTogether, HaveOneUnitOneRangeAndOneZero) {
  const Recording a = Table("a.csv", 0, 100);
  Recording b = Table("b.csv", 100, 200);
  b.info.gyro_unit = RateUnit::kDegPerSecond;
  EXPECT_THAT(MessageOf(a, b), AllOf(HasSubstr("b.csv:4: expected"), HasSubstr("_lsb"),
                                     HasSubstr("a.csv:4"), HasSubstr("found _deg_s")));
  b = Table("b.csv", 100, 200);
  b.info.gyro_units_per_deg_s = 65.5;
  EXPECT_THAT(MessageOf(a, b), AllOf(HasSubstr("b.csv:3: expected 131"), HasSubstr("a.csv:3"),
                                     HasSubstr("found 65.5")));
  b = Table("b.csv", 100, 200);
  b.info.gyro_lsb_zero = 32768.0;
  b.info.key_lines["gyro_lsb_zero"] = 1;
  EXPECT_EQ(MessageOf(a, b), "") << "the counts of a may be signed";
  Recording raw = a;
  raw.defects = {{"unsigned_counts", 10, 0.5, "gyro_x_lsb"}};
  EXPECT_THAT(MessageOf(raw, b),
              AllOf(HasSubstr("a.csv:4: expected the key gyro_lsb_zero"), HasSubstr("b.csv:1")));
}

// One that never leaves a side of its zero does not show its sign, but where it is.
TEST(TablesTogether, AreSignedOrUnsigned) {
  const auto table = [](const char* file, double begin_s, double level, bool crosses) {
    Recording out = Table(file, begin_s, begin_s + 100.0);
    calibration::Node begin, end;
    end.at.t_s = 100.0;
    end.at.z = {-20.0 * 100.0, level * 100.0, 40.0 * 100.0};
    out.columns.nodes = {begin, end};
    if (crosses) out.defects = {{"unsigned_counts", 10, 0.5, "gyro_y_lsb"}};
    return out;
  };
  const Recording is_signed = table("a.csv", 0.0, -300.0, false);
  const Recording crossing = table("b.csv", 100.0, 32700.0, true);
  const Recording above = table("c.csv", 200.0, 33100.0, false);
  EXPECT_THAT(Message({is_signed, crossing}),
              AllOf(HasSubstr("b.csv:5: expected signed counts, as in a.csv:5"),
                    HasSubstr("gyro_lsb_zero")));
  EXPECT_EQ(Message({crossing, above}), "");
}

TEST(TablesTogether, HaveOneZeroWhereSeveralSayIt) {
  Recording a = Table("a.csv", 0, 100), b = Table("b.csv", 100, 200);
  a.info.gyro_lsb_zero = 32768.0;
  b.info.gyro_lsb_zero = 32760.0;
  a.info.key_lines["gyro_lsb_zero"] = b.info.key_lines["gyro_lsb_zero"] = 1;
  EXPECT_THAT(MessageOf(a, b),
              AllOf(HasSubstr("b.csv:1: expected 32768"), HasSubstr("a.csv:1, found 32760")));
}

// Rows of one measurement from one time to another, as two files of a log may have them.
Recording PartOf(Story story, const std::string& file, double from_s, double to_s) {
  story.info.source = file;
  story.info.first_row_line = 7;
  story.spoil_gyro = [=](GyroSample* sample) {
    return sample->t_s >= from_s && sample->t_s < to_s;
  };
  return story.Collect();
}

TEST(TablesTogether, ShareNoPartOfAMeasurement) {
  const Story story;
  const Recording whole = PartOf(story, "whole.csv", 0.0, 180.0);
  EXPECT_THAT(Message({whole, PartOf(story, "one_row_less.csv", 0.03, 180.0)}),
              AllOf(HasSubstr("whole.csv:7"), HasSubstr("one_row_less.csv:7"),
                    HasSubstr("the same measurement"), HasSubstr("give each once")));
  EXPECT_THAT(
      Message({PartOf(story, "begin.csv", 0.0, 110.0), PartOf(story, "end.csv", 80.0, 180.0)}),
      AllOf(HasSubstr("begin.csv:7"), HasSubstr("end.csv:7"),
            HasSubstr("samples of the same measurement")));
  EXPECT_EQ(Message({PartOf(story, "begin.csv", 0.0, 90.0), PartOf(story, "end.csv", 90.0, 180.0)}),
            "");
}

TEST(TablesTogether, MayRepeatAMotion) {
  Story again;
  again.seed = 2;
  EXPECT_EQ(Message({PartOf(Story(), "a.csv", 0.0, 180.0), PartOf(again, "b.csv", 0.0, 180.0)}),
            "");
}

// A sensor that is off says the same for long.
TEST(TablesTogether, MayBothHoldASensorThatIsOff) {
  Story story, other;
  other.seed = 2;
  const auto off = [](GyroSample* sample) {
    if (sample->t_s > 40.0) sample->xi = {17.0, -3.0, 8.0};
    return true;
  };
  story.spoil_gyro = other.spoil_gyro = off;
  story.info.source = "a.csv";
  other.info.source = "b.csv";
  EXPECT_EQ(Message({story.Collect(), other.Collect()}), "");
}

TEST(TablesTogether, AreNotTheSameOneTwice) {
  Story story;
  story.duration_s = 30.0;
  story.info.source = "a.csv";
  const Recording a = story.Collect();
  story.info.source = "copy.csv";
  EXPECT_THAT(MessageOf(a, story.Collect()),
              AllOf(HasSubstr("a.csv"), HasSubstr("copy.csv"), HasSubstr("same measurement")));
}

}  // namespace
}  // namespace gyrobench::testing
