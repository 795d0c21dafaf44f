#include "calibration/signal/wrong_unit.h"

#include <fmt/format.h>

#include <cmath>

#include "base/geometry.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

// LSB per deg/s of the gyros on the market: from 2000 deg/s to 125 deg/s in 16 bits, and finer.
constexpr double kLeastSensitivity = 10.0, kLargestSensitivity = 300.0;
constexpr double kThousand = 1000.0;
constexpr double kNearThousand = 0.04;        // beyond it counts are likelier
constexpr double kStandardGravity = 9.80665;  // m/s^2
// An accelerometer's size at rest errs by its offset at most, some 0.05 g.
constexpr double kNearGravity = 0.06;

// The columns of one axis or of all, as a sentence names them.
struct ColumnNames {
  std::optional<char> axis;
  std::string Of(const char* unit) const {
    return axis ? fmt::format("gyro_{}_{}", *axis, unit)
                : fmt::format("gyro_x_{0}, gyro_y_{0} and gyro_z_{0}", unit);
  }
  std::string Name(const char* unit) const {
    return fmt::format("Name the column{} {}", axis ? "" : "s", Of(unit));
  }
};

// Of a sensor that scales by itself, by a thousand.
std::optional<std::string> Thousandths(double size, const ColumnNames& columns, bool radians) {
  const char* const named = radians ? "rad_s" : "deg_s";
  if (IsNearFactor(size, kThousand)) {
    return fmt::format(
        "the unit, the factor is 1000: the values of {} are in {}. Divide them by 1000",
        columns.Of(named), radians ? "mrad/s" : "mdeg/s");
  }
  if (radians && IsNearFactor(size, kThousand * kDegPerRad)) {
    return fmt::format(
        "the unit, the factor is 1000 times that of degrees and radians: the values of {} are in "
        "mdeg/s. Divide them by 1000. {}",
        columns.Of(named), columns.Name("deg_s"));
  }
  return std::nullopt;
}

// Of one whose values are so many to a deg/s.
std::optional<std::string> Counts(double counts, const ColumnNames& columns, bool radians) {
  const char* const named = radians ? "rad_s" : "deg_s";
  if (IsNearFactor(counts, kDegPerRad)) {
    return fmt::format(
        "the unit: the values of {} were multiplied by the degrees of a radian once too often, or "
        "are counts of the converter. Check what wrote the table; counts belong into the column{} "
        "{}",
        columns.Of(named), columns.axis ? "" : "s", columns.Of("lsb"));
  }
  if (!(counts >= kLeastSensitivity && counts <= kLargestSensitivity)) return std::nullopt;
  return fmt::format(
      "the unit: the values of {} are counts of the converter, about {:.0f} for each deg/s. {} and "
      "give the sensitivity above the header, as the data sheet states it: # gyro_lsb_per_deg_s = "
      "...",
      columns.Of(named), 10.0 * std::round(0.1 * counts), columns.Name("lsb"));
}

// A column of a sensor that scales by itself, in another unit than its name says: what to do.
std::optional<std::string> OtherThanNamed(double ratio, const ColumnNames& columns, bool radians) {
  const double size = std::fabs(1.0 / ratio);
  if (IsNearFactor(size, radians ? kDegPerRad : 1.0 / kDegPerRad)) {
    return fmt::format(
        "the unit, the factor is that of degrees and radians: the values of {} are in {}. {}",
        columns.Of(radians ? "rad_s" : "deg_s"), radians ? "deg/s" : "rad/s",
        columns.Name(radians ? "deg_s" : "rad_s"));
  }
  const auto thousandths = Thousandths(size, columns, radians);
  const auto counts = Counts(radians ? size / kDegPerRad : size, columns, radians);
  if (!thousandths || !counts) return thousandths ? thousandths : counts;
  // 16.4 counts to a deg/s in a column of rad/s are nearly a thousand.
  const bool nearer = std::fabs(size / kThousand - 1.0) < kNearThousand;
  return fmt::format("{}; or {}", nearer ? *thousandths : *counts, nearer ? *counts : *thousandths);
}

// The same of a column of counts.
std::optional<std::string> NoCounts(double ratio, const ColumnNames& columns, double nominal) {
  const char* unit = nullptr;
  if (IsNearFactor(std::fabs(ratio), nominal)) unit = "deg_s";
  if (IsNearFactor(std::fabs(ratio), nominal * kDegPerRad)) unit = "rad_s";
  if (unit == nullptr) return std::nullopt;
  const bool degrees = unit[0] == 'd';
  return fmt::format(
      "the unit: the values of {} are no counts but {}. {}, without gyro_lsb_per_deg_s",
      columns.Of("lsb"), degrees ? "deg/s" : "rad/s", columns.Name(unit));
}

}  // namespace

bool IsNearFactor(double value, double factor) {
  return std::fabs(value / factor - 1.0) < kNearFactor;
}

std::optional<std::string> OtherUnitOfGyro(double ratio, std::optional<char> axis,
                                           const MeasurementInfo& info) {
  const ColumnNames columns{axis};
  if (info.gyro_unit == RateUnit::kLsb)
    return NoCounts(ratio, columns, info.gyro_units_per_deg_s.value_or(kMissing));
  return OtherThanNamed(ratio, columns, info.gyro_unit == RateUnit::kRadPerSecond);
}

std::optional<std::string> OtherUnitOfReference(double ratio, const MeasurementInfo& info) {
  const bool angles = info.reference == ReferenceKind::kStandAngles ||
                      info.reference == ReferenceKind::kSensorAngle;
  if (!angles) return std::nullopt;
  const double size = std::fabs(ratio);
  if (IsNearFactor(size, 1.0 / kDegPerRad)) {
    return "the unit of the reference, the factor is that of degrees and radians: its angles, "
           "whose columns say deg, are in radians. Multiply them by 57.29578";
  }
  if (IsNearFactor(size, 1.0 / 360.0)) {
    return "the unit of the reference, the factor is 360: its angles, whose columns say deg, are "
           "in turns. Multiply them by 360";
  }
  if (IsNearFactor(size, kThousand)) {
    return "the unit of the reference, the factor is 1000: its angles, whose columns say deg, are "
           "in thousandths of a degree. Divide them by 1000";
  }
  return std::nullopt;
}

std::optional<std::string> OtherUnitOfAccelerometer(double size_g) {
  const auto is = [&](double factor) { return std::fabs(size_g / factor - 1.0) < kNearGravity; };
  if (is(kStandardGravity)) {
    return "the values are in m/s^2, and not in g = 9.80665 m/s^2 as the names of the columns say: "
           "name them accel_x_m_s2, accel_y_m_s2 and accel_z_m_s2";
  }
  if (is(1.0 / kStandardGravity)) {
    return "the values are in g = 9.80665 m/s^2, and not in m/s^2 as the names of the columns say: "
           "name them accel_x_g, accel_y_g and accel_z_g";
  }
  if (is(kThousand)) {
    return "the values are in mg, and not in g as the names of the columns accel_x_g, accel_y_g "
           "and accel_z_g say: divide them by 1000";
  }
  if (is(kThousand / kStandardGravity)) {
    return "the values are in mg, and not in m/s^2 as the names of the columns say: divide them by "
           "1000, and name them accel_x_g, accel_y_g and accel_z_g";
  }
  return std::nullopt;
}

}  // namespace gyrobench::calibration
