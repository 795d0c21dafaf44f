#include "calibration/state/timing_error.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

#include "base/robust.h"

namespace gyrobench::calibration {
namespace {

// Two passes of nearly one angle at one speed. What two residuals make of the variance of a single
// angle: half the square of their difference, and their product, which is what repeats.
struct Pair {
  double per_timing = 0.0;  // VariancePerTiming
  double differs_deg2 = 0.0, repeats_deg2 = 0.0;
};

// Angles that are means of as many readings as most are.
std::vector<SteadyAngle> OfUsualReadings(const std::vector<SteadyAngle>& angles) {
  constexpr double kUsual = 1.25;
  std::vector<double> readings;
  for (const SteadyAngle& angle : angles) readings.push_back(angle.readings);
  const double usual = Median(std::move(readings));
  std::vector<SteadyAngle> out;
  for (const SteadyAngle& angle : angles) {
    if (angle.readings < kUsual * usual && usual < kUsual * angle.readings) out.push_back(angle);
  }
  return out;
}

int SpeedClass(const SteadyAngle& angle) {
  constexpr double kWidth = 0.05;
  return static_cast<int>(std::floor(std::log(std::fabs(angle.rate_deg_s)) / kWidth));
}

// Angles that are nearer than `near_deg` count as one.
std::vector<Pair> PairsOf(std::vector<SteadyAngle> angles, double near_deg) {
  constexpr std::size_t kApart = 8;  // places; nearer ones share what the gyro carried
  std::ranges::sort(angles, {}, [](const SteadyAngle& angle) {
    return std::tuple(SpeedClass(angle), std::remainder(angle.angle_deg, 360.0));
  });
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const SteadyAngle& one = angles[i];
    for (std::size_t j = i + 1; j < angles.size(); ++j) {
      const SteadyAngle& other = angles[j];
      const double apart_deg = std::fabs(std::remainder(other.angle_deg - one.angle_deg, 360.0));
      if (SpeedClass(other) != SpeedClass(one) || !(apart_deg < near_deg)) break;
      if (std::max(one.place, other.place) - std::min(one.place, other.place) < kApart) continue;
      const double difference_deg = other.residual_deg - one.residual_deg;
      const double errors = 2.0 + 1.0 / one.neighbours + 1.0 / other.neighbours;
      pairs.push_back({VariancePerTiming(one.rate_deg_s, one.readings),
                       difference_deg * difference_deg / errors,
                       2.0 * one.residual_deg * other.residual_deg / errors});
      break;
    }
  }
  return pairs;
}

struct Line {
  AngleErrors errors;
  double timing_std_error_s2 = 0.0;
};

// Through the pairs, each weighed by what `so_far` says that it scatters by. Nothing where the
// speeds do not differ.
std::optional<Line> FitLine(std::span<const Pair> pairs, const AngleErrors& so_far) {
  constexpr double kMostSquare = 36.0, kLeastRatio = 2.0;
  const auto [slowest, fastest] = std::ranges::minmax(pairs, {}, &Pair::per_timing);
  if (!(fastest.per_timing > kLeastRatio * slowest.per_timing)) return std::nullopt;
  struct Row {
    double weight, x, y;
  };
  std::vector<Row> rows;
  rows.reserve(pairs.size());
  double w = 0.0, wx = 0.0, wxx = 0.0, wy = 0.0, wxy = 0.0;
  for (const Pair& pair : pairs) {
    const double x = pair.per_timing;
    const double expected_deg2 = so_far.reading_deg2 + so_far.timing_s2 * x;
    const double weight = 1.0 / (expected_deg2 * expected_deg2);
    rows.push_back({weight, x, std::min(pair.differs_deg2, kMostSquare * expected_deg2)});
    w += weight;
    wx += weight * x;
    wxx += weight * x * x;
    wy += weight * rows.back().y;
    wxy += weight * x * rows.back().y;
  }
  const double det = w * wxx - wx * wx;
  Line out{{(wxx * wy - wx * wxy) / det, (w * wxy - wx * wy) / det}};
  double variance = 0.0;
  for (const Row& row : rows) {
    const double off = row.y - out.errors.reading_deg2 - out.errors.timing_s2 * row.x;
    variance += std::pow(row.weight * (w * row.x - wx) / det * off, 2);
  }
  out.timing_std_error_s2 = std::sqrt(variance);
  return out;
}

std::optional<Line> FitWithItsOwnWeights(std::span<const Pair> pairs) {
  constexpr double kLeastPart = 1e-3;
  constexpr int kRounds = 8;
  double mean_deg2 = 0.0;
  for (const Pair& pair : pairs) mean_deg2 += pair.differs_deg2 / static_cast<double>(pairs.size());
  if (!(mean_deg2 > 0.0)) return std::nullopt;
  std::optional<Line> line = Line{{mean_deg2, 0.0}, 0.0};
  for (int round = 0; round < kRounds; ++round) {
    line = FitLine(pairs, {std::max(line->errors.reading_deg2, kLeastPart * mean_deg2),
                           std::max(line->errors.timing_s2, 0.0)});
    if (!line) return std::nullopt;
  }
  line->errors.reading_deg2 = std::max(line->errors.reading_deg2, kLeastPart * mean_deg2);
  return line;
}

// What is left of a wave grows with the speed only until the table turns by a good part of its
// period from one place to the next: among the faster speeds the line is as steep for timing alone.
bool GoesOnGrowing(std::vector<Pair> pairs, const AngleErrors& errors) {
  constexpr double kFast = 0.05, kAsFast = 0.25;
  const double fastest = std::ranges::max(pairs, {}, &Pair::per_timing).per_timing;
  std::erase_if(pairs, [&](const Pair& pair) { return pair.per_timing < kFast * fastest; });
  const std::optional<Line> line = FitWithItsOwnWeights(pairs);
  return !line || line->errors.timing_s2 > kAsFast * errors.timing_s2;
}

// Of the faster half of the speeds: whether times make at least half as much of the variance as
// what repeats does, since of that a part differs between two angles that are a little apart.
bool RepeatsLittle(std::span<const Pair> pairs, const AngleErrors& errors) {
  constexpr double kLittle = 2.0;
  const double fastest = std::ranges::max(pairs, {}, &Pair::per_timing).per_timing;
  double by_timing_deg2 = 0.0, repeats_deg2 = 0.0;
  for (const Pair& pair : pairs) {
    if (pair.per_timing < 0.25 * fastest) continue;
    by_timing_deg2 += errors.timing_s2 * pair.per_timing;
    repeats_deg2 += pair.repeats_deg2;
  }
  return kLittle * by_timing_deg2 > repeats_deg2;
}

// Rounding errs by half a step at most, and by less where the table hardly turns.
bool IsMoreThanRounding(std::span<const Pair> pairs, const AngleErrors& errors, double step_deg) {
  const double fastest = std::ranges::max(pairs, {}, &Pair::per_timing).per_timing;
  return !(step_deg > 0.0) || errors.timing_s2 * fastest > 0.25 * step_deg * step_deg;
}

}  // namespace

