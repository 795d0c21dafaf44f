// Play in the gear.
#include <algorithm>
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
  void At(const TrackPoint& point, double* terms) override {
    const std::size_t axis = context().table_axis;
    const double b_deg = context().nonlinear[0];
    const bool by_reference =
        b_deg < -kClearPlay_deg || !std::isfinite(point.table_by_gyro_deg[axis]);
    const double angle_deg = by_reference ? point.table_deg[axis] : point.table_by_gyro_deg[axis];
    const double play_deg = std::max(std::fabs(b_deg), kLeastPlay_deg);
    if (point.restart) {
      ++power_ons_;
      follower_deg_ = kMissing;
    }
    if (std::isfinite(angle_deg)) {
      if (!std::isfinite(follower_deg_)) {
        follower_deg_ = angle_deg - StartSide() * play_deg;
      } else if (point.begins) {
        // Between measurements the reference alone says what the table turned by.
        const double moved_deg = point.table_deg[axis] - last_deg_;
        const bool moved = std::fabs(moved_deg) > kLeastMove_deg;
        const double lead_deg = side_ * play_deg + (moved ? moved_deg : 0.0);
        follower_deg_ = angle_deg - std::clamp(lead_deg, -0.5 * play_deg, 0.5 * play_deg);
      }
      side_ = MeanSide(point, angle_deg, play_deg);
    }
    last_deg_ = point.table_deg[axis];
    terms[0] = side_;
  }

 private:
  // The noise of the reference's readings must not pass for reversals: it is in the output as well,
  // and would be found there. A clear play stands out of it.
  static constexpr double kLeastPlay_deg = 0.005, kClearPlay_deg = 0.015;
  // Less is the noise of two readings.
  static constexpr double kLeastMove_deg = 0.05;

  double StartSide() const {
    const std::vector<double>& sides = context().start_sides;
    const std::size_t power_on = std::max<std::size_t>(power_ons_, 1) - 1;
    return power_on < sides.size() ? sides[power_on] : 0.0;
  }

  // On the way through the point; the mean over what it stands for.
  double MeanSide(const TrackPoint& point, double angle_deg, double play_deg) {
    const std::size_t axis = context().table_axis;
    const bool several = point.span_s() > 0.0;
    double sum = 0.0, count = 0.0;
    auto pass = [&](const Vector3& way, bool counts) {
      if (!std::isfinite(way[axis])) return;
      Follow(angle_deg + way[axis], play_deg);
      if (!counts) return;
      sum += (angle_deg + way[axis] - follower_deg_) / play_deg;
      count += 1.0;
    };
    // A mean is ahead of the instant while the table speeds up: the two do not mix.
    if (!several) pass(point.table_way_deg[0], false);
    pass(point.table_way_deg[1], several);
    pass(point.table_way_deg[2], several);
    pass({}, true);
    if (several) {
      for (const Vector3& way : point.table_way_on_deg) pass(way, true);
    }
    return sum / count;
  }
  void Follow(double angle_deg, double play_deg) {
    follower_deg_ =
        std::clamp(follower_deg_, angle_deg - 0.5 * play_deg, angle_deg + 0.5 * play_deg);
  }
  std::size_t power_ons_ = 0;  // begun
  double side_ = 0.0;
  double follower_deg_ = kMissing;
  double last_deg_ = kMissing;  // of the reference
};

}  // namespace

Effect AngleBacklash() {
  return {.id = "angle.backlash",
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
          .unknown_start = true,
          .basis = Make<BacklashBasis>};
}

}  // namespace gyrobench::calibration
