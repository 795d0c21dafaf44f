#include "calibration/signal/clock_drift.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/robust.h"
#include "calibration/signal/bad_times.h"
#include "calibration/signal/collector.h"

namespace gyrobench::calibration {
namespace {

// Unknowns of a channel: offset, the three of M, the delay and its growth.
constexpr int kUnknowns = 6, kOfM = 1, kDelay = 4, kGrowth = 5;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Terms = Eigen::Matrix<double, kUnknowns, 1>;

struct Row {
  Terms terms;
  double output = 0.0;
};

// Rates of the reference about the sensor's axes up to each node [deg/s]; NaN beyond a gap.
std::vector<Eigen::Vector3d> RatesUpTo(const std::vector<Node>& nodes) {
  constexpr double kGap = 2.0;
  std::vector<double> lengths_s;
  for (std::size_t k = 1; k < nodes.size(); ++k)
    lengths_s.push_back(nodes[k].at.t_s - nodes[k - 1].at.t_s);
  const double usual_s = Median(lengths_s);
  std::vector<Eigen::Vector3d> rates(nodes.size(), Eigen::Vector3d::Constant(kMissing));
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    const double length_s = lengths_s[k - 1];
    if (!(length_s > 0.0) || !(length_s < kGap * usual_s)) continue;
    for (int c = 0; c < 3; ++c) {
      const auto axis = static_cast<std::size_t>(c);
      rates[k](c) = (nodes[k].rotation_deg[axis] - nodes[k - 1].rotation_deg[axis]) / length_s;
    }
  }
  return rates;
}

// The time is counted from the middle, so that delay and growth are nearly independent.
std::vector<Row> RowsOf(const Recording& recording, const std::vector<Eigen::Vector3d>& rates,
                        std::size_t channel) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  const double middle_s = 0.5 * (nodes.front().at.t_s + nodes.back().at.t_s);
  BadTimes bad(recording.columns.bad, channel);
  std::vector<Row> rows;
  const auto c = static_cast<Eigen::Index>(channel);
  for (std::size_t k = 2; k + 1 < nodes.size(); ++k) {
    if (bad.Touch(nodes[k - 1].at.t_s, nodes[k].at.t_s)) continue;
    const double length_s = nodes[k].at.t_s - nodes[k - 1].at.t_s;
    const double change = 0.5 * (rates[k + 1](c) - rates[k - 1](c)) / length_s;
    const double since_s = 0.5 * (nodes[k].at.t_s + nodes[k - 1].at.t_s) - middle_s;
    Row row;
    row.terms << 1.0, rates[k], change, since_s * change;
    row.output = (nodes[k].at.z[channel] - nodes[k - 1].at.z[channel]) / length_s;
    if (row.terms.allFinite() && std::isfinite(row.output)) rows.push_back(row);
  }
  return rows;
}

struct Fit {
  Terms values = Terms::Zero(), std_errors = Terms::Zero();
  // Of what is left, and of what is left without the growth of the delay.
  double square = 0.0, square_without_growth = 0.0;
  std::vector<double> left;  // row by row
};

// Nothing where the rows do not determine it.
std::optional<Fit> LeastSquares(const std::vector<Row>& rows) {
  constexpr std::size_t kCluster = 20;  // rows, 2 s: a ramp
  constexpr double kNothing = 1e-12;
  Normal normal = Normal::Zero();
  Terms right = Terms::Zero();
  for (const Row& row : rows) {
    normal += row.terms * row.terms.transpose();
    right += row.output * row.terms;
  }
  // A term that nothing excites stays 0, and its error large.
  const Terms scale = normal.diagonal().cwiseSqrt().cwiseMax(kNothing);
  normal = (normal.array() / (scale * scale.transpose()).array()).matrix();
  normal.diagonal().array() += kNothing;
  const Normal inverse = normal.ldlt().solve(Normal::Identity());
  Fit fit;
  fit.values = (inverse * right.cwiseQuotient(scale)).cwiseQuotient(scale);
  if (!fit.values.allFinite()) return std::nullopt;
  Normal scores = Normal::Zero();
  Terms cluster = Terms::Zero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    fit.left.push_back(rows[i].output - fit.values.dot(rows[i].terms));
    fit.square += fit.left.back() * fit.left.back();
    cluster += fit.left.back() * rows[i].terms.cwiseQuotient(scale);
    if ((i + 1) % kCluster != 0 && i + 1 < rows.size()) continue;
    scores += cluster * cluster.transpose();
    cluster.setZero();
  }
  fit.std_errors = (inverse * scores * inverse).diagonal().cwiseMax(0.0).cwiseSqrt();
  fit.std_errors = fit.std_errors.cwiseQuotient(scale).eval();
  fit.square_without_growth =
      fit.square + std::pow(fit.values(kGrowth) * scale(kGrowth), 2) / inverse(kGrowth, kGrowth);
  return fit;
}

