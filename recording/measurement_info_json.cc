#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "recording/plausible.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

namespace {

using nlohmann::json;

constexpr std::array<const char*, 3> kUnits = {"lsb", "deg_s", "rad_s"};
constexpr std::array<const char*, 4> kReferences = {"none", "stand_angles", "sensor_angle",
                                                    "orientation"};
constexpr std::array<const char*, 3> kSensorAxes = {"x", "y", "z"};
constexpr std::array<const char*, 3> kStandAxes = {"outer", "middle", "inner"};

// On one line, cut when long.
std::string Shown(const json& value) {
  constexpr std::size_t kShown = 80;
  const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return text.size() > kShown ? text.substr(0, kShown) + "..." : text;
}

template <std::size_t N>
std::size_t IndexOf(const std::array<const char*, N>& names, const std::string& key,
                    const json& value) {
  for (std::size_t i = 0; i < N; ++i) {
    if (value == names[i]) return i;
  }
  std::string expected;
  for (const char* name : names) expected += (expected.empty() ? "" : ", ") + std::string(name);
  throw DataError(
      fmt::format("measurement.{} = {}: expected one of {}", key, Shown(value), expected));
}

json PresentToJson(const std::array<bool, 3>& present, const std::array<const char*, 3>& names) {
  json list = json::array();
  for (std::size_t i = 0; i < 3; ++i) {
    if (present.at(i)) list.push_back(names.at(i));
  }
  return list;
}

// Reads one key after the other out of one object.
class Fields {
 public:
  explicit Fields(const json& object) : object_(object) {
    if (!object.is_object())
      throw DataError("measurement: expected an object, found " + Shown(object));
  }
  template <typename Value>
  void Read(const char* key, Value& value) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return;
    try {
      found->get_to(value);
    } catch (const json::exception& error) {
      throw DataError(fmt::format("measurement.{} = {}: {}", key, Shown(*found), error.what()));
    }
  }
  void ReadNumber(const char* key, double min, double max, double& value) const {
    double number = value;
    Read(key, number);
    if (!(number >= min && number <= max)) {
      throw DataError(
          fmt::format("measurement.{} = {}: expected a number {} .. {}", key, number, min, max));
    }
    value = number;
  }
  void ReadNumber(const char* key, double min, double max, std::optional<double>& value) const {
    if (object_.contains(key)) ReadNumber(key, min, max, value.emplace(kMissing));
  }
  template <typename Enum, std::size_t N>
  void ReadEnum(const char* key, const std::array<const char*, N>& names, Enum& value) const {
    const auto found = object_.find(key);
    if (found != object_.end()) value = static_cast<Enum>(IndexOf(names, key, *found));
  }
  void ReadPresent(const char* key, const std::array<const char*, 3>& names,
                   std::array<bool, 3>& present) const {
    json list = json::array();
    Read(key, list);
    for (const json& name : list) present.at(IndexOf(names, key, name)) = true;
  }

 private:
  const json& object_;
};

}  // namespace

json ToJson(const MeasurementInfo& info) {
  json out = {{"source", info.source},
              {"gyro_unit", kUnits.at(static_cast<std::size_t>(info.gyro_unit))},
              {"gyro", PresentToJson(info.gyro_present, kSensorAxes)},
              {"accel", PresentToJson(info.accel_present, kSensorAxes)},
              {"temperature", info.temperature_present},
              {"reference", kReferences.at(static_cast<std::size_t>(info.reference))},
              {"stand_axes", PresentToJson(info.stand_axis_present, kStandAxes)},
              {"reference_axis", kSensorAxes.at(static_cast<std::size_t>(info.reference_axis))},
              {"site_heading_deg", info.site_heading_deg},
              {"gyro_delay_s", info.gyro_delay_s},
              {"ref_delay_s", info.reference_delay_s},
              {"sensor", info.sensor},
              {"power_on", info.power_on},
              {"notes", info.notes},
              {"covariates", info.covariates}};
  const auto add = [&out](const char* key, const std::optional<double>& value) {
    if (value) out[key] = *value;
  };
  add("gyro_units_per_deg_s", info.gyro_units_per_deg_s);
  StandGeometry geometry = info.geometry;
  for (const GeometryAngle& angle : AnglesOf(geometry)) out[angle.name] = *angle.value_deg;
  add("site_latitude_deg", info.site_latitude_deg);
  add("gyro_lsb_zero", info.gyro_lsb_zero);
  add("accel_lsb_zero", info.accel_lsb_zero);
  add("ref_scale_uncertainty", info.reference_uncertainty.scale);
  add("ref_eccentricity_deg", info.reference_uncertainty.eccentricity_deg);
  add("ref_alignment_deg", info.reference_uncertainty.alignment_deg);
  add("gear_ratio", info.gear_ratio);
  add("stop_accuracy_deg", info.stop_accuracy_deg);
  if (info.power_on_utime) out["power_on_utime"] = *info.power_on_utime;
  return out;
}

MeasurementInfo MeasurementInfoFromJson(const json& object) {
  const Fields fields(object);
  MeasurementInfo info;
  fields.Read("source", info.source);
  fields.ReadEnum("gyro_unit", kUnits, info.gyro_unit);
  fields.ReadPresent("gyro", kSensorAxes, info.gyro_present);
  fields.ReadPresent("accel", kSensorAxes, info.accel_present);
  fields.Read("temperature", info.temperature_present);
  fields.ReadEnum("reference", kReferences, info.reference);
  fields.ReadPresent("stand_axes", kStandAxes, info.stand_axis_present);
  fields.ReadEnum("reference_axis", kSensorAxes, info.reference_axis);
  for (const auto& [name, value_deg, limit_deg] : AnglesOf(info.geometry))
    fields.ReadNumber(name, -limit_deg, limit_deg, *value_deg);
  fields.ReadNumber("site_heading_deg", -360.0, 360.0, info.site_heading_deg);
  fields.ReadNumber("gyro_delay_s", 0.0, kLongestDelay_s, info.gyro_delay_s);
  fields.ReadNumber("ref_delay_s", 0.0, kLongestDelay_s, info.reference_delay_s);
  fields.Read("sensor", info.sensor);
  fields.Read("power_on", info.power_on);
  if (object.contains("power_on_utime"))
    fields.Read("power_on_utime", info.power_on_utime.emplace(0));
  fields.Read("notes", info.notes);
  fields.Read("covariates", info.covariates);
  fields.ReadNumber("gyro_units_per_deg_s", kSmallestFactor, kLargestFactor,
                    info.gyro_units_per_deg_s);
  fields.ReadNumber("site_latitude_deg", -90.0, 90.0, info.site_latitude_deg);
  fields.ReadNumber("gyro_lsb_zero", 0.0, kLargestZero, info.gyro_lsb_zero);
  fields.ReadNumber("accel_lsb_zero", 0.0, kLargestZero, info.accel_lsb_zero);
  ReferenceUncertainty& reference = info.reference_uncertainty;
  fields.ReadNumber("ref_scale_uncertainty", 0.0, kLargestScaleUncertainty, reference.scale);
  fields.ReadNumber("ref_eccentricity_deg", 0.0, kLargestBound_deg, reference.eccentricity_deg);
  fields.ReadNumber("ref_alignment_deg", 0.0, kLargestBound_deg, reference.alignment_deg);
  fields.ReadNumber("gear_ratio", kSmallestFactor, kLargestFactor, info.gear_ratio);
  fields.ReadNumber("stop_accuracy_deg", kSmallestFactor, kLargestFactor, info.stop_accuracy_deg);
  return info;
}

}  // namespace gyrobench::recording
