// The least-squares problem of one axis's scale factor: its intervals and their columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "calibration/estimators/schedule.h"
#include "calibration/gls/noise_fit.h"

namespace gyrobench::calibration {

inline constexpr double kScalePiece_s = 1.0;   // rests are cut into pieces of this
inline constexpr double kLeastTurn_deg = 0.5;  // less between two rests is no turn

struct ScalePlan {
  std::vector<Row> rows;
  bool stops = false;  // stop to stop; otherwise node to node
};

// Stop to stop where the channel's motion is made of turns between rests, else node to node.
ScalePlan MakeScalePlan(const Columns& columns, std::size_t channel);

// The channel's rotation between rests, turn by turn.
struct Turns {
  std::int64_t count = 0;
  double rotation_deg = 0.0;  // without sign, added up
  double longest_s = 0.0;
};
Turns CountTurns(const std::vector<Row>& stop_rows, std::size_t channel);

// The channel's rotation, one way after the other: each ends where it turns back by kLeastTurn_deg.
struct OneWayRotations {
  std::int64_t count = 0;
  double square_deg2 = 0.0;  // of their angles, added up
  // What an error of the reference at each end is worth in the sum of rotation times error: squares
  // of the way that ends there and of the next, together, as the next goes back.
  double ends_square_deg2 = 0.0;
};
OneWayRotations CountOneWayRotations(const Columns& columns, std::size_t channel);

// Largest less least angle of the reference about the channel's axis.
double RotationRange(const Columns& columns, std::size_t channel);

// Columns: the channel's own rotation, that of other axes that turned as well, then the bias's
// (T - mean)^k dt, last the output over `gain` [deg].
struct ScaleProblem {
  std::vector<std::size_t> others;
  std::size_t bias_orders = 0;
  double mean_degC = kMissing;

  int bias_column() const { return 1 + static_cast<int>(others.size()); }
  int output() const { return bias_column() + 1 + static_cast<int>(bias_orders); }
  IntervalSeries Series(const std::vector<Row>& rows, std::size_t channel, double gain) const;
  // The same columns before the output, in whose place are the three of `gravity_g_s`, of each row.
  IntervalSeries GravitySeries(const std::vector<Row>& rows, std::size_t channel,
                               const std::vector<Vector3>& gravity_g_s) const;
  // Regressors with the bias's polynomial up to `order`.
  FitOptions Options(std::size_t order) const;

 private:
  // Up to the output; where that goes.
  double* FillRegressors(const Row& row, std::size_t channel, double* out) const;
};

// Output units per deg/s, roughly: least squares without a thought of the noise. NaN when the
// channel does not respond.
double RoughGain(const std::vector<Row>& rows, std::size_t channel);

}  // namespace gyrobench::calibration
