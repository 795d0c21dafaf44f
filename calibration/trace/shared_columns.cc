#include "calibration/trace/shared_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calibration/effects/effect.h"
#include "calibration/state/history_parts.h"
#include "calibration/state/slow_quantity.h"

namespace gyrobench::calibration {
namespace {

// A column whose range is a smaller part of its size hardly changes: an effect of it is not shown.
constexpr double kLeastRange = 0.01;

struct Range {
  double low = kMissing, high = kMissing;
  void Add(double value) {
    low = std::fmin(low, value);
    high = std::fmax(high, value);
  }
  bool is_constant() const { return !(high > low); }
  bool is_narrow() const {
    return high - low < kLeastRange * std::fmax(std::fabs(low), std::fabs(high));
  }
};

bool Has(const Recording& recording, const std::string& name) {
  const std::vector<std::string>& names = recording.info.covariates;
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Of each measurement the nodes at which everything taken so far can be told.
class Tellable {
 public:
  explicit Tellable(std::span<const Recording* const> recordings) : recordings_(recordings) {
    for (const Recording* recording : recordings_) {
      times_.push_back(NodeTimes(*recording));
      nodes_.emplace_back(times_.back().size(), true);
      const std::vector<bool> temperature = Of(nodes_.size() - 1, TemperatureOf(*recording));
      if (TellableShare(times_.back(), temperature) >= kLeastKnownShare)
        nodes_.back() = temperature;
    }
  }
  // False, and why, where too little would be left with the column.
  bool Take(const std::string& name, std::vector<std::string>* remarks) {
    std::vector<std::vector<bool>> with = nodes_;
    for (std::size_t r = 0; r < recordings_.size(); ++r) {
      const std::vector<bool> alone = Of(r, CovariateOf(*recordings_[r], name));
      for (std::size_t k = 0; k < alone.size(); ++k) with[r][k] = with[r][k] && alone[k];
      const double share = TellableShare(times_[r], alone);
      if (share < kLeastKnownShare) {
        remarks->push_back(fmt::format(
            "{}: column {} is known for {:.0f} % of the time, less than half: nothing is traced "
            "to it",
            recordings_[r]->info.source, name, 100.0 * share));
        return false;
      }
      if (TellableShare(times_[r], with[r]) < kLeastKnownShare) {
        remarks->push_back(fmt::format(
            "{}: where column {} is known, other columns are missing: too little of the time has "
            "them all, nothing is traced to it",
            recordings_[r]->info.source, name));
        return false;
      }
    }
    nodes_ = std::move(with);
    return true;
  }

 private:
  std::vector<bool> Of(std::size_t r, const std::vector<double>& value) const {
    return TellableTimes(times_[r], value);
  }

  std::span<const Recording* const> recordings_;
  std::vector<std::vector<double>> times_;
  std::vector<std::vector<bool>> nodes_;
};

Range RangeOf(std::span<const Recording* const> recordings, const std::string& name) {
  Range range;
  for (const Recording* recording : recordings)
    for (const double value : CovariateOf(*recording, name)) range.Add(value);
  return range;
}

void ListUnidentifiable(const std::string& name, const Range& range,
                        std::vector<Unidentifiable>* out) {
  const std::string because = range.is_constant()
                                  ? fmt::format("column {} stays at {:.6g}", name, range.low)
                                  : fmt::format("column {} hardly changes, from {:.6g} to {:.6g}",
                                                name, range.low, range.high);
  for (const Effect& effect : EffectCatalogue()) {
    if ((effect.needs & kNeedsCovariate) == 0) continue;
    const std::string id = fmt::format("{}({})", effect.id, name);
    out->push_back({id, because, ManoeuvreOf(id)});
  }
}

}  // namespace

SharedColumns FindSharedColumns(std::span<const Recording* const> recordings,
                                std::vector<std::string>* remarks) {
  std::set<std::string> all;
  for (const Recording* recording : recordings)
    all.insert(recording->info.covariates.begin(), recording->info.covariates.end());
  SharedColumns out;
  Tellable tellable(recordings);
  for (const std::string& name : all) {
    const bool everywhere = std::all_of(recordings.begin(), recordings.end(),
                                        [&](const Recording* r) { return Has(*r, name); });
    if (!everywhere) {
      remarks->push_back(
          fmt::format("column {} is not in all files: nothing is traced to it", name));
      continue;
    }
    const Range range = RangeOf(recordings, name);
    if (range.is_constant() && !std::isfinite(range.low)) {
      remarks->push_back(fmt::format("column {} is empty: nothing is traced to it", name));
      continue;
    }
    if (range.is_narrow() || range.is_constant())
      ListUnidentifiable(name, range, &out.unidentifiable);
    if (!range.is_constant() && tellable.Take(name, remarks)) out.names.push_back(name);
  }
  return out;
}

}  // namespace gyrobench::calibration
