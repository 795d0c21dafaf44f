// An offset that is another in each group of rows, such as each rest of a stand that turned between
// them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/gls/interval_gls.h"
#include "calibration/gls/noise_fit.h"

namespace gyrobench::calibration {

// y = X theta + u_g dt + noise of the interval, u_g ~ spread^2, drawn once for each group. A bias
// random walk alone would have to walk as far within a group as from one to the next, and the angle
// random walk would have to be less than it is for the sum to be what is seen.
struct GroupNoise {
  NoiseModel noise;
  double spread_deg_s = 0.0;
  std::size_t groups = 0;
};

class GroupedOffsets {
 public:
  // All intervals still, in groups of neighbours; `group`: of each, from 0. More groups than
  // kMostGroups are taken together, neighbours with neighbours. `duration`: the column that is the
  // time of each interval [s], which the offsets have as well.
  GroupedOffsets(const IntervalSeries& series, const std::vector<std::size_t>& group, int duration,
                 int output);

  // Noise and spread by restricted maximum likelihood. nullopt where the groups do not differ by
  // more than walk and noise explain, or there are not enough of them to say so.
  std::optional<GroupNoise> Find(const std::vector<int>& regressors) const;
  // Generalised least squares under it; the errors contain the spread.
  GlsSolution Solve(const GroupNoise& noise, const std::vector<int>& regressors) const;

  static constexpr std::size_t kMostGroups = 60;

 private:
  struct Products;  // of the white columns: regressors, groups, output
  struct Profile;
  Products At(double walk, const std::vector<int>& regressors) const;
  Profile ProfileOf(const Products& products, double log_spread) const;
  bool Differ(const std::vector<int>& regressors) const;

  std::vector<Interval> intervals_;
  RowMajor values_;  // the mean offset taken off the output
  Eigen::MatrixXd groups_;
  int duration_, output_;
  double mean_ = 0.0;
};

}  // namespace gyrobench::calibration
