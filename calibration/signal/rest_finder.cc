#include "calibration/signal/rest_finder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr double kShortestRest_s = 0.5;
constexpr double kFinestTolerance_deg = 0.03;
constexpr double kCoarsestTolerance_deg = 0.25;
constexpr double kLevelMemory_s = 2.0;
constexpr double kLeastScatter_deg = 1e-3;
constexpr int kBlock = 16;

}  // namespace

double RestFinder::tolerance_deg() const {
  const double step = step_deg_ < kCoarsestTolerance_deg ? 1.1 * step_deg_ : 0.0;
  return std::clamp(std::max(6.0 * scatter_deg_, step), kFinestTolerance_deg,
                    kCoarsestTolerance_deg);
}

void RestFinder::Reset() {
  size_ = 0;
  resting_ = false;
  within_ = false;
  outside_ = 0;
}

// Second differences of a smooth motion are small: their scatter, least over blocks, is the
// reading's.
void RestFinder::Learn(double t_s, double angle_deg) {
  if (size_ < 2 || t_s - back(1).t_s > kShortestRest_s) return;
  const double step = std::fabs(angle_deg - back(0).angle_deg);
  if (step > 1e-9) step_deg_ = std::min(step_deg_, step);
  const double second = angle_deg - 2.0 * back(0).angle_deg + back(1).angle_deg;
  block_sum_ += second * second;
  if (++block_count_ < kBlock) return;
  const double scatter = std::max(kLeastScatter_deg, std::sqrt(block_sum_ / (6.0 * kBlock)));
  if (!scatter_known_ || scatter < 0.5 * scatter_deg_) {
    scatter_deg_ = scatter;
  } else {
    scatter_deg_ *= scatter < scatter_deg_ ? 0.96 : 1.01;
  }
  scatter_known_ = true;
  block_sum_ = 0.0;
  block_count_ = 0;
}

bool RestFinder::TryRest() {
  double low = back(0).angle_deg, high = low;
  std::size_t n = 0;
  while (n < size_ && (n < 3 || back(0).t_s - back(n).t_s < kShortestRest_s)) {
    low = std::min(low, back(n).angle_deg);
    high = std::max(high, back(n).angle_deg);
    ++n;
  }
  if (n == size_) return false;  // the readings do not reach back far enough
  low = std::min(low, back(n).angle_deg);
  high = std::max(high, back(n).angle_deg);
  const double tolerance = tolerance_deg();
  if (high - low > 2.0 * tolerance) return false;
  double sum = 0.0;
  const std::size_t half = std::max<std::size_t>(1, n / 2);
  for (std::size_t i = 0; i < half; ++i) sum += back(i).angle_deg;
  level_deg_ = sum / static_cast<double>(half);
  std::size_t first = 0;
  while (first + 1 < size_ && std::fabs(back(first + 1).angle_deg - level_deg_) <= tolerance)
    ++first;
  rest_begin_s_ = back(first).t_s;
  last_at_rest_s_ = back(0).t_s;
  return true;
}

RestFinder::Change RestFinder::Add(double t_s, double angle_deg) {
  if (size_ > 0 && t_s - back(0).t_s < kClosestReadings_s) return Change::kNone;
  Learn(t_s, angle_deg);
  ring_[next_] = Reading{t_s, angle_deg};
  next_ = (next_ + 1) % kRing;
  size_ = std::min(size_ + 1, kRing);
  if (!resting_) {
    resting_ = TryRest();
    within_ = resting_;
    outside_ = 0;
    return resting_ ? Change::kRestBegan : Change::kNone;
  }
  within_ = std::fabs(angle_deg - level_deg_) <= tolerance_deg();
  if (within_) {
    // Off both its neighbours, and not at the edge of the tolerance with them, as where a hand
    // sways.
    const double off_deg = std::min(std::fabs(back(1).angle_deg - angle_deg),
                                    std::fabs(back(1).angle_deg - back(2).angle_deg));
    const bool outlier = outside_ == 1 && off_deg > tolerance_deg();
    outside_ = 0;
    level_deg_ +=
        (angle_deg - level_deg_) * std::min(1.0, (t_s - last_at_rest_s_) / kLevelMemory_s);
    last_at_rest_s_ = t_s;
    return outlier ? Change::kOutlier : Change::kNone;
  }
  if (++outside_ < 2) return Change::kNone;
  Reset();
  size_ = 2;  // the two readings outside may be the first of the next rest
  return Change::kRestEnded;
}

