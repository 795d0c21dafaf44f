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

// Columns in pieces of kStretchRows rows, of each of which only those columns are held that are not
// 0 in all of it: constants of other power-ons cost neither time nor memory.
class ColumnsInChunks {
 public:
  struct Chunk {
    std::vector<Eigen::Index> not_zero;  // columns, in rising order
    RowMajor values;                     // these columns, side by side
  };

  ColumnsInChunks() = default;
  explicit ColumnsInChunks(const Eigen::Ref<const RowMajor>& columns);

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  const std::vector<Chunk>& chunks() const { return chunks_; }
  // The columns of `stay`, which are in rising order and not the last one; after them the last one,
  // to which the others are added as often as `times` (all but the last) says.
  ColumnsInChunks WithLastPlus(const Eigen::VectorXd& times,
                               const std::vector<Eigen::Index>& stay) const;

 private:
  Eigen::Index rows_ = 0, cols_ = 0;
  std::vector<Chunk> chunks_;
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
