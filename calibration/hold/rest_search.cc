#include "calibration/hold/rest_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/robust.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Vector3d;

constexpr double kWindow_s = 0.5;
// Rests are most of a recording of held poses; a fifth of its windows is quiet in all of them.
constexpr double kQuietShare = 0.2;
// Heaps nearer than this factor are one: white noise alone spreads by 1.1, a hand's tremble by 3.
constexpr double kHeapsApart = 6.0;
constexpr double kShortestRest_s = 0.8;
// Of the rate above the usual of the same rest, where motion begins or has not ended.
constexpr double kEdge = 3.0;
// Of the accelerometer's scatter above the usual of all rests.
constexpr double kShaken = 5.0;
// Largest turn within a rest, as a share of what a turn makes in one second.
constexpr double kWidestTurn = 0.03;

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

// Mean and mean square about it over the window that is centred on each epoch.
struct Window {
  Vector3d mean = Vector3d::Zero();
  double scatter2 = 0.0;
};

template <typename Value>
std::vector<Window> Windows(std::span<const Epoch> epochs, const Value& value) {
  std::vector<Window> out(epochs.size());
  std::size_t first = 0, last = 0;
  Vector3d sum = Vector3d::Zero();
  const Vector3d origin = epochs.empty() ? Vector3d::Zero() : value(epochs[0]);
  double square = 0.0;
  for (std::size_t i = 0; i < epochs.size(); ++i) {
    const double middle_s = 0.5 * (epochs[i].begin_s + epochs[i].end_s);
    for (; last < epochs.size() && (last <= i || epochs[last].begin_s < middle_s + 0.5 * kWindow_s);
         ++last) {
      const Vector3d v = value(epochs[last]) - origin;
      sum += v;
      square += v.squaredNorm();
    }
    for (; first < i && epochs[first].end_s < middle_s - 0.5 * kWindow_s; ++first) {
      const Vector3d v = value(epochs[first]) - origin;
      sum -= v;
      square -= v.squaredNorm();
    }
    const double n = static_cast<double>(last - first);
    const Vector3d mean = sum / n;
    out[i] = {mean + origin, std::max(0.0, square / n - mean.squaredNorm())};
  }
  return out;
}

// Otsu's level of values in [low, high], by 256 bins.
double OtsuLevel(const std::vector<double>& values) {
  constexpr int kBins = 256;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double width = (*high - *low) / kBins;
  if (!(width > 0.0)) return *high;
  std::array<double, kBins> count = {};
  for (const double value : values)
    ++count[static_cast<std::size_t>(std::min(kBins - 1.0, (value - *low) / width))];
  double total = 0.0, moment = 0.0;
  for (int b = 0; b < kBins; ++b) {
    total += count[static_cast<std::size_t>(b)];
    moment += b * count[static_cast<std::size_t>(b)];
  }
  // The middle of all bins that part equally well: an empty valley is parted at its centre.
  double best = -1.0, below = 0.0, below_moment = 0.0;
  int first = 0, last = 0;
  for (int b = 0; b + 1 < kBins; ++b) {
    below += count[static_cast<std::size_t>(b)];
    below_moment += b * count[static_cast<std::size_t>(b)];
    if (below == 0.0 || below == total) continue;
    const double apart = below_moment / below - (moment - below_moment) / (total - below);
    const double between = below * (total - below) * apart * apart;
    if (between > best * (1.0 + 1e-9)) {
      best = between;
      first = b;
    }
    if (between >= best * (1.0 - 1e-9)) last = b;
  }
  return *low + width * (0.5 * (first + last) + 1.0);
}

Vector3d RateOf(const Epoch& epoch) { return epoch.rate(); }
Vector3d AccelOf(const Epoch& epoch) {
  return epoch.accel_g.allFinite() ? epoch.accel_g : Vector3d::Zero();
}

class RestSearcher {
 public:
  explicit RestSearcher(std::span<const Epoch> epochs)
      : epochs_(epochs), gyro_(Windows(epochs, RateOf)), accel_(Windows(epochs, AccelOf)) {}

