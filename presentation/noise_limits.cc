#include "presentation/noise_limits.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::presentation {
namespace {

constexpr double kInterval_s = 0.1;  // the tracer's columns

// A limit that is not known hides nothing but a zero.
NoiseFigure Judge(double value, double limit, const char* why) {
  NoiseFigure figure{value, std::isfinite(limit) ? limit : 0.0, ""};
  if (std::isfinite(value) && (value <= 0.0 || value < figure.limit)) figure.why = why;
  return figure;
}

}  // namespace

NoiseFigures JudgeNoise(const calibration::TraceNoise& noise, double duration_s) {
  NoiseFigures figures;
  const double n = noise.angle_random_walk_deg_sqrt_s;
  figures.angle_random_walk = Judge(n, noise.reference_deg * std::sqrt(kInterval_s) / duration_s,
                                    "the reference's noise hides it");
  // The walk may be as large as its limit.
  const double n_most = std::fmax(n, figures.angle_random_walk.limit);
  figures.bias_random_walk = Judge(noise.bias_random_walk_deg_s_sqrt_s, n_most / duration_s,
                                   "the angle random walk hides it");
  figures.reference = Judge(noise.reference_deg,
                            n * std::sqrt(kInterval_s) * std::pow(kInterval_s / duration_s, 0.25),
                            noise.reference_deg > 0.0 ? "the angle random walk hides it"
                                                      : "none, or the angle random walk hides it");
  return figures;
}

double LongestDuration_s(const calibration::TraceResult& trace) {
  double longest_s = kMissing;
  for (const auto& input : trace.inputs) longest_s = std::fmax(longest_s, input.duration_s);
  return longest_s;
}

}  // namespace gyrobench::presentation
