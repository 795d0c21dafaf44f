#include "calibration/signal/clock_drift.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/robust.h"
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
  const double usual_s = Median(std::vector<double>(lengths_s));
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

// The time is counted from `middle_s`, so that delay and growth are nearly independent.
std::vector<Row> RowsOf(const std::vector<Node>& nodes, const std::vector<Eigen::Vector3d>& rates,
                        std::size_t channel, double middle_s) {
  std::vector<Row> rows;
  const auto c = static_cast<Eigen::Index>(channel);
  for (std::size_t k = 2; k + 1 < nodes.size(); ++k) {
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

// Least squares, and again without what lies far off: an axis that lost its count, a hand on the
// table.
ClockDrift DriftOf(std::vector<Row> rows, std::size_t channel) {
  constexpr double kFar = 8.0, kLeastTurned = 20.0;
  constexpr int kRounds = 3;
  ClockDrift out;
  for (int round = 0; round < kRounds; ++round) {
    if (rows.size() <= 2 * static_cast<std::size_t>(kUnknowns)) return {};
    Normal normal = Normal::Zero();
    Terms right = Terms::Zero();
    for (const Row& row : rows) {
      normal += row.terms * row.terms.transpose();
      right += row.output * row.terms;
    }
    // A term that nothing excites stays 0 by that, and its error large.
    const Terms scale = normal.diagonal().cwiseSqrt().cwiseMax(1e-12);
    normal = (normal.array() / (scale * scale.transpose()).array()).matrix();
    normal.diagonal().array() += 1e-12;
    const Normal inverse = normal.ldlt().solve(Normal::Identity());
    const Terms fit = (inverse * right.cwiseQuotient(scale)).cwiseQuotient(scale);
    if (!fit.allFinite()) return {};
    std::vector<double> off;
    double square = 0.0;
    for (const Row& row : rows) {
      off.push_back(std::fabs(row.output - fit.dot(row.terms)));
      square += off.back() * off.back();
    }
    const double variance = square / static_cast<double>(rows.size());
    const auto std_error = [&](int j) {
      return std::sqrt(variance * std::max(inverse(j, j), 0.0)) / scale(j);
    };
    const int own = kOfM + static_cast<int>(channel);
    if (!(std::fabs(fit(own)) > kLeastTurned * std_error(own))) return {};
    out.drift_ppm = -1e6 * fit(kGrowth) / fit(own);
    out.std_error_ppm = 1e6 * std_error(kGrowth) / std::fabs(fit(own));
    // Rests have the noise of rests; a bound by their median would leave all motion out.
    const double far = kFar * std::sqrt(variance);
    std::vector<Row> near;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (off[i] <= far) near.push_back(rows[i]);
    if (near.size() == rows.size()) break;
    rows = std::move(near);
  }
  return out;
}

}  // namespace

bool ClockDrift::Matters() const {
  constexpr double kSigmas = 10.0, kLeast_s = 0.005, kMost_s = 1.0;
  const double apart_s = std::fabs(PartedBy_s(drift_ppm, latest_s));
  return std::fabs(drift_ppm) > kSigmas * std_error_ppm && std::fabs(drift_ppm) < kMostDrift_ppm &&
         apart_s > kLeast_s && apart_s < kMost_s;
}

ClockDrift FindClockDrift(std::span<const Recording> recordings) {
  double weights = 0.0, sum = 0.0, latest_s = 0.0;
  for (const Recording& recording : recordings) {
    const std::vector<Node>& nodes = recording.columns.nodes;
    if (nodes.size() < 3) continue;
    const std::vector<Eigen::Vector3d> rates = RatesUpTo(nodes);
    const double middle_s = 0.5 * (nodes.front().at.t_s + nodes.back().at.t_s);
    for (const Node* end : {&nodes.front(), &nodes.back()})
      if (std::fabs(end->at.t_s) > std::fabs(latest_s)) latest_s = end->at.t_s;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!recording.info.gyro_present[c]) continue;
      const ClockDrift drift = DriftOf(RowsOf(nodes, rates, c, middle_s), c);
      if (!(drift.std_error_ppm > 0.0) || !std::isfinite(drift.std_error_ppm)) continue;
      const double weight = 1.0 / (drift.std_error_ppm * drift.std_error_ppm);
      weights += weight;
      sum += weight * drift.drift_ppm;
    }
  }
  if (!(weights > 0.0)) return {};
  return {sum / weights, 1.0 / std::sqrt(weights), latest_s};
}

std::vector<Recording> OnOneClock(
    std::vector<Recording> as_stamped,
    const std::function<std::vector<Recording>(double drift_ppm)>& read) {
  // Of clocks that are apart by a whole ramp each round sees a part alone.
  constexpr int kRounds = 6;
  ClockDrift left = FindClockDrift(as_stamped);
  if (!left.Matters()) return as_stamped;
  double drift_ppm = 0.0;
  std::vector<Recording> on_one;
  for (int round = 0; round < kRounds && left.Matters(); ++round) {
    drift_ppm += left.drift_ppm;
    on_one = read(drift_ppm);
    left = FindClockDrift(on_one);
  }
  return left.Matters() ? as_stamped : std::move(on_one);
}

}  // namespace gyrobench::calibration
