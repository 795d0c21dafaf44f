// The rotation of the Earth, where it was not taken off.
#include <Eigen/Geometry>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"

namespace gyrobench::calibration {
namespace {

constexpr const char* kEarthRate = "bias.earth_rate";

// w_north on world x and y (headings are not known here), w_up on z; nothing where it is in the
// rates.
class EarthBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    const auto c = static_cast<Eigen::Index>(context().channel);
    const Eigen::Vector3d x = Eigen::Vector3d::Map(point.world_x.data());
    const Eigen::Vector3d z = Eigen::Vector3d::Map(point.gravity_g.data());
    const Eigen::Vector3d y = z.cross(x);
    terms[0] = point.earth_rate_known ? 0.0 : z[c];
    terms[1] = point.earth_rate_known ? 0.0 : x[c];
    terms[2] = point.earth_rate_known ? 0.0 : y[c];
  }
};

}  // namespace

Effect BiasEarthRate() {
  return {.id = kEarthRate,
          .equation = "w_E in the sensor's frame",
          .cause = "Earth's rotation, where the site's latitude is not configured",
          .looks_like =
              "the zero-rate offset is off by up to 0.0042 deg/s, by another amount in each pose "
              "and heading",
          .manoeuvre = "configure the site's latitude and heading",
          .needs = kNeedsGravity,
          .terms = {{"up", "deg/s"}, {"world_x", "deg/s"}, {"world_y", "deg/s"}},
          .typical_size = 0.0042,
          .size_source = "15.04 deg/h, the rate of the Earth",
          .limited = true,
          .slow = true,
          .true_motion = true,
          .basis = Make<EarthBasis>};
}

const Effect& EarthRotationEffect() {
  static const Effect& effect = *FindEffect(kEarthRate);
  return effect;
}

}  // namespace gyrobench::calibration
