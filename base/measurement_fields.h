// How parts of a measurement are named in JSON, and the lists of their fields.
#pragma once

#include <array>
#include <type_traits>

#include "base/json_fields.h"
#include "base/measurement.h"

namespace gyrobench {

// In the order of the enumerations.
inline constexpr std::array<const char*, 3> kSensorAxisNames = {"x", "y", "z"};
inline constexpr std::array<const char*, 3> kStandAxisNames = {"outer", "middle", "inner"};
inline constexpr std::array<const char*, 3> kRateUnitNames = {"lsb", "deg_s", "rad_s"};
inline constexpr std::array<const char*, 4> kReferenceKindNames = {"none", "stand_angles",
                                                                   "sensor_angle", "orientation"};

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, Defect>& defect) {
  field("kind", defect.kind);
  field("count", defect.count);
  field("first_t_s", defect.first_t_s);
  field("where", defect.where);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, StandGeometry>& geometry) {
  StandGeometry angles = geometry;
  for (const GeometryAngle& angle : AnglesOf(angles)) field(angle.name, *angle.value_deg);
  if constexpr (!std::is_const_v<FieldsOf<Visitor, StandGeometry>>) geometry = angles;
}

}  // namespace gyrobench
