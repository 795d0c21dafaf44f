// Products of columns with each other once they are white, without the white columns themselves:
// all that likelihoods ask for.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "calibration/gls/filled_columns.h"
#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

// Columns in pieces of some rows, and which of them are not 0 there: constants of other power-ons
// cost nothing.
class ColumnsInChunks {
 public:
  ColumnsInChunks() = default;
  explicit ColumnsInChunks(RowMajor columns);

  const RowMajor& all() const { return columns_; }
  std::size_t chunks() const { return not_zero_.size(); }
  auto rows(std::size_t chunk) const {
    const Eigen::Index begin = static_cast<Eigen::Index>(chunk) * kStretchRows;
    return columns_.middleRows(begin, std::min(kStretchRows, columns_.rows() - begin));
  }
  const std::vector<Eigen::Index>& not_zero(std::size_t chunk) const { return not_zero_[chunk]; }

 private:
  RowMajor columns_;
  std::vector<std::vector<Eigen::Index>> not_zero_;  // of each chunk
};

struct WhiteProducts {
  Eigen::MatrixXd products;  // columns x columns
  double log_det = 0.0;      // of the covariance of the output
};

// `columns`: a row each interval; they stay as they are.
WhiteProducts ProductsUnder(std::span<const Interval> intervals, const ColumnsInChunks& columns,
                            const NoiseModel& noise);
// The same of each noise, to the last digit, in less time than one after the other.
std::vector<WhiteProducts> ProductsUnder(std::span<const Interval> intervals,
                                         const ColumnsInChunks& columns,
                                         std::span<const NoiseModel> noises);

}  // namespace gyrobench::calibration
