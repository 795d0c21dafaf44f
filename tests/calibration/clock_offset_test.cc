// Gyro and reference logged apart, by clocks that were not started together.
#include "calibration/signal/clock_offset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "calibration/trace/trace.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::FindClockOffset;
using calibration::Recording;
using calibration::RemarkOnClocks;
using ::testing::AllOf;
using ::testing::HasSubstr;

// The reference's motion comes `late_s` after the gyro's.
Story Offset(double late_s, std::uint64_t seed) {
  Story story;
  story.seed = seed;
  story.duration_s = 90.0;
  story.info.source = "story.csv";
  // Turns of different length and speed, as a hand makes them.
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> rest_s(0.5, 4.0), speed_deg_s(-80.0, 80.0);
  std::vector<std::array<double, 3>> turns;  // begin, length, top speed
  for (double t_s = 3.0; t_s < story.duration_s;) {
    turns.push_back({t_s, 1.0 + rest_s(random), speed_deg_s(random)});
    t_s += turns.back()[1] + rest_s(random);
  }
  story.rate_deg_s = [turns](double t_s) {
    double rate = 0.0;
    for (const auto& [begin_s, length_s, top] : turns) {
      const double part = (t_s - begin_s) / length_s;
      if (part > 0.0 && part < 1.0) rate += top * std::pow(std::sin(std::numbers::pi * part), 2);
    }
    return rate;
  };
  story.angle_deg = [turns, late_s](double t_s) {
    double angle = 0.0;
    for (const auto& [begin_s, length_s, top] : turns) {
      const double part = std::clamp((t_s - late_s - begin_s) / length_s, 0.0, 1.0);
      angle += top * length_s *
               (0.5 * part - std::sin(2.0 * std::numbers::pi * part) / (4.0 * std::numbers::pi));
    }
    return angle;
  };
  return story;
}

TEST(ClocksNotStartedTogether, AreFoundToAFewHundredthsOfASecond) {
  for (const double late_s : {0.5, -2.0, 0.3, 4.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const auto found = FindClockOffset(Offset(late_s, seed).Collect());
      ASSERT_TRUE(found) << late_s << " s, seed " << seed;
      EXPECT_NEAR(found->reference_late_s, late_s, 0.03) << "seed " << seed;
      EXPECT_GT(found->correlation, found->correlation_as_is);
      EXPECT_TRUE(found->others_late_s.empty());
    }
  }
}

// Latencies and filters are for the trace itself.
TEST(ClocksThatAgree, AreNotSpokenOf) {
  for (const double late_s : {0.0, 0.05, -0.05}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed)
      EXPECT_EQ(RemarkOnClocks(Offset(late_s, seed).Collect()), "") << late_s << ' ' << seed;
  }
}

TEST(ClocksThatAgree, AreNotSpokenOfWhereReadingsAreBadOrNothingMoves) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Story noisy = Offset(0.0, seed);
    noisy.reading_deg = 0.5;
    noisy.white_deg_s = 5.0;
    EXPECT_EQ(RemarkOnClocks(noisy.Collect()), "") << seed;
    Story still = Offset(0.5, seed);
    still.rate_deg_s = still.angle_deg = [](double) { return 0.0; };
    EXPECT_EQ(RemarkOnClocks(still.Collect()), "") << seed;
    Story steady = Offset(0.0, seed);
    steady.rate_deg_s = [](double t_s) { return 30.0 * std::sin(6.0 * t_s); };
    steady.angle_deg = [](double t_s) { return -5.0 * std::cos(6.0 * t_s); };
    EXPECT_EQ(RemarkOnClocks(steady.Collect()), "") << seed << ": motion that repeats";
  }
  Story none = Offset(0.5, 1);
  none.info.reference = ReferenceKind::kNone;
  EXPECT_EQ(RemarkOnClocks(none.Collect()), "");
}

// Noise of a gyro and steps of an encoder that leave a tenth of a second in doubt do not hide half
// a second; nor do a gap, wild values and an axis mounted the other way round.
TEST(ClocksNotStartedTogether, AreFoundInBadData) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Story story = Offset(0.5, seed);
    story.reading_deg = 0.05;
    story.white_deg_s = 1.0;
    story.scale = {0.0, 0.0, -1.0};
    story.spoil_gyro = [](GyroSample* sample) { return sample->t_s < 40.0 || sample->t_s > 43.0; };
    story.spoil_angle = [](AngleSample* sample) {
      if (sample->t_s > 60.0 && sample->t_s < 60.3) sample->angle_deg += 300.0;
      return sample->t_s < 20.0 || sample->t_s > 24.0;
    };
    const auto found = FindClockOffset(story.Collect());
    ASSERT_TRUE(found) << seed;
    EXPECT_NEAR(found->reference_late_s, 0.5, 0.05) << seed;
  }
}

// To and fro, half a period off fits as well, of an axis mounted the other way round.
TEST(ClocksNotStartedTogether, AreTakenForTheLeastOffWhereMotionRepeats) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Story story = Offset(0.0, seed);
    story.rate_deg_s = [](double t_s) { return 60.0 * std::sin(t_s); };
    story.angle_deg = [](double t_s) { return -60.0 * std::cos(t_s - 0.3); };
    const auto found = FindClockOffset(story.Collect());
    ASSERT_TRUE(found) << seed;
    EXPECT_NEAR(found->reference_late_s, 0.3, 0.02) << seed;
    ASSERT_EQ(found->others_late_s.size(), 2u) << "half a period of 6.28 s before and after";
    EXPECT_NEAR(found->others_late_s[0], 0.3 - std::numbers::pi, 0.02);
    EXPECT_NEAR(found->others_late_s[1], 0.3 + std::numbers::pi, 0.02);
  }
}

TEST(ClocksNotStartedTogether, AreARemarkOfTheTraceThatSaysWhatToDo) {
  const auto remarks_of = [](double late_s) {
    Story story = Offset(late_s, 1);
    story.info.first_row_line = 5;
    const Recording recording = story.Collect();
    const Recording* const one[] = {&recording};
    std::string all;
    for (const std::string& remark : calibration::Trace(one).result.remarks) all += remark + '\n';
    return all;
  };
  EXPECT_THAT(remarks_of(0.5),
              AllOf(HasSubstr("story.csv: the reference turns 0.5"), HasSubstr("s after the gyro"),
                    HasSubstr("not started together"), HasSubstr("# ref_delay_s = 0.5")));
  EXPECT_THAT(remarks_of(-2.0), AllOf(HasSubstr("s before the gyro does"),
                                      HasSubstr("off the t column of the gyro")));
}

}  // namespace
}  // namespace gyrobench::testing
