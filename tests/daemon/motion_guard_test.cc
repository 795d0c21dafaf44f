// Drive and reference of one axis against what was commanded.
#include "daemon/motion_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

using ::testing::HasSubstr;

constexpr double kRate_deg_s = 10.0;

class MotionGuardTest : public testing::Test {
 protected:
  MotionGuardTest() {
    config_.name = "inner";
    config_.following_error_deg = 1.0;
    Run(2.0, Still, Still);
  }
  static double Still(double) { return 0.0; }
  // A move by so much at 10 deg/s, as the drive counts it.
  static std::function<double(double)> MoveTo(double angle_deg) {
    return [=](double t_s) { return std::min(angle_deg, kRate_deg_s * t_s); };
  }
  void Begin(double angle_deg) {
    guard_.MayMove();
    guard_.Begin({Drive(false, 0.0), Reference(0.0)}, angle_deg, kRate_deg_s, 1000.0);
  }
  drivers::AxisState Drive(bool moving, double commanded_deg) const {
    drivers::AxisState state;
    state.utime = now_;
    state.moving = moving;
    state.commanded_deg = commanded_deg;
    return state;
  }
  drivers::AngleReading Reference(double angle_deg) const {
    drivers::AngleReading reading;
    reading.utime = now_;
    reading.angle_deg = angle_deg;
    return reading;
  }
  // Reads the reference at 50 Hz and polls the drive at 2 Hz, for so long or until there is a fault;
  // the angles are those of so many seconds after the begin. Returns when that was [s].
  double Run(double duration_s, const std::function<double(double)>& drive_deg,
             const std::function<double(double)>& table_deg) {
    const Utime begin = now_;
    for (int i = 0; ToSeconds(now_ - begin) < duration_s && !fault_; ++i, now_ += 20'000) {
      const double t_s = ToSeconds(now_ - begin);
      const drivers::AngleReading reading = Reference(table_deg(t_s));
      fault_ = guard_.Read(reading);
      const bool moving = drive_deg(t_s + 0.02) != drive_deg(t_s);
      if (i % 25 == 0 && !fault_) fault_ = guard_.Polled(Drive(moving, drive_deg(t_s)), reading);
    }
    return ToSeconds(now_ - begin);
  }

  config::AxisConfig config_;
  MotionGuard guard_{config_};
  Utime now_ = kStart;
  std::optional<Fault> fault_;
};

TEST_F(MotionGuardTest, HasNothingToSayOfAMoveAsItWasCommanded) {
  Begin(50.0);
  Run(20.0, MoveTo(50.0), MoveTo(50.0));
  EXPECT_FALSE(fault_) << fault_->message;
}

// Drive and reference agree; both are wrong.
TEST_F(MotionGuardTest, ATableThatTurnsFasterThanCommandedIsAFault) {
  Begin(1000.0);
  const auto faster = [](double t_s) { return 2.0 * kRate_deg_s * t_s; };
  const double told_s = Run(20.0, faster, faster);
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("faster than commanded"));
  EXPECT_THAT(fault_->message, HasSubstr("commanded 10 deg/s"));
  EXPECT_LT(told_s, 2.0);
}

TEST_F(MotionGuardTest, ATableThatRunsPastItsTargetIsAFault) {
  Begin(5.0);
  const double told_s = Run(20.0, MoveTo(1000.0), MoveTo(1000.0));
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("past its target"));
  EXPECT_THAT(fault_->message, HasSubstr("commanded 5.000 deg"));
  EXPECT_LT(told_s, 2.5);
}

TEST_F(MotionGuardTest, ATableThatDoesNotFollowIsAFault) {
  Begin(1000.0);
  Run(20.0, MoveTo(1000.0), [](double t_s) { return 0.5 * kRate_deg_s * t_s; });
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("does not follow its drive"));
}

// 50 deg at 10 deg/s are 5 s: 9.5 s at most, and one poll.
TEST_F(MotionGuardTest, AMoveThatDoesNotEndIsAFault) {
  Begin(50.0);
  const auto slow = [](double t_s) { return t_s; };
  const double told_s = Run(60.0, slow, slow);
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("should have taken 5.0 s"));
  EXPECT_GT(told_s, 9.0);
  EXPECT_LT(told_s, 10.2);
}

TEST_F(MotionGuardTest, ATableThatLeavesItsRestIsAFaultOnceAndHoweverSlowly) {
  const auto slips = [](double t_s) { return 0.01 * t_s; };
  const double told_s = Run(300.0, Still, slips);
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("though nobody commanded it"));
  EXPECT_NEAR(told_s, 100.0, 1.0);
  fault_.reset();
  Run(50.0, Still, [](double t_s) { return 1.0 + 0.01 * t_s; });
  EXPECT_FALSE(fault_) << "it came to rest anew";
}

