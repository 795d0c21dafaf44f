#include "calibration/trace/held_out.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace gyrobench::calibration {
namespace {

constexpr int kBootstrap = 400;

double Ratio(const std::vector<double>& before, const std::vector<double>& after,
             const std::vector<std::size_t>& chosen) {
  double a = 0.0, b = 0.0;
  for (const std::size_t i : chosen) {
    b += before[i];
    a += after[i];
  }
  return std::sqrt(a / b);
}

// 95 % interval of 1 - rms after / rms before.
std::array<double, 2> ReductionInterval(const std::vector<double>& before,
                                        const std::vector<double>& after, std::uint64_t seed) {
  if (before.size() < 4) return {kMissing, kMissing};
  std::mt19937_64 random(seed);
  std::vector<double> reductions;
  std::vector<std::size_t> chosen(before.size());
  for (int i = 0; i < kBootstrap; ++i) {
    for (std::size_t& index : chosen) index = random() % before.size();
    reductions.push_back(1.0 - Ratio(before, after, chosen));
  }
  std::sort(reductions.begin(), reductions.end());
  return {reductions[static_cast<std::size_t>(0.025 * kBootstrap)],
          reductions[static_cast<std::size_t>(0.975 * kBootstrap) - 1]};
}

double Rms(const TriedRows& tried) {
  return std::sqrt(std::accumulate(tried.squares.begin(), tried.squares.end(), 0.0) / tried.rows);
}

}  // namespace

HeldOutFigures Compare(const TriedRows& before, const TriedRows& after, std::uint64_t seed) {
  HeldOutFigures out;
  out.whitened_rms = {Rms(before), Rms(after),
                      ReductionInterval(before.squares, after.squares, seed)};
  out.angle_rms_deg = {before.windows.rms(), after.windows.rms(),
                       ReductionInterval(before.windows.square, after.windows.square, seed)};
  out.foretold_better = after.log_density - before.log_density;
  return out;
}

}  // namespace gyrobench::calibration
