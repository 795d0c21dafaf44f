#include "calibration/hold/hold_plausibility.h"

#include <fmt/format.h>

#include <cmath>
#include <span>

namespace gyrobench::calibration {
namespace {

// No MEMS part on the market has a scale error of more than 10 %.
constexpr double kLargestScaleError = 0.2;
// How near a factor must be to one that a wrong unit makes: beyond what parts differ by.
constexpr double kNear = 0.1;

struct WrongUnit {
  double factor;  // of the output by what it should be
  const char* says;
};
constexpr WrongUnit kOfGyro[] = {
    {0.0174533,
     "the values are in rad/s: call the columns gyro_x_rad_s and so on, not gyro_x_deg_s"},
    {57.29578,
     "the values are in deg/s: call the columns gyro_x_deg_s and so on, not gyro_x_rad_s"},
    {0.5, "the sensor's range is twice the one that gyro_lsb_per_deg_s belongs to"},
    {2.0, "the sensor's range is half of the one that gyro_lsb_per_deg_s belongs to"},
    {1000.0, "the times are in ms: t_s is in seconds"},
    {0.001, "the times are in ms: t_s is in seconds"},
};
constexpr WrongUnit kOfAccelerometer[] = {
    {9.80665, "the values are in m/s^2: accel_x_g and so on are in g = 9.80665 m/s^2"},
    {1000.0, "the values are in mg: accel_x_g and so on are in g"},
};

std::string Cause(double factor, std::span<const WrongUnit> causes, const char* else_check) {
  for (const WrongUnit& cause : causes) {
    if (std::fabs(factor / cause.factor - 1.0) < kNear) return cause.says;
  }
  return else_check;
}

// Geometric mean of what the axes put out by what they should.
double GainOf(const Eigen::Matrix3d& m) {
  return std::cbrt(m.row(0).norm() * m.row(1).norm() * m.row(2).norm());
}

std::string CannotBe(const char* sensor, double factor, const std::string& cause) {
  return fmt::format(
      "this result cannot be: the {} puts out {:.4g} times what it should, at most {:g} % off was "
      "expected of any part. Most likely {}",
      sensor, factor, 100.0 * kLargestScaleError, cause);
}

bool CanBe(double factor) { return std::fabs(factor - 1.0) <= kLargestScaleError; }

}  // namespace

std::vector<std::string> ImplausibleHold(const HoldState& state, bool sensitivity_given) {
  std::vector<std::string> out;
  const double gyro = GainOf(state.m), accelerometer = GainOf(state.accel.Matrix());
  if (sensitivity_given && !CanBe(gyro)) {
    out.push_back(
        CannotBe("gyro", gyro,
                 Cause(gyro, kOfGyro,
                       "its unit, its sensitivity (gyro_lsb_per_deg_s) or the times are not what "
                       "the table says")));
  }
  if (!CanBe(accelerometer)) {
    out.push_back(CannotBe("accelerometer", accelerometer,
                           Cause(accelerometer, kOfAccelerometer,
                                 "its unit is not g = 9.80665 m/s^2, as the columns' names say")));
  }
  return out;
}

}  // namespace gyrobench::calibration
