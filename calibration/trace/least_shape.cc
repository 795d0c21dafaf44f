// The shape of an effect that the data hardly know: a resonance that one speed meets on its flank
// may be low and wide or high and narrow.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Places of each parameter between its ends.
constexpr int kShapesEachWay = 9;
// An end at which -2 log L is within so much of the best is no end yet.
constexpr double kNegligible = 6.0;
constexpr int kWidenings = 4;
// To the first ends, of a parameter.
constexpr double kFirstReach = 0.25;
// Of the parameter's range, where it is near 0.
constexpr double kLeastReach = 1e-3;
constexpr int kNarrowings = 2;
// Of -2 log L: one standard error.
constexpr double kAsGood = 1.0;
// Of twice as many parameters the places would be hundreds.
constexpr std::size_t kMostParameters = 2;

struct Shape {
  std::vector<double> theta;
  double gain = 0.0;       // of -2 log L
  Eigen::VectorXd values;  // coefficients
};

// Sizes of one member by its shape, beside all others.
class Shapes {
 public:
  Shapes(const Selection& selection, std::size_t member)
      : selection_(selection),
        member_(selection.members()[member]),
        others_(selection.store().Take(selection.ModelWithout(member))),
        residual_(others_.Off(selection.store().output())) {}

  Shape At(std::vector<double> theta) const {
    Candidate candidate = member_;
    SetNonlinear(theta, &candidate);
    const Eigen::MatrixXd columns = others_.Off(selection_.White(candidate));
    const ScaledLdlt products(columns.transpose() * columns);
    const Eigen::VectorXd scores = columns.transpose() * residual_;
    Shape out;
    out.theta = std::move(theta);
    out.values = products.Solve(scores);
    out.gain = scores.dot(out.values);
    return out;
  }

 private:
  const Selection& selection_;
  const Candidate& member_;
  Projection others_;
  Eigen::VectorXd residual_;
};

struct Ends {
  std::vector<double> low, high;
};

Ends EndsAbout(const std::vector<double>& middle, const std::vector<double>& reach,
               const RefineRange& range) {
  Ends ends;
  for (std::size_t k = 0; k < middle.size(); ++k) {
    ends.low.push_back(std::max(range.low[k], middle[k] - reach[k]));
    ends.high.push_back(std::min(range.high[k], middle[k] + reach[k]));
  }
  return ends;
}

std::vector<Shape> Grid(const Shapes& shapes, const Ends& ends) {
  std::vector<std::vector<double>> places = {{}};
  for (std::size_t k = 0; k < ends.low.size(); ++k) {
    std::vector<std::vector<double>> longer;
    for (const std::vector<double>& place : places) {
      for (int i = 0; i < kShapesEachWay; ++i) {
        longer.push_back(place);
        longer.back().push_back(ends.low[k] +
                                (ends.high[k] - ends.low[k]) * i / (kShapesEachWay - 1.0));
      }
    }
    places = std::move(longer);
  }
  std::vector<Shape> out;
  for (std::vector<double>& place : places) out.push_back(shapes.At(std::move(place)));
  return out;
}

// Moves the ends at which the shape is as likely as elsewhere; whether any was.
bool Widen(const std::vector<Shape>& grid, double best, const RefineRange& range, Ends* ends) {
  bool moved = false;
  for (std::size_t k = 0; k < range.start.size(); ++k) {
    double at_low = 0.0, at_high = 0.0;
    for (const Shape& shape : grid) {
      if (shape.theta[k] <= ends->low[k]) at_low = std::max(at_low, shape.gain);
      if (shape.theta[k] >= ends->high[k]) at_high = std::max(at_high, shape.gain);
    }
    const double low = std::max(range.low[k], 2.0 * ends->low[k] - range.start[k]);
    const double high = std::min(range.high[k], 2.0 * ends->high[k] - range.start[k]);
    if (best - at_low < kNegligible && low < ends->low[k]) {
      ends->low[k] = low;
      moved = true;
    }
    if (best - at_high < kNegligible && high > ends->high[k]) {
      ends->high[k] = high;
      moved = true;
    }
  }
  return moved;
}

// Shapes about the stated one, up to ends beyond which nothing is as likely. `reach`: of each
// parameter, to the first ends.
std::vector<Shape> ShapesLeftOpen(const Shapes& shapes, const Shape& stated,
                                  const RefineRange& range, const std::vector<double>& reach) {
  Ends ends = EndsAbout(stated.theta, reach, range);
  std::vector<Shape> grid = Grid(shapes, ends), tried = grid;
  for (int round = 1; round < kWidenings && Widen(grid, stated.gain, range, &ends); ++round) {
    grid = Grid(shapes, ends);
    std::ranges::copy(grid, std::back_inserter(tried));
  }
  return tried;
}

}  // namespace

std::vector<double> ShapeOfLeastSize(const ChannelProblem& problem, const Selection& selection,
                                     std::size_t member) {
  const Candidate& candidate = selection.members()[member];
  if (candidate.search() != Search::kGrid || candidate.context.nonlinear.size() > kMostParameters)
    return candidate.context.nonlinear;
  const RefineRange range = *RangeOf(problem, candidate);
  std::vector<double> reach;
  for (std::size_t k = 0; k < range.start.size(); ++k)
    reach.push_back(std::max(kFirstReach * std::fabs(range.start[k]),
                             kLeastReach * (range.high[k] - range.low[k])));
  const Shapes shapes(selection, member);
  Shape least = shapes.At(range.start);
  double best = least.gain;
  const auto take_least = [&](const std::vector<Shape>& some) {
    for (const Shape& shape : some) best = std::max(best, shape.gain);
    for (const Shape& shape : some) {
      const bool as_good = best - shape.gain < kAsGood && shape.values.allFinite();
      if (as_good && shape.values.norm() < least.values.norm()) least = shape;
    }
  };
  take_least(ShapesLeftOpen(shapes, least, range, reach));
  for (int round = 0; round < kNarrowings; ++round) {
    for (double& way : reach) way /= 0.5 * (kShapesEachWay - 1);  // a step of the grid before
    take_least(Grid(shapes, EndsAbout(least.theta, reach, range)));
  }
  return least.theta;
}

}  // namespace gyrobench::calibration