double VariancePerTiming(double rate_deg_s, double readings) {
  return rate_deg_s * rate_deg_s / readings;
}

double AngleErrors::TimingShare(double rate_deg_s, double readings) const {
  const double timing_deg2 = timing_s2 * VariancePerTiming(rate_deg_s, readings);
  return timing_deg2 > 0.0 ? timing_deg2 / (timing_deg2 + reading_deg2) : 0.0;
}

std::optional<AngleErrors> FindAngleErrors(const std::vector<SteadyAngle>& angles,
                                           double step_deg) {
  constexpr std::size_t kLeast = 40;
  constexpr double kSigmas = 5.0, kSure = 3.0;
  if (angles.size() < kLeast) return std::nullopt;
  const std::vector<SteadyAngle> usual = OfUsualReadings(angles);
  std::vector<Pair> pairs;
  for (const double near_deg : {0.25, 0.5, 1.0, 2.0}) {
    if (pairs.size() < kLeast) pairs = PairsOf(usual, near_deg);
  }
  if (pairs.size() < kLeast) return std::nullopt;
  const std::optional<Line> line = FitWithItsOwnWeights(pairs);
  if (!line) return std::nullopt;
  AngleErrors errors = line->errors;
  const bool clear = errors.timing_s2 > kSigmas * line->timing_std_error_s2 &&
                     IsMoreThanRounding(pairs, errors, step_deg) && RepeatsLittle(pairs, errors) &&
                     GoesOnGrowing(pairs, errors);
  if (clear) return errors;
  errors.timing_at_most_s2 = std::max(errors.timing_s2, 0.0) + kSure * line->timing_std_error_s2;
  errors.timing_s2 = 0.0;
  return errors;
}

}  // namespace gyrobench::calibration
