// By how much the steps of an encoder misread an axis that rests while others turn.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/geometry.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

// A row in which an axis rests, and where in its turn.
using RestingRow = std::pair<double, Eigen::Index>;

// In order of the angles: those that are nearer to each other than a quarter of a step err alike.
// A turn ends where it begins.
std::vector<std::vector<RestingRow>> ByPlace(std::vector<RestingRow> rows, double step_deg) {
  const double apart_deg = 0.25 * step_deg;
  std::ranges::sort(rows);
  std::vector<std::vector<RestingRow>> places;
  for (const RestingRow& row : rows) {
    if (places.empty() || row.first - places.back().back().first > apart_deg) places.emplace_back();
    places.back().push_back(row);
  }
  if (places.size() > 1 &&
      places.front().front().first + kFullTurn_deg - places.back().back().first <= apart_deg) {
    places.front().insert(places.front().end(), places.back().begin(), places.back().end());
    places.pop_back();
  }
  return places;
}

}  // namespace

// One column a place, of one standard deviation of what rounding errs by there.
void ChannelProblem::FindMisreadPlaces(double scale) {
  // Of a step: noise that carries the readings over the steps leaves less of the rounding.
  constexpr double kLeastSigma = 0.01;
  // What a place does in all, below which it is the rounding of a sine or of the Earth's rotation.
  constexpr double kLeastMoved_deg = 1e-4;
  std::vector<Eigen::VectorXd> columns;
  // Nothing is outside of the outer axis.
  for (const std::size_t axis : {std::size_t{1}, std::size_t{2}}) {
    const double sigma_deg = rounding_error_deg(axis);
    const double step_deg = LargestStep_deg(axis);
    if (!(sigma_deg > kLeastSigma * step_deg)) continue;
    std::vector<RestingRow> resting;
    for (Eigen::Index i = 0; i < rows(); ++i) {
      const SensorState& state = half(i, 0);
      const double turns = state.table_deg[axis] / kFullTurn_deg;
      const bool rests = !state.still && state.table_rate_deg_s[axis] == 0.0;
      if (rests && std::isfinite(turns))
        resting.emplace_back(kFullTurn_deg * (turns - std::floor(turns)), i);
    }
    for (const std::vector<RestingRow>& place : ByPlace(resting, step_deg)) {
      Eigen::VectorXd column = Eigen::VectorXd::Zero(rows());
      for (const auto& [angle_deg, i] : place)
        column(i) = scale * sigma_deg * felt_axes_[static_cast<std::size_t>(i)][axis].direction;
      if (column.cwiseAbs().sum() > kLeastMoved_deg) columns.push_back(std::move(column));
    }
  }
  misread_places_.resize(rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k)
    misread_places_.col(static_cast<Eigen::Index>(k)) = columns[k];
}

}  // namespace gyrobench::calibration