  RestSearch Run() {
    if (epochs_.size() < 8) return out_;
    FindOffset();
    FindLevel();
    if (!(out_.motion_level > kHeapsApart * out_.rest_level)) return out_;
    std::vector<EpochRange> found = Below();
    DropShaken(&found);
    for (EpochRange& range : found) range = Trimmed(range);
    std::erase_if(found, [](const EpochRange& range) { return range.first >= range.last; });
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::size_t before = out_.rests.empty() ? 0 : out_.rests.back().last + 1;
      const std::size_t after = i + 1 < found.size() ? found[i + 1].first - 1 : epochs_.size();
      Cut(Extended(found[i], before, after));
    }
    return out_;
  }

 private:
  // The median of what quiet windows read.
  void FindOffset() {
    std::vector<double> scatter;
    for (const Window& window : gyro_) scatter.push_back(window.scatter2);
    const double quiet = Quantile(scatter, kQuietShare);
    for (int c = 0; c < 3; ++c) {
      std::vector<double> means;
      for (const Window& window : gyro_)
        if (window.scatter2 <= quiet) means.push_back(window.mean[c]);
      out_.offset[c] = Median(means);
    }
  }

  void FindLevel() {
    level_.reserve(gyro_.size());
    std::vector<double> logs, usable;
    for (std::size_t i = 0; i < gyro_.size(); ++i) {
      const double square = gyro_[i].scatter2 + (gyro_[i].mean - out_.offset).squaredNorm();
      level_.push_back(std::sqrt(square));
      if (epochs_[i].usable && level_[i] > 0.0) usable.push_back(level_[i]);
    }
    if (usable.size() < 8) return;
    // Counts that stand still have no noise; a thousandth of the fastest is rest in any case.
    const double floor = 1e-4 * *std::max_element(usable.begin(), usable.end());
    for (const double level : usable) logs.push_back(std::log(std::max(level, floor)));
    out_.threshold = std::exp(OtsuLevel(logs));
    std::vector<double> rest, motion;
    for (const double level : usable) (level < out_.threshold ? rest : motion).push_back(level);
    out_.rest_level = std::max(floor, Median(rest));
    out_.motion_level = Median(motion);
  }

  bool Rests(std::size_t i) const {
    return epochs_[i].usable && epochs_[i].accel_g.allFinite() && level_[i] < out_.threshold;
  }

  std::vector<EpochRange> Below() const {
    std::vector<EpochRange> found;
    for (std::size_t i = 0; i < epochs_.size(); ++i) {
      if (!Rests(i)) continue;
      if (found.empty() || found.back().last != i) found.push_back({i, i});
      found.back().last = i + 1;
    }
    return found;
  }

  // Cut where the accelerometer is shaken.
  void DropShaken(std::vector<EpochRange>* found) const {
    std::vector<double> scatter;
    for (const EpochRange& range : *found)
      for (std::size_t i = range.first; i < range.last; ++i) scatter.push_back(accel_[i].scatter2);
    const double limit = kShaken * kShaken * Median(scatter);
    std::vector<EpochRange> kept;
    for (const EpochRange& range : *found) {
      bool open = false;
      for (std::size_t i = range.first; i < range.last; ++i) {
        if (accel_[i].scatter2 > limit) {
          open = false;
          continue;
        }
        if (!open) kept.push_back({i, i});
        open = true;
        kept.back().last = i + 1;
      }
    }
    *found = std::move(kept);
  }

  // Without the ends in which the rate has not yet come down to the rest's own.
  EpochRange Trimmed(EpochRange range) const {
    std::vector<double> levels(level_.begin() + static_cast<std::ptrdiff_t>(range.first),
                               level_.begin() + static_cast<std::ptrdiff_t>(range.last));
    if (levels.empty()) return range;
    const double limit = kEdge * std::max(Median(levels), out_.rest_level);
    while (range.first < range.last && level_[range.first] > limit) ++range.first;
    while (range.first < range.last && level_[range.last - 1] > limit) --range.last;
    return range;
  }

  // The window has cut half of itself off at both ends: back to where single epochs leave what the
  // rest is like.
  EpochRange Extended(EpochRange range, std::size_t before, std::size_t after) const {
    const Likeness rate = LikenessOf(range, RateOf), accel = LikenessOf(range, AccelOf);
    const auto alike = [&](std::size_t i) {
      return epochs_[i].usable && epochs_[i].accel_g.allFinite() &&
             rate.Holds(RateOf(epochs_[i])) && accel.Holds(AccelOf(epochs_[i]));
    };
    while (range.first > before && alike(range.first - 1)) --range.first;
    while (range.last < after && alike(range.last)) ++range.last;
    // A hand pulls before it is seen to: the outermost epoch is not trusted.
    return {range.first + 1, range.last - 1};
  }

  // Mean of a rest's epochs and the largest distance from it that belongs to the rest: 2.3 times
  // the root mean square, four standard deviations of each axis.
  struct Likeness {
    Vector3d mean = Vector3d::Zero();
    double widest2 = 0.0;
    bool Holds(const Vector3d& value) const { return (value - mean).squaredNorm() <= widest2; }
  };
  template <typename Value>
  Likeness LikenessOf(const EpochRange& range, const Value& value) const {
    Likeness out;
    const auto n = static_cast<double>(range.last - range.first);
    for (std::size_t i = range.first; i < range.last; ++i) out.mean += value(epochs_[i]) / n;
    for (std::size_t i = range.first; i < range.last; ++i)
      out.widest2 += 2.3 * 2.3 / n * (value(epochs_[i]) - out.mean).squaredNorm();
    return out;
  }

  // Into pieces that turn by little.
  void Cut(const EpochRange& range) {
    if (range.last <= range.first) return;
    if (epochs_[range.last - 1].end_s - epochs_[range.first].begin_s < kShortestRest_s) return;
    Vector3d angle = Vector3d::Zero();
    double widest = 0.0;
    for (std::size_t i = range.first; i < range.last; ++i) {
      angle += epochs_[i].angle - out_.offset * epochs_[i].duration_s();
      widest = std::max(widest, angle.norm());
    }
    if (widest <= kWidestTurn * out_.motion_level) {
      out_.rests.push_back(range);
      return;
    }
    const std::size_t middle = (range.first + range.last) / 2;
    Cut({range.first, middle});
    Cut({middle + 1, range.last});
  }

  std::span<const Epoch> epochs_;
  std::vector<Window> gyro_, accel_;
  std::vector<double> level_;
  RestSearch out_;
};

}  // namespace

RestSearch FindRests(std::span<const Epoch> epochs) { return RestSearcher(epochs).Run(); }

}  // namespace gyrobench::calibration
