// Play in the gear.
#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

// (b/2) sgn(last w), and on the way from one side to the other as far as the play has been crossed.
// Play between table and reference (b > 0, the gyro leads) is crossed while the reference stands,
// play before the table (b < 0) while the gyro does: whichever moves says how far.
class BacklashBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const std::size_t axis = context().table_axis;
    const double b_deg = context().nonlinear[0];
    const double play_deg = std::max(std::fabs(b_deg), kLeastPlay_deg);
    const OneWay way = WayOf(point, b_deg);
    if (point.restart) {
      ++power_ons_;
      follower_deg_ = kMissing;
    }
    if (std::isfinite(way.front())) {
      if (!std::isfinite(follower_deg_)) {
        follower_deg_ = way.front() - StartSide() * play_deg;
      } else if (point.begins) {
        // Between measurements the reference alone says what the table turned by.
        const double moved_deg = point.table_deg[axis] - last_deg_;
        const bool moved = std::fabs(moved_deg) > kLeastMove_deg;
        const double lead_deg = side_ * play_deg + (moved ? moved_deg : 0.0);
        follower_deg_ = way.front() - std::clamp(lead_deg, -0.5 * play_deg, 0.5 * play_deg);
      }
      terms[0] = MeanSide(point, way, play_deg);
    }
    last_deg_ = point.table_deg[axis];
  }

 private:
  // The noise of the reference's readings must not pass for reversals: it is in the output as well,
  // and would be found there. A clear play stands out of it.
  static constexpr double kLeastPlay_deg = 0.005, kClearPlay_deg = 0.015;
  // Less is the noise of two readings.
  static constexpr double kLeastMove_deg = 0.05;

  double StartSide() const { return start_side(std::max<std::size_t>(power_ons_, 1) - 1); }

  // Along a way, at the end of each of its steps.
  using OneWay = std::array<double, kWaySteps>;

  // Of the axis, as the gyro shows it or, where the reference stands for the table, about its
  // angle.
  OneWay WayOf(const SensorState& point, double b_deg) const {
    const std::size_t axis = context().table_axis;
    OneWay way;
    way.fill(kMissing);
    if (!point.gyro_turns.empty()) {
      const Way& felt = point.gyro_turns[point.node].table_way_deg;
      for (std::size_t i = 0; i < kWaySteps; ++i) way[i] = felt[i][axis];
    }
    const bool by_reference = b_deg < -kClearPlay_deg || !std::isfinite(way.front());
    if (!by_reference) return way;
    const double off_deg = point.table_deg[axis] - MeanOverReadings(point, way);
    for (double& angle_deg : way)
      angle_deg = std::isfinite(off_deg) ? angle_deg + off_deg : point.table_deg[axis];
    return way;
  }
  // The last reading is at the end of the way.
  static double MeanOverReadings(const SensorState& point, const OneWay& along) {
    const double way_step_s =
        point.gyro_turns.empty() ? 0.0 : point.gyro_turns[point.node].way_step_s;
    if (!(way_step_s > 0.0)) return along.back();
    constexpr auto kLast = static_cast<double>(kWaySteps - 1);
    const auto readings = static_cast<double>(point.readings);
    double sum = 0.0;
    for (double back = 0.0; back < readings; back += 1.0) {
      const double place = std::clamp(kLast - back * point.reading_step_s / way_step_s, 0.0, kLast);
      const std::size_t i = std::min(static_cast<std::size_t>(place), kWaySteps - 2);
      sum += std::lerp(along[i], along[i + 1], place - static_cast<double>(i));
    }
    return sum / readings;
  }
  // Which leaves `side_` as it is after the last of them.
  double MeanSide(const SensorState& point, const OneWay& way, double play_deg) {
    OneWay sides;
    for (std::size_t i = 0; i < kWaySteps; ++i) {
      if (i > 1) Turn(way[i - 2], way[i - 1], way[i], play_deg);
      sides[i] = Follow(way[i], play_deg);
    }
    side_ = sides.back();
    return MeanOverReadings(point, sides);
  }
  // Where the axis turns back between three angles it went as far as the parabola through them.
  void Turn(double first_deg, double middle_deg, double last_deg, double play_deg) {
    if ((middle_deg - first_deg) * (last_deg - middle_deg) >= 0.0) return;
    const double bend_deg = first_deg - 2.0 * middle_deg + last_deg;
    Follow(middle_deg - std::pow(last_deg - first_deg, 2) / (8.0 * bend_deg), play_deg);
  }
  double Follow(double angle_deg, double play_deg) {
    follower_deg_ =
        std::clamp(follower_deg_, angle_deg - 0.5 * play_deg, angle_deg + 0.5 * play_deg);
    return (angle_deg - follower_deg_) / play_deg;
  }
  std::size_t power_ons_ = 0;  // begun
  double side_ = 0.0;
  double follower_deg_ = kMissing;
  double last_deg_ = kMissing;  // of the reference
};

}  // namespace

Effect AngleBacklash() {
  return {
      .id = "angle.backlash",
      .domain = EffectDomain::kAngle,
      .owner = EffectOwner::kBench,
      .equation = "(b/2) sgn(last w)",
      .cause = "play in the gear",
      .looks_like =
          "after each reversal the angle is off by the same amount, and back after the next",
      .manoeuvre = "reverse the direction",
      .needs = kNeedsRate | kNeedsTableAxis,
      .terms = {{"b", "deg"}},
      .nonlinear = {{"b", "deg", -1.0, 1.0, {0.0}}},
      .search = Search::kCoefficient,
      .typical_size = 0.1,
      .size_source = "experience with gears of this class: 0.005 to 0.1",
      // It is crossed between two readings, of which each is known to some milliseconds: of what
      // it explains a hundredth was left in swings of 1 Hz and more, of which a scale factor of
      // temperature and rate explained a fifth.
      .shape_error = 0.055,
      .unknown_start = true,
      .basis = Make<BacklashBasis>};
}

}  // namespace gyrobench::calibration
