#include "calibration/estimators/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "base/geometry.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

bool IsNear(double value, double factor) { return std::fabs(value / factor - 1.0) < kNearFactor; }

// Ratio of true rate to felt rate where nothing is felt.
constexpr double kFeelsNothing = std::numeric_limits<double>::infinity();

// Ranges of one sensor are each twice the next.
std::optional<int> PowerOfTwo(double factor) {
  for (const int power : {-3, -2, -1, 1, 2, 3}) {
    if (IsNear(factor, std::exp2(power))) return power;
  }
  return std::nullopt;
}

// LSB per deg/s of the gyros on the market: from 2000 deg/s to 125 deg/s in 16 bits, and finer.
constexpr double kLeastSensitivity = 10.0, kLargestSensitivity = 300.0;

std::string ColumnOf(char axis, const char* unit) { return fmt::format("gyro_{}_{}", axis, unit); }

// A column of a sensor that scales by itself, in another unit than its name says: what to do.
// `ratio`: true rate by the reference over rate by the column.
std::optional<std::string> OtherUnitThanNamed(double ratio, char axis, RateUnit named) {
  const bool radians = named == RateUnit::kRadPerSecond;
  const std::string column = ColumnOf(axis, radians ? "rad_s" : "deg_s");
  const double factor = radians ? 1.0 / kDegPerRad : kDegPerRad;
  if (IsNear(std::fabs(ratio), factor)) {
    return fmt::format(
        "the unit, the factor is that of degrees and radians: the values of {} are in {}. Name the "
        "column {}",
        column, radians ? "deg/s" : "rad/s", ColumnOf(axis, radians ? "deg_s" : "rad_s"));
  }
  const double counts = std::fabs((radians ? 1.0 / kDegPerRad : 1.0) / ratio);
  if (IsNear(counts, kDegPerRad)) {
    return fmt::format(
        "the unit: the values of {} were multiplied by the degrees of a radian once too often, or "
        "are counts of the converter. Check what wrote the table; counts belong into the column {}",
        column, ColumnOf(axis, "lsb"));
  }
  if (counts < kLeastSensitivity || counts > kLargestSensitivity) return std::nullopt;
  return fmt::format(
      "the unit: the values of {} are counts of the converter, about {:.0f} for each deg/s. Name "
      "the column {} and give the sensitivity above the header, as the data sheet states it: # "
      "gyro_lsb_per_deg_s = ...",
      column, 10.0 * std::round(0.1 * counts), ColumnOf(axis, "lsb"));
}

// The same of a column of counts.
std::optional<std::string> NoCounts(double ratio, char axis, const MeasurementInfo& info) {
  const char* unit = nullptr;
  const double nominal = info.gyro_units_per_deg_s.value_or(kMissing);
  if (IsNear(std::fabs(ratio), nominal)) unit = "deg_s";
  if (IsNear(std::fabs(ratio), nominal * kDegPerRad)) unit = "rad_s";
  if (unit == nullptr) return std::nullopt;
  return fmt::format(
      "the unit: the values of {} are no counts but {}. Name the column {}, without "
      "gyro_lsb_per_deg_s",
      ColumnOf(axis, "lsb"), std::string_view(unit) == "deg_s" ? "deg/s" : "rad/s",
      ColumnOf(axis, unit));
}

// Angles that count 57.3 times too little. A quaternion has no unit.
std::optional<std::string> ReferenceInRadians(double ratio, const MeasurementInfo& info) {
  const bool angles = info.reference == ReferenceKind::kStandAngles ||
                      info.reference == ReferenceKind::kSensorAngle;
  if (!angles || !IsNear(std::fabs(ratio), 1.0 / kDegPerRad)) return std::nullopt;
  return "the unit of the reference, the factor is that of degrees and radians: its angles, whose "
         "columns say deg, are in radians. Multiply them by 57.29578";
}

// Of the gyro, its mounting, or a reference in degrees that counts wrong. `ratio`: true rate by the
// reference over rate by the gyro's nominal sensitivity.
std::string LikeliestOfOthers(double ratio, char axis, const MeasurementInfo& info) {
  if (IsNear(ratio, -1.0)) {
    return fmt::format(
        "the two turn opposite ways: the {} axis points the other way than declared, or the "
        "reference counts the wrong way. Check the mounting (mount_x_deg, mount_y_deg, "
        "mount_z_deg) and the encoder's sign",
        axis);
  }
  if (PowerOfTwo(std::fabs(ratio))) {
    return "a factor of 2, 4 or 8: the sensor's range, and with it its sensitivity, is another "
           "than declared. Check range_deg_s, and gyro_lsb_per_deg_s of the device map or table";
  }
  const bool counts = info.gyro_unit == RateUnit::kLsb;
  const std::optional<std::string> unit =
      counts ? NoCounts(ratio, axis, info) : OtherUnitThanNamed(ratio, axis, info.gyro_unit);
  if (counts && !unit && (IsNear(ratio, kDegPerRad) || IsNear(ratio, 1.0 / kDegPerRad))) {
    return fmt::format(
        "the unit, the factor is that of degrees and radians: the sensitivity of {} is of the "
        "other one. Check gyro_lsb_per_deg_s of the device map or table",
        ColumnOf(axis, "lsb"));
  }
  if (info.gear_ratio && (IsNear(std::fabs(ratio), std::fabs(*info.gear_ratio)) ||
                          IsNear(std::fabs(ratio), 1.0 / std::fabs(*info.gear_ratio)))) {
    return "the factor is the gear ratio: the reference counts turns of the shaft where turns of "
           "the table are expected, or the other way round. Check the encoder's place and "
           "counts_per_turn";
  }
  if (unit) return *unit;
  if (std::fabs(ratio) > 1.0) {
    return fmt::format(
        "the {} axis hardly feels what the reference turns: the sensor is not mounted as declared, "
        "or not on the table that turns. Check the mounting (mount_x_deg, mount_y_deg, "
        "mount_z_deg) and the wiring of the gyro",
        axis);
  }
  return fmt::format(
      "the {} axis feels more than the reference turns: the reference is loose or counts too few "
      "counts a turn, or the sensitivity is not the declared one. Check the encoder's coupling, "
      "counts_per_turn and range_deg_s",
      axis);
}

