// A measurement table with the gyro's output corrected, all else as it was.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "calibration/artefact/corrector.h"

namespace gyrobench::cli {

struct CorrectedTable {
  std::int64_t rows = 0;
  std::int64_t without_time = 0;  // rows without a time, or with another number of fields
  calibration::CorrectionReport correction;
};

// Copies `table` to `output` line by line: gyro columns become gyro_<axis>_deg_s in the same place,
// the nominal sensitivity and the count of zero go from the comments and `made_by` is added to
// them; every other field is copied as it stands. A row without a time, or with fields too many or
// too few, keeps its place and loses its fields, so that no raw value passes for a corrected one.
// Memory does not grow with the table. `name`: of the table in messages. Throws DataError.
CorrectedTable WriteCorrectedTable(const std::filesystem::path& table, const std::string& name,
                                   const std::filesystem::path& output,
                                   const calibration::Calibration& calibration,
                                   const calibration::CorrectorOptions& options,
                                   const std::string& made_by,
                                   const std::function<void(double fraction)>& progress);

}  // namespace gyrobench::cli
