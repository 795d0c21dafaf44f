// Noise of a problem by restricted maximum likelihood, and what an effect is worth when the noise
// may answer for it instead.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "calibration/gls/interval_gls.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/gls/white_products.h"

namespace gyrobench::calibration {

struct NoiseEstimate {
  NoiseModel noise;
  double deviance = 0.0;  // -2 log of the restricted likelihood, without its constants
};

// NaN where the data do not tell it.
struct CoefficientEstimate {
  double value = std::numeric_limits<double>::quiet_NaN();
  double std_error = std::numeric_limits<double>::quiet_NaN();
};

// Appends the pieces that intervals become, of at most `piece_s` at rest, each moving one as it is.
// Of each interval: index of the one that it has become a part of.
std::vector<Eigen::Index> InPieces(std::span<const Interval> intervals, double piece_s,
                                   std::vector<Interval>* pieces);

class NoiseSearch {
 public:
  // `columns`: rows x p together, everything that may act; a missing effect would otherwise pass
  // for noise. The largest coefficient of a limited column is the standard deviation of a normal
  // one about 0 that is known before: a column may have noise of the output in it, and would take
  // that away with a coefficient that no part has. Columns of which those before leave less than
  // `tolerance` of the square are left out. `piece_s`: stretches at rest are taken in pieces of
  // this length, which changes nothing that the noise could be told from.
  NoiseSearch(std::span<const Interval> intervals, std::span<const RawColumns> columns,
              const Eigen::VectorXd& output, double tolerance = kDependent,
              double piece_s = kPiece_s);
  NoiseSearch(std::span<const Interval> intervals, const RawColumns& columns,
              const Eigen::VectorXd& output, double tolerance = kDependent,
              double piece_s = kPiece_s)
      : NoiseSearch(intervals, std::span(&columns, 1), output, tolerance, piece_s) {}

  // N in closed form, K/N and s/N by search, from `start` where something is known; both ratios to
  // within `tolerance` of their logarithm. nullopt without a row more than columns.
  std::optional<NoiseEstimate> Best(const std::optional<NoiseModel>& start = {},
                                    double tolerance = 0.02) const;
  // The same without what cannot be: limited columns whose coefficient comes out three times as large
  // as the largest are left out from then on, with those that came with them. Over many rows what
  // such a column takes from the noise outweighs any limit.
  std::optional<NoiseEstimate> BestPlausible(const std::optional<NoiseModel>& start = {},
                                             double tolerance = 0.02);
  // The best noise with the mean of the bias random walk that the likelihood leaves open, every
  // size from 0 being as likely before, in place of the likeliest one: that is 0 for many data in
  // which there is a walk, and slow effects would be known better than they are.
  NoiseEstimate WithMeanWalk(const NoiseEstimate& best) const;
  // `best` with K of 0, then with s of 0, each where that costs next to nothing of the deviance.
  NoiseEstimate WithoutUnseen(const NoiseEstimate& best) const;
  // How many columns do not depend on the ones before them.
  std::size_t independent() const { return kept_.size(); }
  // Of the first column, under a given noise, by generalised least squares.
  CoefficientEstimate FirstCoefficient(const NoiseModel& noise) const;
  // Deviance of a given noise.
  double Deviance(const NoiseModel& noise) const;
  // By how much the deviance grows, for each group of columns, when the model goes without them and
  // each of both models has the noise that suits it: under the likelihood that is restricted by all
  // other columns (Welham and Thompson 1997), on a grid of noises around `start`. Groups: indices
  // of `columns`.
  std::vector<double> GainsOverNoise(const std::vector<std::vector<Eigen::Index>>& groups,
                                     const NoiseModel& start) const;

  static constexpr double kPiece_s = 1.0;

 private:
  struct Products;   // of the white columns
  struct Solved;     // by least squares
  struct Deviances;  // with and without a group
  struct Likeliest {
    double n = 0.0, deviance = std::numeric_limits<double>::infinity();
  };
  Products At(double walk, double reference) const;
  Products Scaled(const WhiteProducts& white) const;
  static Products Without(const Products& products, const std::vector<Eigen::Index>& group);
  static std::optional<Solved> Solve(const Products& products, double n);
  // Of `model`, with the likelihood that is restricted by the columns of `restricted`.
  double DevianceOf(const Products& products, const Solved& model, const Solved& restricted,
                    double n) const;
  double WithoutLimited(const Products& products) const;
  Likeliest Profile(const Products& model, const Products& restricted) const;
  Likeliest Profile(const Products& model) const { return Profile(model, model); }
  Deviances Contest(const Products& products, const std::vector<Eigen::Index>& group) const;
  std::vector<double> Start(const NoiseModel& noise) const;
  void Prepare(ColumnsInChunks columns, const Eigen::VectorXd& per_largest, double tolerance);
  bool LeaveOutImplausible(const NoiseModel& noise);
  void LeaveOut(const std::set<std::size_t>& given);

  std::vector<Interval> intervals_;     // merged
  ColumnsInChunks columns_;             // the output last
  Eigen::VectorXd bulk_;                // that was taken off the output, by columns
  std::vector<Eigen::Index> kept_;      // their indices among those that were given
  Eigen::VectorXd per_largest_;         // 1 / the largest coefficient of each
  std::vector<std::size_t> came_with_;  // of each: with which of those that were given
  double tolerance_ = kDependent;
  bool moving_ = false, solvable_ = false;
};

}  // namespace gyrobench::calibration
