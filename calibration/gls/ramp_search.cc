#include "calibration/gls/ramp_search.h"

namespace gyrobench::calibration {
namespace {

// Less of a ramp left by the model: what it gains is rounding.
constexpr double kLeastLeft = 1e-3;

}  // namespace

RampPeak SearchRamps(const WhiteStore::Remainder& cells) {
  RampPeak peak;
  const auto count = static_cast<Eigen::Index>(cells.with_output.size());
  const double usual = cells.products.diagonal().maxCoeff();
  for (Eigen::Index from = 0; from < count; ++from) {
    double score = 0.0, square = 0.0;
    for (Eigen::Index to = from; to < count; ++to) {
      // One more cell: its square, and its products with those that are in already, twice.
      square +=
          cells.products(to, to) + 2.0 * cells.products.col(to).segment(from, to - from).sum();
      score += cells.with_output(to);
      peak.tried += 1.0;
      const auto length = static_cast<double>(to - from + 1);
      if (!(square > kLeastLeft * usual * length)) continue;
      const double gain = score * score / square;
      if (gain <= peak.gain) continue;
      peak.gain = gain;
      peak.from = static_cast<std::size_t>(from);
      peak.to = static_cast<std::size_t>(to) + 1;
    }
  }
  return peak;
}

}  // namespace gyrobench::calibration
