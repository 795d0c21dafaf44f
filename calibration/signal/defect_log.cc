#include "calibration/signal/defect_log.h"

#include <algorithm>
#include <limits>

namespace gyrobench::calibration {

void DefectLog::Add(std::string_view kind, std::string_view where, double t_s, std::int64_t count) {
  for (Defect& defect : defects_) {
    if (defect.kind == kind && defect.where == where) {
      // Damaged files announce counts that no sum could hold.
      defect.count += std::min(count, std::numeric_limits<std::int64_t>::max() - defect.count);
      return;
    }
  }
  defects_.push_back(Defect{std::string(kind), count, t_s, std::string(where)});
}

}  // namespace gyrobench::calibration