TEST_F(MotionGuardTest, OneWrongReadingIsNoMotion) {
  Run(10.0, Still, [](double t_s) { return t_s > 5.0 && t_s < 5.03 ? 30.0 : 0.0; });
  EXPECT_FALSE(fault_) << fault_->message;
}

TEST_F(MotionGuardTest, ADriveThatMovesWithoutACommandIsAFaultOnce) {
  fault_ = guard_.Polled(Drive(true, 7.0), Reference(0.0));
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("the drive moves, at 7.000 deg"));
  EXPECT_FALSE(guard_.Polled(Drive(true, 8.0), Reference(0.0)));
  EXPECT_FALSE(guard_.Polled(Drive(false, 8.0), Reference(0.0)));
  EXPECT_TRUE(guard_.Polled(Drive(true, 9.0), Reference(0.0)));
}

// Swings of 1 s and 10 deg each, which no reading of half a second's age can tell from standstill.
class ToAndFro : public MotionGuardTest {
 protected:
  static constexpr double kSide_deg = 5.0;
  // Where the drive is after so many seconds, from the middle and back to it at last.
  static double Swinging(double t_s) {
    const double phase = std::fmod(std::max(0.0, t_s) + 0.5, 2.0);
    return kRate_deg_s * (phase < 1.0 ? phase - 0.5 : 1.5 - phase);
  }
  // Moves are commanded at the ends of the swing; the table is where `table_deg` says.
  void Swing(double duration_s, const std::function<double(double)>& table_deg) {
    const Utime begin = now_;
    while (ToSeconds(now_ - begin) < duration_s && !fault_) {
      const bool first = now_ == begin;
      const double from_deg = Swinging(ToSeconds(now_ - begin));
      const double by_deg = first ? kSide_deg : from_deg > 0 ? -2 * kSide_deg : 2 * kSide_deg;
      guard_.MayMove();
      guard_.Begin({Drive(false, from_deg), Reference(table_deg(ToSeconds(now_ - begin)))}, by_deg,
                   kRate_deg_s, 1e6);
      const double so_far_s = ToSeconds(now_ - begin);
      const Utime move_begin = now_;
      Run(
          first ? 0.5 : 1.0,
          [&](double t_s) { return Swinging(so_far_s + std::min(t_s, first ? 0.499 : 0.999)); },
          [&](double t_s) { return table_deg(so_far_s + t_s); });
      if (!fault_) now_ = move_begin + FromSeconds(first ? 0.5 : 1.0);
    }
    swung_s_ = ToSeconds(now_ - begin);
  }
  double swung_s_ = 0.0;
};

TEST_F(ToAndFro, ATableThatIsJammedIsAFaultWithinTwoSwings) {
  Swing(60.0, Still);
  ASSERT_TRUE(fault_);
  EXPECT_THAT(fault_->message, HasSubstr("does not follow its drive"));
  EXPECT_THAT(fault_->message, HasSubstr("went over 0.000 deg"));
  EXPECT_LT(swung_s_, 3.0);
}

TEST_F(ToAndFro, ATableThatJamsLaterOrFollowsInPartIsAFault) {
  Swing(60.0, [](double t_s) { return Swinging(std::min(t_s, 20.2)); });
  ASSERT_TRUE(fault_);
  EXPECT_GT(swung_s_, 20.2);
  EXPECT_LT(swung_s_, 26.0);
  fault_.reset();
  Run(5.0, Still, Still);
  Swing(60.0, [](double t_s) { return 0.8 * Swinging(t_s); });
  EXPECT_TRUE(fault_);
}

// As late as nobody needs to declare, or as declared; and with play in the worm.
TEST_F(ToAndFro, ATableThatFollowsIsNoFaultHoweverLateItsReferenceIs) {
  for (const double declared_s : {0.0, 1.3}) {
    for (const double late_s : {0.0, 0.25, 0.5}) {
      config_.encoder.map.delay_s = declared_s;
      Swing(40.0, [=](double t_s) { return 0.95 * Swinging(t_s - declared_s - late_s); });
      EXPECT_FALSE(fault_) << declared_s << " " << late_s << ": " << fault_->message;
      Run(5.0, Still, Still);
      fault_.reset();
    }
  }
}

// It comes to rest within its ramp, and its reference later still.
TEST_F(MotionGuardTest, AMoveThatIsStoppedHalfWayIsNoMotionWithoutACommand) {
  config_.encoder.map.delay_s = 1.0;
  Begin(1000.0);
  const auto stopped = [](double t_s) { return std::min(30.0, kRate_deg_s * t_s); };
  Run(30.0, stopped, [&](double t_s) { return stopped(std::max(0.0, t_s - 1.0)); });
  EXPECT_FALSE(fault_) << fault_->message;
}

}  // namespace
}  // namespace gyrobench::daemon
