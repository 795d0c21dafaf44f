#include "calibration/estimators/scale_problem.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr double kLongestTurn_s = 120.0;

double MovingPath(const std::vector<Row>& rows, std::size_t channel) {
  double path = 0.0;
  for (const Row& row : rows) {
    if (!row.still && row.usable[channel]) path += std::fabs(row.rotation_deg[channel]);
  }
  return path;
}

}  // namespace

Turns CountTurns(const std::vector<Row>& rows, std::size_t channel) {
  Turns out;
  for (const Row& row : rows) {
    if (row.still || !row.usable[channel]) continue;
    if (std::fabs(row.rotation_deg[channel]) < kLeastTurn_deg) continue;
    ++out.count;
    out.rotation_deg += std::fabs(row.rotation_deg[channel]);
    out.longest_s = std::max(out.longest_s, row.duration_s());
  }
  return out;
}

OneWayRotations CountOneWayRotations(const Columns& columns, std::size_t channel) {
  OneWayRotations out;
  if (columns.nodes.empty()) return out;
  double before_deg = 0.0;
  const auto end_one = [&](double angle_deg) {
    if (std::fabs(angle_deg) < kLeastTurn_deg) return;
    ++out.count;
    out.square_deg2 += angle_deg * angle_deg;
    const double here_deg = std::fabs(angle_deg) + before_deg;
    out.ends_square_deg2 += here_deg * here_deg;
    before_deg = std::fabs(angle_deg);
  };
  double begin = columns.nodes.front().rotation_deg[channel], farthest = begin;
  for (const Node& node : columns.nodes) {
    const double here = node.rotation_deg[channel];
    const double way = farthest - begin;
    if (std::fabs(way) < kLeastTurn_deg || (here - farthest) * way >= 0.0) {
      farthest = here;
    } else if (std::fabs(here - farthest) >= kLeastTurn_deg) {
      end_one(way);
      begin = farthest;
      farthest = here;
    }
  }
  end_one(farthest - begin);
  out.ends_square_deg2 += before_deg * before_deg;
  return out;
}

double RotationRange(const Columns& columns, std::size_t channel) {
  double low = 0.0, high = 0.0;
  if (columns.nodes.empty()) return 0.0;
  low = high = columns.nodes.front().rotation_deg[channel];
  for (const Node& node : columns.nodes) {
    low = std::min(low, node.rotation_deg[channel]);
    high = std::max(high, node.rotation_deg[channel]);
  }
  return high - low;
}

ScalePlan MakeScalePlan(const Columns& columns, std::size_t channel) {
  ScalePlan plan{StopRows(columns, kScalePiece_s), true};
  const Turns turns = CountTurns(plan.rows, channel);
  std::vector<Row> nodes = NodeRows(columns, kScalePiece_s);
  const bool all_motion = turns.rotation_deg >= 0.5 * MovingPath(nodes, channel);
  if (turns.count >= 1 && turns.longest_s <= kLongestTurn_s && all_motion) return plan;
  return {std::move(nodes), false};
}

IntervalSeries ScaleProblem::Series(const std::vector<Row>& rows, std::size_t channel,
                                    double gain) const {
  return MakeSeries(rows, channel, output() + 1, [&](const Row& row, double* out) {
    *FillRegressors(row, channel, out) = row.z[channel] / gain;
  });
}

IntervalSeries ScaleProblem::GravitySeries(const std::vector<Row>& rows, std::size_t channel,
                                           const std::vector<Vector3>& gravity_g_s) const {
  return MakeSeries(rows, channel, output() + 3, [&](const Row& row, double* out) {
    const auto index = static_cast<std::size_t>(&row - rows.data());
    std::ranges::copy(gravity_g_s[index], FillRegressors(row, channel, out));
  });
}

double* ScaleProblem::FillRegressors(const Row& row, std::size_t channel, double* out) const {
  *out++ = row.rotation_deg[channel] + row.earth_deg[channel];
  for (const std::size_t other : others) *out++ = row.rotation_deg[other] + row.earth_deg[other];
  double power = row.duration_s();
  for (std::size_t k = 0; k <= bias_orders; ++k) {
    *out++ = power;
    power *= row.temperature_degC - mean_degC;
  }
  return out;
}

FitOptions ScaleProblem::Options(std::size_t order) const {
  FitOptions options;
  for (int i = 0; i < bias_column(); ++i) options.regressors.push_back(i);
  for (int i = 0; i <= static_cast<int>(order); ++i) {
    options.regressors.push_back(bias_column() + i);
    options.rest_regressors.push_back(bias_column() + i);
  }
  options.output = output();
  return options;
}

double RoughGain(const std::vector<Row>& rows, std::size_t channel) {
  const ScaleProblem simple;
  const IntervalSeries series = simple.Series(rows, channel, 1.0);
  const WhiteGram gram = Whiten(series, NoiseModel{1.0, 0.0, 0.0});
  const GlsSolution solution = Solve(gram, simple.Options(0).regressors, simple.output());
  if (!solution.solvable || series.rows() < 4) return kMissing;
  const double freedom = static_cast<double>(series.rows()) - 2.0;
  const double std_error = std::sqrt(solution.variance(0) * solution.residual_square / freedom);
  const double gain = solution.coefficients[0];
  return std::fabs(gain) > 4.0 * std_error ? gain : kMissing;
}

}  // namespace gyrobench::calibration
