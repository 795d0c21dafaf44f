#include "calibration/signal/whole_line.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {
namespace {

// Variance of `values` about the best sum of the columns.
double LeftOf(const Eigen::MatrixXd& columns, const Eigen::VectorXd& values) {
  const Eigen::VectorXd best =
      (columns.transpose() * columns).ldlt().solve(columns.transpose() * values);
  return (values - columns * best).squaredNorm() / static_cast<double>(values.size());
}

}  // namespace

void WholeLine::Add(double place, double s) {
  if (points_.empty()) {
    points_.reserve(kMost);
    all_.step_s = s / place;
  }
  all_.Add(place, s, std::numeric_limits<double>::infinity());
  if (std::has_single_bit(static_cast<std::uint64_t>(count_))) all_.MakeStepsItsOwn();
  if (count_++ % every_ != 0) return;
  points_.push_back({place, s});
  if (points_.size() < kMost) return;
  for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = points_[2 * i];
  points_.resize(kMost / 2);
  every_ *= 2;
}

std::optional<WholeLine::Line> WholeLine::Evenly() const {
  constexpr std::int64_t kLeast = 1000;
  constexpr double kOfADrift = 0.6;
  if (count_ < kLeast) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(points_.size());
  // From -1 to 1, and less a line between the ends, in which all else would drown.
  const Point &first = points_.front(), &last = points_.back();
  const double middle = 0.5 * (first.place + last.place), half = 0.5 * (last.place - first.place);
  const double step_s = (last.s - first.s) / (last.place - first.place);
  Eigen::MatrixXd columns(count, 3);
  Eigen::VectorXd beyond_s(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Point& point = points_[static_cast<std::size_t>(i)];
    const double x = (point.place - middle) / half;
    columns.row(i) << 1.0, x, x * x;
    beyond_s(i) = point.s - first.s - step_s * (point.place - first.place);
  }
  if (LeftOf(columns, beyond_s) < (1.0 - kOfADrift) * LeftOf(columns.leftCols(2), beyond_s))
    return std::nullopt;
  return Line{all_.slope_s(), all_.At(0.0), std::sqrt(std::max(all_.left_s2(), 0.0))};
}

void LongestLine::Begin(double first_stamp_s) {
  if (now_.line.count() > longest_.line.count()) longest_ = now_;
  now_ = {{}, first_stamp_s};
}

KnownClock LongestLine::Clock(double most_scatter_s) const {
  const Stretch& longest = now_.line.count() > longest_.line.count() ? now_ : longest_;
  const std::optional<WholeLine::Line> line = longest.line.Evenly();
  if (!line || !(line->scatter_s < most_scatter_s)) return {};
  return {line->interval_s, static_cast<double>(longest.line.count()), longest.first_stamp_s,
          line->at_first_s};
}

}  // namespace gyrobench::calibration
