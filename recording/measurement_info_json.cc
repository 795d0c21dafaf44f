#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>

#include "base/error.h"
#include "base/measurement_fields.h"
#include "recording/plausible.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

namespace {

using nlohmann::json;

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

// Writes one key after the other; what is not known is left out.
class Writer {
 public:
  template <typename T>
  using Field = const T;

  template <typename T, typename... Bounds>
  void operator()(const char* key, const T& value, const Bounds&... /*bounds*/) {
    object_[key] = value;
  }
  template <typename T, typename... Bounds>
  void operator()(const char* key, const std::optional<T>& value, const Bounds&... /*bounds*/) {
    if (value) object_[key] = *value;
  }
  template <typename Enum, std::size_t N>
  void Named(const char* key, Enum value, const std::array<const char*, N>& names) {
    object_[key] = names.at(static_cast<std::size_t>(value));
  }
  void Present(const char* key, const std::array<bool, 3>& present,
               const std::array<const char*, 3>& names) {
    json& list = object_[key] = json::array();
    for (std::size_t i = 0; i < 3; ++i) {
      if (present.at(i)) list.push_back(names.at(i));
    }
  }
  json Take() { return std::move(object_); }

 private:
  json object_ = json::object();
};

// Reads one key after the other out of one object; a field whose key is not there stays as it is.
class Reader {
 public:
  template <typename T>
  using Field = T;

  explicit Reader(const json& object) : object_(object) {
    if (!object.is_object())
      throw DataError("measurement: expected an object, found " + Shown(object));
  }
  template <typename T>
  void operator()(const char* key, T& value) const {
    const auto found = object_.find(key);
    if (found == object_.end()) return;
    try {
      found->get_to(value);
    } catch (const json::exception& error) {
      throw DataError(fmt::format("measurement.{} = {}: {}", key, Shown(*found), error.what()));
    }
  }
  void operator()(const char* key, double& value, double min, double max) const {
    double number = value;
    (*this)(key, number);
    if (!(number >= min && number <= max)) {
      throw DataError(
          fmt::format("measurement.{} = {}: expected a number {} .. {}", key, number, min, max));
    }
    value = number;
  }
  template <typename T, typename... Bounds>
  void operator()(const char* key, std::optional<T>& value, const Bounds&... bounds) const {
    if (object_.contains(key)) (*this)(key, value.emplace(), bounds...);
  }
  template <typename Enum, std::size_t N>
  void Named(const char* key, Enum& value, const std::array<const char*, N>& names) const {
    const auto found = object_.find(key);
    if (found != object_.end()) value = static_cast<Enum>(IndexOf(names, key, *found));
  }
  void Present(const char* key, std::array<bool, 3>& present,
               const std::array<const char*, 3>& names) const {
    json list = json::array();
    (*this)(key, list);
    for (const json& name : list) present.at(IndexOf(names, key, name)) = true;
  }

 private:
  const json& object_;
};

template <typename Visitor>
void GeometryFields(Visitor& field, FieldsOf<Visitor, StandGeometry>& geometry) {
  StandGeometry angles = geometry;
  for (const auto& [name, value_deg, limit_deg] : AnglesOf(angles))
    field(name, *value_deg, -limit_deg, limit_deg);
  if constexpr (!std::is_const_v<FieldsOf<Visitor, StandGeometry>>) geometry = angles;
}

template <typename Visitor>
void InfoFields(Visitor& field, FieldsOf<Visitor, MeasurementInfo>& info) {
  field("source", info.source);
  field.Named("gyro_unit", info.gyro_unit, kRateUnitNames);
  field.Present("gyro", info.gyro_present, kSensorAxisNames);
  field.Present("accel", info.accel_present, kSensorAxisNames);
  field("temperature", info.temperature_present);
  field.Named("reference", info.reference, kReferenceKindNames);
  field.Present("stand_axes", info.stand_axis_present, kStandAxisNames);
  field.Named("reference_axis", info.reference_axis, kSensorAxisNames);
  GeometryFields(field, info.geometry);
  field("site_heading_deg", info.site_heading_deg, -360.0, 360.0);
  field("gyro_delay_s", info.gyro_delay_s, 0.0, kLongestDelay_s);
  field("ref_delay_s", info.reference_delay_s, 0.0, kLongestDelay_s);
  field("sensor", info.sensor);
  field("power_on", info.power_on);
  field("power_on_utime", info.power_on_utime);
  field("notes", info.notes);
  field("covariates", info.covariates);
  field("gyro_units_per_deg_s", info.gyro_units_per_deg_s, kSmallestFactor, kLargestFactor);
  field("site_latitude_deg", info.site_latitude_deg, -90.0, 90.0);
  field("gyro_lsb_zero", info.gyro_lsb_zero, 0.0, kLargestZero);
  field("accel_lsb_zero", info.accel_lsb_zero, 0.0, kLargestZero);
  auto& reference = info.reference_uncertainty;
  field("ref_scale_uncertainty", reference.scale, 0.0, kLargestScaleUncertainty);
  field("ref_eccentricity_deg", reference.eccentricity_deg, 0.0, kLargestBound_deg);
  field("ref_alignment_deg", reference.alignment_deg, 0.0, kLargestBound_deg);
  field("gear_ratio", info.gear_ratio, kSmallestFactor, kLargestFactor);
  field("stop_accuracy_deg", info.stop_accuracy_deg, kSmallestFactor, kLargestFactor);
}

}  // namespace

json ToJson(const MeasurementInfo& info) {
  Writer writer;
  InfoFields(writer, info);
  return writer.Take();
}

MeasurementInfo MeasurementInfoFromJson(const json& object) {
  MeasurementInfo info;
  const Reader reader(object);
  InfoFields(reader, info);
  return info;
}

}  // namespace gyrobench::recording
