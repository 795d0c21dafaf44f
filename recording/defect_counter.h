// Defects counted by kind and column, the place of the first one kept.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::recording {

class DefectCounter {
 public:
  // A thing to be counted; returns its number.
  std::size_t Add(std::string kind) {
    defects_.push_back({std::move(kind), 0, kMissing, {}});
    return defects_.size() - 1;
  }
  // `where` is called for the first one only: counting allocates nothing after that.
  template <typename Where>
  void Count(std::size_t number, double t_s, const Where& where) {
    Defect& defect = defects_[number];
    if (defect.count++ > 0) return;
    defect.first_t_s = t_s;
    defect.where = where();
  }
  std::vector<Defect> Found() const {
    std::vector<Defect> found;
    for (const Defect& defect : defects_) {
      if (defect.count > 0) found.push_back(defect);
    }
    return found;
  }

 private:
  std::vector<Defect> defects_;
};

}  // namespace gyrobench::recording