// `ratio`: as above.
std::string LikeliestCause(double ratio, char axis, const MeasurementInfo& info) {
  const std::optional<std::string> radians = ReferenceInRadians(ratio, info);
  const std::string other = LikeliestOfOthers(ratio, axis, info);
  return radians ? fmt::format("{}; or, where they are in degrees, {}", *radians, other) : other;
}

// Each cause once, with the first of the inputs that allow it where there are several.
std::string LikeliestCauses(double ratio, char axis,
                            std::span<const MeasurementInfo* const> inputs) {
  std::vector<std::pair<std::string, const MeasurementInfo*>> causes;
  for (const MeasurementInfo* info : inputs) {
    std::string cause = LikeliestCause(ratio, axis, *info);
    if (std::ranges::none_of(causes, [&](const auto& one) { return one.first == cause; }))
      causes.emplace_back(std::move(cause), info);
  }
  if (causes.size() == 1) return causes.front().first;
  std::string text;
  for (const auto& [cause, info] : causes)
    text += fmt::format("{}by what {} says: {}", text.empty() ? "" : "; or ", info->source, cause);
  return text;
}

}  // namespace

std::string CauseAmong(const std::vector<Defect>& defects) {
  const bool stood = std::ranges::any_of(
      defects, [](const Defect& defect) { return defect.kind == "turned_at_rest"; });
  return stood ? "the reference stands for a part of the time in which the gyro turns (defect "
                 "turned_at_rest). Check its connection and its supply"
               : "";
}

std::optional<std::string> ImplausibleScale(double ratio, SensorAxis axis,
                                            std::span<const MeasurementInfo* const> inputs,
                                            const std::string& known_cause) {
  const double scale_error = ratio - 1.0;
  if (std::isnan(scale_error) || std::fabs(scale_error) <= kLargestScaleError) return std::nullopt;
  const char name = "xyz"[static_cast<std::size_t>(axis)];
  return fmt::format(
      "this result cannot be: the scale error of gyro {} is {:.4g} %, at most {:g} % was expected "
      "of any part. Most likely {}",
      name, 100.0 * scale_error, 100.0 * kLargestScaleError,
      known_cause.empty() ? LikeliestCauses(ratio, name, inputs) : known_cause);
}

std::vector<SensorAxis> ImplausibleAxes(const AnalysisResult& result) {
  const MeasurementInfo* const info = &result.info;
  std::vector<SensorAxis> axes;
  for (const ScaleResult& scale : result.scale) {
    if (ImplausibleScale(1.0 + scale.scale_error, scale.axis, std::span(&info, 1)))
      axes.push_back(scale.axis);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (result.unfollowed_deg[c] > 0.0) axes.push_back(static_cast<SensorAxis>(c));
  }
  return axes;
}

std::vector<std::string> Implausible(const AnalysisResult& result) {
  if (!result.two_clocks.empty()) return {};
  const std::string of_defects = CauseAmong(result.defects);
  const MeasurementInfo* const info = &result.info;
  std::vector<std::string> out;
  for (const ScaleResult& scale : result.scale) {
    const std::string& another = result.followed_by_another[static_cast<std::size_t>(scale.axis)];
    const std::string& cause = another.empty() ? of_defects : another;
    if (std::optional<std::string> says =
            ImplausibleScale(1.0 + scale.scale_error, scale.axis, std::span(&info, 1), cause)) {
      out.push_back(std::move(*says));
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (result.unfollowed_deg[c] <= 0.0) continue;
    const std::string& another = result.followed_by_another[c];
    out.push_back(fmt::format(
        "this result cannot be: the {0} axis of the sensor turned by {1:.4g} deg by the reference, "
        "and the gyro's output did not follow it. Most likely {2}",
        "xyz"[c], result.unfollowed_deg[c],
        another.empty() ? LikeliestCause(kFeelsNothing, "xyz"[c], result.info) : another));
  }
  return out;
}

}  // namespace gyrobench::calibration
