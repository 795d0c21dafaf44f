#include "calibration/gls/minimize.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {
namespace {

struct Vertex {
  std::vector<double> at;
  double value = 0.0;
};

bool Better(const Vertex& a, const Vertex& b) { return a.value < b.value; }

// centre + factor (centre - worst)
std::vector<double> Along(const std::vector<double>& centre, const std::vector<double>& worst,
                          double factor) {
  std::vector<double> out(centre.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = centre[i] + factor * (centre[i] - worst[i]);
  return out;
}

}  // namespace

Minimum Minimize(const std::function<double(const std::vector<double>&)>& function,
                 std::vector<double> start, double step, const std::vector<double>& low,
                 const std::vector<double>& high, double tolerance, int max_evaluations) {
  Minimum out;
  const std::size_t n = start.size();
  auto try_at = [&](std::vector<double> at) {
    for (std::size_t i = 0; i < n; ++i) at[i] = std::clamp(at[i], low[i], high[i]);
    const double value = function(at);
    ++out.evaluations;
    return Vertex{std::move(at), std::isfinite(value) ? value : std::numeric_limits<double>::max()};
  };
  std::vector<Vertex> simplex = {try_at(start)};
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> at = start;
    at[i] += at[i] + step <= high[i] ? step : -step;
    simplex.push_back(try_at(std::move(at)));
  }
  while (n > 0 && out.evaluations < max_evaluations) {
    std::sort(simplex.begin(), simplex.end(), Better);
    double spread = 0.0;
    for (const Vertex& vertex : simplex) {
      for (std::size_t i = 0; i < n; ++i) {
        spread = std::max(spread, std::fabs(vertex.at[i] - simplex.front().at[i]));
      }
    }
    if (spread < tolerance) break;
    Vertex& worst = simplex.back();
    std::vector<double> centre(n, 0.0);
    for (std::size_t v = 0; v < n; ++v) {
      for (std::size_t i = 0; i < n; ++i) centre[i] += simplex[v].at[i] / static_cast<double>(n);
    }
    Vertex reflected = try_at(Along(centre, worst.at, 1.0));
    if (Better(reflected, simplex.front())) {
      Vertex further = try_at(Along(centre, worst.at, 2.0));
      worst = Better(further, reflected) ? std::move(further) : std::move(reflected);
      continue;
    }
    if (Better(reflected, simplex[n - 1])) {
      worst = std::move(reflected);
      continue;
    }
    const bool outside = Better(reflected, worst);
    Vertex nearer = try_at(Along(centre, worst.at, outside ? 0.5 : -0.5));
    if (Better(nearer, outside ? reflected : worst)) {
      worst = std::move(nearer);
      continue;
    }
    for (std::size_t v = 1; v <= n; ++v) {
      for (std::size_t i = 0; i < n; ++i) {
        simplex[v].at[i] = 0.5 * (simplex[v].at[i] + simplex.front().at[i]);
      }
      simplex[v] = try_at(simplex[v].at);
    }
  }
  const auto best = std::min_element(simplex.begin(), simplex.end(), Better);
  out.at = best->at;
  out.value = best->value;
  return out;
}

}  // namespace gyrobench::calibration
