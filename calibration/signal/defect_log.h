// Defects of the data by kind and place, counted as they are met.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::calibration {

class DefectLog {
 public:
  // One row per kind and `where`; the first time stays.
  void Add(std::string_view kind, std::string_view where, double t_s, std::int64_t count = 1);
  const std::vector<Defect>& defects() const { return defects_; }

 private:
  std::vector<Defect> defects_;
};

}  // namespace gyrobench::calibration
