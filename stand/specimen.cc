#include "stand/specimen.h"

#include <algorithm>

#include "stand/random.h"

namespace gyrobench::stand {
namespace {

class Drawer {
 public:
  explicit Drawer(std::uint64_t seed) : stream_(seed, Source::kSpecimen) {}

  // Nobody ships a part beyond its data sheet: the tails are cut.
  void Add(double& value, double sigma) {
    constexpr double kTail = 2.5;
    value += sigma * std::clamp(stream_.Normal(), -kTail, kTail);
  }
  template <std::size_t N>
  void Add(std::array<double, N>& values, double sigma) {
    for (double& value : values) Add(value, sigma);
  }
  void AddOffDiagonal(config::Square& values, double sigma) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i % 4 != 0) Add(values[i], sigma);
    }
  }
  void Phase(double& deg, bool drawn) {
    const double turn = stream_.Uniform();
    if (drawn) deg = 360.0 * turn;
  }

 private:
  RandomStream stream_;
};

void DrawGyro(config::GyroScenario& gyro, const config::DrawnScenario& drawn, Drawer& drawer) {
  drawer.Add(gyro.scale_rel, drawn.gyro_scale_rel);
  drawer.AddOffDiagonal(gyro.cross_axis_rel, drawn.gyro_cross_axis_rel);
  drawer.Add(gyro.scale_temperature_per_degC, drawn.gyro_scale_temperature_per_degC);
  drawer.Add(gyro.bias_deg_s, drawn.gyro_bias_deg_s);
  drawer.Add(gyro.bias_deg_s_per_degC, drawn.gyro_bias_deg_s_per_degC);
  drawer.Add(gyro.bias_deg_s_per_degC2, drawn.gyro_bias_deg_s_per_degC2);
  drawer.Add(gyro.bias_deg_s_per_degC3, drawn.gyro_bias_deg_s_per_degC3);
  drawer.Add(gyro.g_linear_deg_s_per_g, drawn.gyro_g_linear_deg_s_per_g);
  drawer.Add(gyro.g_squared_deg_s_per_g2, drawn.gyro_g_squared_deg_s_per_g2);
  drawer.Add(gyro.sample_clock_rel, drawn.sample_clock_rel);
  for (auto& tone : gyro.tones) drawer.Phase(tone.phase_deg, drawn.phases);
}

void DrawStand(config::Scenario& specimen, const config::DrawnScenario& drawn, Drawer& drawer) {
  for (auto& axis : specimen.mechanics) {
    drawer.Add(axis.clock_rel, drawn.drive_clock_rel);
    drawer.Phase(axis.worm_1_phase_deg, drawn.phases);
    drawer.Phase(axis.worm_2_phase_deg, drawn.phases);
  }
  for (auto& encoder : specimen.encoder) {
    drawer.Phase(encoder.eccentricity_1_phase_deg, drawn.phases);
    drawer.Phase(encoder.eccentricity_2_phase_deg, drawn.phases);
    drawer.Phase(encoder.ripple_phase_deg, drawn.phases);
    drawer.Phase(encoder.worm_1_phase_deg, drawn.phases);
    drawer.Phase(encoder.worm_2_phase_deg, drawn.phases);
  }
}

}  // namespace

config::Scenario DrawSpecimen(const config::Scenario& scenario, std::uint64_t seed) {
  config::Scenario specimen = scenario;
  const config::DrawnScenario& drawn = scenario.drawn;
  Drawer drawer(seed);
  DrawStand(specimen, drawn, drawer);
  drawer.Add(specimen.accelerometer.offset_g, drawn.accelerometer_offset_g);
  drawer.Add(specimen.accelerometer.scale_rel, drawn.accelerometer_scale_rel);
  drawer.AddOffDiagonal(specimen.accelerometer.cross_axis_rel, drawn.accelerometer_cross_axis_rel);
  drawer.Add(specimen.thermal.thermometer_offset_degC, drawn.thermometer_offset_degC);
  drawer.Add(specimen.unit.tick_rel, drawn.tick_rel);
  drawer.Add(specimen.site.mount_deg, drawn.mount_deg);
  DrawGyro(specimen.gyro, drawn, drawer);
  specimen.drawn = config::IdealScenario().drawn;
  return specimen;
}

}  // namespace gyrobench::stand
