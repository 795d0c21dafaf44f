#include "calibration/state/timing_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace gyrobench::calibration {
namespace {

// What the angle's variance has of that of the times of its readings.
double PerTiming(double rate_deg_s, double readings) { return rate_deg_s * rate_deg_s / readings; }

struct Step {
  AngleErrors errors;
  double timing_error_s2 = 0.0;  // standard error of timing_s2
};

// A straight line of PerTiming through the squares, each weighed by what `so_far` says that it
// scatters by. Nothing where there is one speed alone.
std::optional<Step> FitLine(const std::vector<AngleBesideGyro>& angles, const AngleErrors& so_far) {
  constexpr double kMostSquare = 36.0, kSame = 1e-6;
  const std::size_t count = angles.size();
  std::vector<double> weights(count), xs(count), squares(count);
  double w = 0.0, wx = 0.0, wxx = 0.0, wy = 0.0, wxy = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const AngleBesideGyro& angle = angles[i];
    const double x = PerTiming(angle.rate_deg_s, angle.readings);
    const double expected_deg2 = so_far.reading_deg2 + so_far.timing_s2 * x;
    const double y = std::min(angle.off_deg * angle.off_deg / (1.0 + 1.0 / angle.beside),
                              kMostSquare * expected_deg2);
    const double weight = 1.0 / (expected_deg2 * expected_deg2);
    weights[i] = weight;
    xs[i] = x;
    squares[i] = y;
    w += weight;
    wx += weight * x;
    wxx += weight * x * x;
    wy += weight * y;
    wxy += weight * x * y;
  }
  const double det = w * wxx - wx * wx;
  if (!(det > kSame * w * wxx)) return std::nullopt;
  Step out{{(wxx * wy - wx * wxy) / det, (w * wxy - wx * wy) / det}};
  double variance = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double off = squares[i] - out.errors.reading_deg2 - out.errors.timing_s2 * xs[i];
    variance += std::pow(weights[i] * (w * xs[i] - wx) / det * off, 2);
  }
  out.timing_error_s2 = std::sqrt(variance);
  return out;
}

}  // namespace

double AngleErrors::ShareOfTiming(double rate_deg_s, double readings) const {
  const double timing_deg2 = timing_s2 * PerTiming(rate_deg_s, readings);
  return timing_deg2 > 0.0 ? timing_deg2 / (timing_deg2 + reading_deg2) : 0.0;
}

AngleErrors FindAngleErrors(const std::vector<AngleBesideGyro>& angles) {
  constexpr std::size_t kLeast = 50;
  constexpr double kSigmas = 5.0, kLeastPart = 1e-3;
  constexpr int kRounds = 8;
  if (angles.size() < kLeast) return {};
  double mean_deg2 = 0.0;
  for (const AngleBesideGyro& angle : angles)
    mean_deg2 += angle.off_deg * angle.off_deg / static_cast<double>(angles.size());
  const AngleErrors alike{mean_deg2, 0.0};
  if (!(mean_deg2 > 0.0)) return alike;
  AngleErrors found = alike;
  bool clear = false;
  for (int round = 0; round < kRounds; ++round) {
    const std::optional<Step> step = FitLine(angles, found);
    if (!step) return alike;
    clear = step->errors.timing_s2 > kSigmas * step->timing_error_s2;
    found = {std::max(step->errors.reading_deg2, kLeastPart * mean_deg2),
             std::max(step->errors.timing_s2, 0.0)};
  }
  return clear ? found : alike;
}

}  // namespace gyrobench::calibration
