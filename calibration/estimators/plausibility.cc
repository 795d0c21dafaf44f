#include "calibration/estimators/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/geometry.h"
#include "calibration/estimators/exchanged_axes.h"
#include "calibration/signal/clock_offset.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/turns_by_gyro.h"
#include "calibration/signal/wrong_unit.h"

namespace gyrobench::calibration {
namespace {

// Ratio of true rate to felt rate where nothing is felt.
constexpr double kFeelsNothing = std::numeric_limits<double>::infinity();

// Ranges of one sensor are each twice the next.
std::optional<int> PowerOfTwo(double factor) {
  for (const int power : {-3, -2, -1, 1, 2, 3}) {
    if (IsNearFactor(factor, std::exp2(power))) return power;
  }
  return std::nullopt;
}

// Of the gyro, its mounting, or a reference in degrees that counts wrong, by a factor that one
// mistake makes. `ratio`: true rate by the reference over rate by the gyro's nominal sensitivity.
std::optional<std::string> OtherFactor(double ratio, char axis, const MeasurementInfo& info) {
  if (IsNearFactor(ratio, -1.0)) {
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
  std::optional<std::string> unit = OtherUnitOfGyro(ratio, axis, info);
  if (counts && !unit &&
      (IsNearFactor(ratio, kDegPerRad) || IsNearFactor(ratio, 1.0 / kDegPerRad))) {
    return fmt::format(
        "the unit, the factor is that of degrees and radians: the sensitivity of gyro_{}_lsb is of "
        "the other one. Check gyro_lsb_per_deg_s of the device map or table",
        axis);
  }
  if (info.gear_ratio && (IsNearFactor(std::fabs(ratio), std::fabs(*info.gear_ratio)) ||
                          IsNearFactor(std::fabs(ratio), 1.0 / std::fabs(*info.gear_ratio)))) {
    return "the factor is the gear ratio: the reference counts turns of the shaft where turns of "
           "the table are expected, or the other way round. Check the encoder's place and "
           "counts_per_turn";
  }
  return unit;
}

// Of any other factor.
std::string LooseOrElsewhere(double ratio, char axis) {
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

// What one mistake makes of the ratio; nullopt where none does.
std::optional<std::string> CauseOfFactor(double ratio, char axis, const MeasurementInfo& info) {
  const std::optional<std::string> unit = OtherUnitOfReference(ratio, info);
  if (!unit) return OtherFactor(ratio, axis, info);
  return fmt::format("{}; or, where they are in degrees, {}", *unit,
                     OtherFactor(ratio, axis, info).value_or(LooseOrElsewhere(ratio, axis)));
}

std::string LikeliestCause(double ratio, char axis, const MeasurementInfo& info) {
  return CauseOfFactor(ratio, axis, info).value_or(LooseOrElsewhere(ratio, axis));
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

// Four digits, and no power of ten below a million.
std::string PercentText(double percent) {
  const double size = std::fabs(percent);
  return size < 1e3 || size > 1e6 ? fmt::format("{:.4g}", percent) : fmt::format("{:.0f}", percent);
}

bool IsImplausible(double ratio) {
  return !std::isnan(ratio) && std::fabs(ratio - 1.0) > kLargestScaleError;
}

std::string CauseAmong(const std::vector<Defect>& defects) {
  const bool stood = std::ranges::any_of(
      defects, [](const Defect& defect) { return defect.kind == "turned_at_rest"; });
  return stood ? "the reference stands for a part of the time in which the gyro turns (defect "
                 "turned_at_rest). Check its connection and its supply"
               : "";
}

}  // namespace

std::vector<std::string> FaultsIn(const Recording& recording) {
  std::vector<std::string> faults;
  for (const Defect& defect : recording.defects) {
    if (defect.kind != kTurnsUnknown) continue;
    faults.push_back(fmt::format(
        "the angle of the reference never leaves one turn and steps by more than half of one "
        "between two readings ({} times, first at {:.1f} s): it is wrapped at 180 or 360 deg, and "
        "read too seldom for its turns to be told; the gyro, as it is declared, does not tell them "
        "either. Let the column run on beyond 180 or 360 deg, or log the reference at least 5 "
        "times a second",
        defect.count, defect.first_t_s));
  }
  if (std::string says = TurnsWithoutReference(recording); !says.empty())
    faults.push_back(std::move(says));
  if (const auto offset = FindClockOffset(recording); offset && Contradicts(*offset))
    faults.push_back(RemarkOnClocks(recording.info, *offset));
  if (std::string says = FollowedByAnotherAlone(recording.info, recording.columns); !says.empty())
    faults.push_back(std::move(says));
  if (std::string says = UnitChangeWithin(recording.columns); !says.empty())
    faults.push_back(std::move(says));
  return faults;
}

std::string CauseIn(const Recording& recording, SensorAxis axis) {
  if (std::string says = OtherConvention(recording.info, recording.columns); !says.empty())
    return says;
  if (std::string says = FollowedByAnother(recording.columns, axis); !says.empty()) return says;
  const std::optional<double> output = FollowedSensitivity(recording.columns, axis);
  if (!output) return "";
  const double ratio = NominalUnitsPerDegPerS(recording.info) / *output;
  if (!IsImplausible(ratio)) return "";
  return CauseOfFactor(ratio, "xyz"[static_cast<std::size_t>(axis)], recording.info).value_or("");
}

std::optional<std::string> ImplausibleScale(double ratio, SensorAxis axis,
                                            std::span<const MeasurementInfo* const> inputs,
                                            const std::string& cause_in_data,
                                            const std::vector<Defect>& defects) {
  if (!IsImplausible(ratio)) return std::nullopt;
  const char name = "xyz"[static_cast<std::size_t>(axis)];
  std::string cause = cause_in_data.empty() ? CauseAmong(defects) : cause_in_data;
  if (cause.empty()) cause = LikeliestCauses(ratio, name, inputs);
  return fmt::format(
      "this result cannot be: the scale error of gyro {} is {} %, at most {:g} % was expected "
      "of any part. Most likely {}",
      name, PercentText(100.0 * (ratio - 1.0)), 100.0 * kLargestScaleError, cause);
}

std::vector<SensorAxis> ImplausibleAxes(const AnalysisResult& result) {
  std::vector<SensorAxis> axes;
  for (const ScaleResult& scale : result.scale) {
    if (IsImplausible(1.0 + scale.scale_error)) axes.push_back(scale.axis);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (result.unfollowed_deg[c] > 0.0) axes.push_back(static_cast<SensorAxis>(c));
  }
  return axes;
}

std::vector<Contradiction> Contradictions(const AnalysisResult& result) {
  std::vector<Contradiction> out;
  for (const std::string& fault : result.faults)
    out.push_back({{true, true, true}, "this result cannot be: " + fault});
  if (!out.empty() || !result.two_clocks.empty()) return out;
  const auto add = [&](SensorAxis axis, std::string says) {
    out.push_back({{}, std::move(says)});
    out.back().axes[static_cast<std::size_t>(axis)] = true;
  };
  const MeasurementInfo* const info = &result.info;
  for (const ScaleResult& scale : result.scale) {
    if (auto says =
            ImplausibleScale(1.0 + scale.scale_error, scale.axis, std::span(&info, 1),
                             result.cause[static_cast<std::size_t>(scale.axis)], result.defects))
      add(scale.axis, std::move(*says));
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (result.unfollowed_deg[c] <= 0.0) continue;
    const std::string& cause = result.cause[c];
    add(static_cast<SensorAxis>(c),
        fmt::format("this result cannot be: the {0} axis of the sensor turned by {1:.4g} deg by "
                    "the reference, and the gyro's output did not follow it. Most likely {2}",
                    "xyz"[c], result.unfollowed_deg[c],
                    cause.empty() ? LikeliestCause(kFeelsNothing, "xyz"[c], result.info) : cause));
  }
  return out;
}

std::vector<std::string> Implausible(const AnalysisResult& result) {
  std::vector<std::string> out;
  for (Contradiction& one : Contradictions(result)) out.push_back(std::move(one.says));
  return out;
}

}  // namespace gyrobench::calibration