// Of one channel of one measurement.
struct ChannelDrift {
  double drift_ppm = 0.0, std_error_ppm = 0.0;
  double square_deg2_s2 = 0.0;  // without the growth
  std::size_t rows = 0;
};

// Least squares, and again without what lies far off: an axis that lost its count, a hand on the
// table. Nothing where the channel does not tell.
std::optional<ChannelDrift> DriftOf(std::vector<Row> rows, std::size_t channel) {
  constexpr double kFar = 8.0, kLeastTurned = 20.0;
  constexpr int kRounds = 3;
  std::optional<ChannelDrift> out;
  for (int round = 0; round < kRounds; ++round) {
    if (rows.size() <= 2 * static_cast<std::size_t>(kUnknowns)) return std::nullopt;
    const std::optional<Fit> fit = LeastSquares(rows);
    const int own = kOfM + static_cast<int>(channel);
    if (!fit || !(std::fabs(fit->values(own)) > kLeastTurned * fit->std_errors(own)) ||
        !(fit->std_errors(kGrowth) > 0.0))
      return std::nullopt;
    const double units = fit->values(own);
    out = {-1e6 * fit->values(kGrowth) / units, 1e6 * fit->std_errors(kGrowth) / std::fabs(units),
           fit->square_without_growth / (units * units), rows.size()};
    // Rests have the noise of rests: a bound by their median would leave all motion out.
    const double far = kFar * std::sqrt(fit->square / static_cast<double>(rows.size()));
    std::vector<Row> near;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (std::fabs(fit->left[i]) <= far) near.push_back(rows[i]);
    if (near.size() == rows.size()) break;
    rows = std::move(near);
  }
  return out;
}

// Weighted by their errors.
class Mean {
 public:
  void Add(double value, double std_error) {
    const double weight = 1.0 / (std_error * std_error);
    weights_ += weight;
    sum_ += weight * value;
  }
  bool empty() const { return weights_ == 0.0; }
  double value() const { return sum_ / weights_; }
  double std_error() const { return 1.0 / std::sqrt(weights_); }

 private:
  double weights_ = 0.0, sum_ = 0.0;
};

// A latency of 5 ms is one that delays beside it begin to see (kLongDelay_s of the effects). Beyond
// 1 s the clocks were not started together, or the times are none of one clock.
bool MattersOver(double duration_s, const Mean& drift_ppm) {
  constexpr double kSigmas = 3.0, kLeast_s = 0.005, kMost_s = 1.0;
  const double drift = std::fabs(drift_ppm.value()), apart_s = 1e-6 * drift * duration_s;
  return drift > kSigmas * drift_ppm.std_error() && drift < kMostDrift_ppm && apart_s > kLeast_s &&
         apart_s < kMost_s;
}

}  // namespace

ClockDrift FindClockDrift(std::span<const Recording> recordings) {
  ClockDrift out;
  Mean all;
  double square_deg2_s2 = 0.0;
  std::size_t rows = 0;
  for (const Recording& recording : recordings) {
    const std::vector<Node>& nodes = recording.columns.nodes;
    if (nodes.size() < 3) continue;
    const std::vector<Eigen::Vector3d> rates = RatesUpTo(nodes);
    Mean own;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!recording.info.gyro_present[c]) continue;
      const std::optional<ChannelDrift> drift = DriftOf(RowsOf(recording, rates, c), c);
      if (!drift) continue;
      own.Add(drift->drift_ppm, drift->std_error_ppm);
      square_deg2_s2 += drift->square_deg2_s2;
      rows += drift->rows;
    }
    if (own.empty()) continue;
    all.Add(own.value(), own.std_error());
    out.matters = out.matters || MattersOver(nodes.back().at.t_s - nodes.front().at.t_s, own);
  }
  if (all.empty()) return out;
  out.drift_ppm = all.value();
  out.std_error_ppm = all.std_error();
  out.misfit_deg2_s2 = square_deg2_s2 / static_cast<double>(rows);
  return out;
}

std::vector<Recording> OnOneClock(
    std::vector<Recording> as_stamped, double guess_ppm,
    const std::function<std::vector<Recording>(double drift_ppm)>& read) {
  // Of clocks that are apart by a whole ramp each round sees a part alone, and its error is large.
  constexpr int kRounds = 8;
  constexpr double kCertain = 10.0;
  const ClockDrift first = FindClockDrift(as_stamped);
  if (!first.matters) return as_stamped;
  double drift_ppm = guess_ppm != 0.0 ? guess_ppm : first.drift_ppm;
  for (int round = 0; round < kRounds && std::fabs(drift_ppm) < kMostDrift_ppm; ++round) {
    std::vector<Recording> on_one = read(drift_ppm);
    const ClockDrift left = FindClockDrift(on_one);
    const bool certain = std::fabs(drift_ppm) > kCertain * left.std_error_ppm;
    if (!left.matters && certain && left.misfit_deg2_s2 < first.misfit_deg2_s2) return on_one;
    drift_ppm += left.drift_ppm;
  }
  return as_stamped;
}

}  // namespace gyrobench::calibration
