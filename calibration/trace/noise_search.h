// Noise of a problem by restricted maximum likelihood, and what an effect is worth when the noise
// may answer for it instead.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "calibration/interval_gls.h"

namespace gyrobench::calibration {

struct NoiseEstimate {
  IntervalNoise noise;
  double deviance = 0.0;  // -2 log of the restricted likelihood, without its constants
};

class NoiseSearch {
 public:
  // `columns`: rows x p, everything that may act, dependent ones allowed; a missing effect would
  // otherwise pass for noise. `piece_s`: stretches at rest are taken in pieces of this length,
  // which changes nothing that the noise could be told from.
  NoiseSearch(std::span<const Interval> intervals, const Eigen::MatrixXd& columns,
              const Eigen::VectorXd& output, double piece_s = kPiece_s);
  // With `tested` fitted too, under the likelihood that is restricted by `columns` alone: the
  // deviance may be compared with that of the search without them (Welham and Thompson 1997).
  NoiseSearch(std::span<const Interval> intervals, const Eigen::MatrixXd& columns,
              const Eigen::MatrixXd& tested, const Eigen::VectorXd& output,
              double piece_s = kPiece_s);

  // N in closed form, K/N and s/N by search. `start`: where to begin, when something is known.
  // nullopt with fewer rows than columns.
  std::optional<NoiseEstimate> Best(const std::optional<IntervalNoise>& start = {}) const;
  // Deviance of a given noise.
  double Deviance(const IntervalNoise& noise) const;

  static constexpr double kPiece_s = 1.0;

 private:
  struct Products;  // of the white columns
  Products At(const IntervalNoise& noise) const;
  double Profile(double walk, double reference, double* n) const;
  void Prepare();

  std::vector<Interval> intervals_;  // merged
  Eigen::MatrixXd columns_;          // restricting, tested, output
  Eigen::Index restricting_ = 0;
  bool moving_ = false, solvable_ = false;
};

// Those of the columns that are independent of the ones before them, `gram` being their products.
std::vector<Eigen::Index> IndependentColumns(const Eigen::MatrixXd& gram, double tolerance = 1e-9);

}  // namespace gyrobench::calibration