namespace {

// A signal at the nodes and what of its change over half a second counts as motion.
struct Handled {
  std::vector<double> value;
  double limit = 0.0;
};

Handled Watch(std::vector<double> value, double least) {
  Handled out{std::move(value), 0.0};
  std::vector<double> changes;
  for (std::size_t i = 5; i < out.value.size(); ++i) {
    const double change = std::fabs(out.value[i] - out.value[i - 5]);
    if (std::isfinite(change)) changes.push_back(change);
  }
  // 6 standard deviations, from the lower quartile: at least a quarter of the time it lay still.
  if (changes.empty()) return out;
  const auto quarter = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 4);
  std::nth_element(changes.begin(), quarter, changes.end());
  out.limit = std::max(least, 6.0 * *quarter / 0.32);
  return out;
}

constexpr double kLeastRateChange_deg_s = 0.3;
constexpr double kLeastAccelChange_g = 0.01;
constexpr double kShortestStretch_s = 2.0;
constexpr std::size_t kMargin = 5;  // nodes on each side of a stretch at rest

}  // namespace

void OpenRest::Add(double t_s, const Vector3& rotation_deg) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (rotation[c].n > 0.0) change_square_deg2[c] += std::pow(rotation_deg[c] - newest_deg[c], 2);
    rotation[c].Add(t_s - coarse_begin_s, rotation_deg[c] - origin_deg[c]);
  }
  newest_deg = rotation_deg;
}

bool IsSlowTurn(const LineSums& angles, double lasts_s) {
  constexpr double kMostOfStep = 0.8;
  const double rate = std::fabs(angles.Slope());
  return angles.Explained() > kMostOfStep && rate > kSlowestTurn_deg_s &&
         rate * lasts_s > kFinestTolerance_deg;
}

bool OpenRest::Drifts() const { return Drifts(0) || Drifts(1) || Drifts(2); }

// Of a step of h between two rests of the same length a line explains three quarters at most; where
// noise of sigma is beside it the line moves by 1.5 h and leaves sqrt(sigma^2 + h^2 / 16): where it
// moves by 4 sigma it leaves 1.2 sigma and more. The noise is that of neighbouring readings (von
// Neumann, Ann. Math. Stat. 12, 1941), or rounding to counts.
bool OpenRest::Drifts(std::size_t axis) const {
  constexpr double kFewReadings = 8.0;
  constexpr double kClear = 4.5;       // standard errors of the slope
  constexpr double kMovedNoise = 4.0;  // standard deviations of a reading
  constexpr double kLeft = 1.1, kLeftOfFew = 1.3;
  // Where noise does not carry the readings over it, a count up or down may be all that there is.
  constexpr double kMovedCounts = 1.6, kCarried = 0.25;
  const LineSums& line = rotation[axis];
  if (!(line.n >= kFewReadings * axes) || !(std::fabs(line.Slope()) > kSlowestTurn_deg_s))
    return false;
  const double lasts_s = last_at_rest_s - coarse_begin_s;
  const double moved_deg = std::fabs(line.Slope()) * lasts_s;
  const double scatter_deg = std::sqrt(change_square_deg2[axis] / (2.0 * (line.n - 1.0)));
  const bool carried = scatter_deg > kCarried * count_deg;
  if (!(moved_deg > std::max(kFinestTolerance_deg, carried ? 0.0 : kMovedCounts * count_deg)))
    return false;
  if (IsSlowTurn(line, lasts_s)) return true;
  const double noise_deg = std::max(scatter_deg, count_deg / std::sqrt(12.0));
  const double left_deg = std::sqrt(std::max(line.LeftOfY(), 0.0) / (line.n - 2.0));
  return std::fabs(line.Slope()) * std::sqrt(line.SquareX()) > kClear * left_deg &&
         moved_deg > kMovedNoise * noise_deg &&
         left_deg < kLeft * (1.0 + kLeftOfFew / std::sqrt(line.n)) * noise_deg;
}

Rest OpenRest::Between(const IntegralMark& begin, const IntegralMark& end) const {
  Rest rest;
  rest.begin = begin;
  rest.end = end;
  rest.readings = readings();
  rest.reference_begin_s = coarse_begin_s;
  rest.reference_end_s = last_at_rest_s;
  rest.turns = Drifts();
  rest.count_deg = count_deg;
  for (std::size_t c = 0; c < 3; ++c) {
    const double n = std::max(1.0, rotation[c].n);
    const double mean = rotation[c].y / n;
    rest.rotation_deg[c] = origin_deg[c] + mean;
    const double variance = std::max(0.0, rotation[c].yy / n - mean * mean);
    rest.scatter_deg = std::max(rest.scatter_deg, std::sqrt(variance));
  }
  return rest;
}

namespace {

double Middle(const Rest& rest) { return 0.5 * (rest.reference_begin_s + rest.reference_end_s); }

// Mean rate about an axis of the sensor from one rest to the next; 0 where there is a pause between
// them, or more than the counts of a turn that passes for rests: a table that is moved by small
// steps does rest between them.
double RateBetween(const Rest& before, const Rest& after, std::size_t axis) {
  constexpr double kCounts = 3.0;
  const double turned_deg = after.rotation_deg[axis] - before.rotation_deg[axis];
  if (!(after.reference_begin_s - before.reference_end_s < kShortestRest_s) ||
      !(std::fabs(turned_deg) < kCounts * after.count_deg))
    return 0.0;
  const double rate = turned_deg / (Middle(after) - Middle(before));
  return std::fabs(rate) > kSlowestTurn_deg_s ? rate : 0.0;
}

void FindStairs(std::vector<Rest>* rests) {
  constexpr double kEven = 3.0;    // of one rate to the next
  constexpr double kAsLong = 2.5;  // of the longest to the shortest: next to a turn a table rests
  const auto lasts_s = [&](std::size_t i) {
    return (*rests)[i].reference_end_s - (*rests)[i].reference_begin_s;
  };
  for (std::size_t i = 1; i + 1 < rests->size(); ++i) {
    const auto [shortest_s, longest_s] = std::minmax({lasts_s(i - 1), lasts_s(i), lasts_s(i + 1)});
    if (!(longest_s < kAsLong * shortest_s)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double before = RateBetween((*rests)[i - 1], (*rests)[i], axis);
      const double after = RateBetween((*rests)[i], (*rests)[i + 1], axis);
      const double ratio = after / before;
      if (!(ratio > 1.0 / kEven && ratio < kEven)) continue;
      for (std::size_t j = i - 1; j <= i + 1; ++j) (*rests)[j].turns = true;
    }
  }
}

}  // namespace

void PartSlowTurns(Columns* columns) {
  constexpr double kLeastOfGyro_s = 0.25;
  FindStairs(&columns->rests);
  for (const Rest& rest : columns->rests) {
    if (rest.turns) columns->slow_turns.push_back({rest.reference_begin_s, rest.reference_end_s});
  }
  std::erase_if(columns->rests, [](const Rest& rest) {
    return rest.turns || rest.end.t_s - rest.begin.t_s < kLeastOfGyro_s;
  });
}

std::vector<Rest> RestsWithoutReference(const MeasurementInfo& info, const Columns& columns) {
  std::vector<Rest> out;
  const std::vector<Node>& nodes = columns.nodes;
  if (nodes.size() < 2) return out;
  const bool accel = info.accel_present[0] || info.accel_present[1] || info.accel_present[2];
  auto add = [&](std::size_t a, std::size_t b) {
    out.push_back(Rest{nodes[a].at, nodes[b].at, {}, 0.0, static_cast<std::int64_t>(b - a)});
  };
  if (!accel) {
    add(0, nodes.size() - 1);
    return out;
  }
  std::vector<Handled> watched;
  const double nominal = NominalUnitsPerDegPerS(info);
  const double units = std::isfinite(nominal) ? nominal : 100.0;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> rate(nodes.size(), 0.0), force(nodes.size(), 0.0);
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      rate[i] = (nodes[i].at.z[c] - nodes[i - 1].at.z[c]) / (nodes[i].at.t_s - nodes[i - 1].at.t_s);
      force[i] = nodes[i].accel_g[c];
    }
    if (info.gyro_present[c])
      watched.push_back(Watch(std::move(rate), kLeastRateChange_deg_s * units));
    if (info.accel_present[c]) watched.push_back(Watch(std::move(force), kLeastAccelChange_g));
  }
  std::size_t begin = 0;
  auto close = [&](std::size_t end) {
    if (end > begin + 2 * kMargin + 1 &&
        nodes[end - 1 - kMargin].at.t_s - nodes[begin + kMargin].at.t_s >= kShortestStretch_s) {
      add(begin + kMargin, end - 1 - kMargin);
    }
  };
  for (std::size_t i = kMargin; i < nodes.size(); ++i) {
    const bool moved = std::any_of(watched.begin(), watched.end(), [&](const Handled& w) {
      return std::fabs(w.value[i] - w.value[i - kMargin]) > w.limit;
    });
    if (!moved) continue;
    close(i);
    begin = i;
  }
  close(nodes.size());
  return out;
}

}  // namespace gyrobench::calibration
