// Tones of the bias: at every frequency, in about O(n log n).
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <map>
#include <numbers>
#include <tuple>
#include <unsupported/Eigen/FFT>
#include <utility>
#include <vector>

#include "base/robust.h"
#include "calibration/trace/scans.h"

namespace gyrobench::calibration {
namespace {

using Complex = std::complex<double>;

std::size_t PowerOfTwo(std::size_t least) {
  std::size_t size = 2;
  while (size < least) size *= 2;
  return size;
}

// First row of the longest power-on, and the one behind its last: where power-ons differ in their
// beginning a tone's phase is another.
std::pair<Eigen::Index, Eigen::Index> LongestPowerOn(const ChannelProblem& problem) {
  const std::vector<Eigen::Index>& begins = problem.power_on_begins();
  std::pair<Eigen::Index, Eigen::Index> longest = {0, 0};
  for (std::size_t k = 0; k < begins.size(); ++k) {
    const Eigen::Index end = k + 1 < begins.size() ? begins[k + 1] : problem.rows();
    if (end - begins[k] > longest.second - longest.first) longest = {begins[k], end};
  }
  return longest;
}

// Of a spectrum, up to half of its frequencies.
std::vector<double> PowerOf(const std::vector<double>& grid) {
  if (grid.empty()) return {};
  Eigen::FFT<double> fft;
  std::vector<Complex> spectrum;
  fft.fwd(spectrum, grid);
  std::vector<double> power;
  for (std::size_t f = 0; f < grid.size() / 2; ++f) power.push_back(std::norm(spectrum[f]));
  return power;
}

// What the channel felt of no turn in the longest power-on, and all of it: in motion a tone cannot
// be told from the ripple of a table that turns. Of an orientation no ripple is known.
class Tones {
 public:
  Tones(const ChannelProblem& problem, const Eigen::VectorXd& residual)
      : problem_(problem), residual_(residual) {
    std::tie(first_, end_) = LongestPowerOn(problem);
    for (Eigen::Index i = first_; i < end_; ++i) resting_ += Rests(i) ? 1 : 0;
    std::vector<double> lengths, samples_s;
    for (const Interval& interval : problem.intervals()) lengths.push_back(interval.duration_s);
    for (const StateHistory& history : problem.histories()) {
      const double sample_s = history.recording->median_interval_s;
      if (sample_s > 0.0) samples_s.push_back(sample_s);
    }
    row_s_ = Median(std::move(lengths));
    const double sample_s = samples_s.empty() ? row_s_ : Median(std::move(samples_s));
    fine_s_ = std::max(0.5 * sample_s, row_s_ / kMostFiner);
    fastest_Hz_ = 0.5 / sample_s;
  }

  // Those that are clearest, the slowest first. What is clear below half of the rate of the rows may
  // be the alias of a faster one: rows do not come quite evenly, which tells the two apart.
  std::vector<ScanPeak> Best(std::size_t most) const {
    // With less than a twentieth at rest no tone is seen, with less than a fifth it is a last
    // resort.
    constexpr Eigen::Index kLeastRest = 64, kLeastPart = 20;
    if (resting_ < kLeastRest || kLeastPart * resting_ < end_ - first_) return {};
    std::vector<ScanPeak> slow = PeaksOf(OfRows(), 1);
    if (slow.empty() || !slow.front().ComesNear(-std::log(slow.front().tried))) return slow;
    std::vector<ScanPeak> all = PeaksOf(OfSamples(), most);
    return all.empty() ? slow : all;
  }

 private:
  static constexpr double kMostFiner = 20.0;

  bool Rests(Eigen::Index i) const {
    constexpr double kUnfelt = 0.01;
    if (problem_.history(i).recording->info.reference == ReferenceKind::kOrientation) return true;
    const Interval& interval = problem_.intervals()[static_cast<std::size_t>(i)];
    return interval.still ||
           std::max(interval.begin_reference_share, interval.end_reference_share) < kUnfelt;
  }

  struct Spectrum {
    double step_Hz = 0.0, tried = 0.0;
    std::size_t slowest = 0;           // slower than five periods a measurement is drift
    std::vector<double> at_rest, all;  // gains, relative to white noise of unit variance
  };

  // Of the residual on a grid of the rows' length, as if all were as long.
  Spectrum OfRows() const {
    std::vector<double> at_rest, all;
    Spectrum out = Empty(row_s_, &at_rest, &all);
    for (Eigen::Index i = first_; i < end_ && !all.empty(); ++i) {
      const std::size_t slot = SlotOf(0.5 * (problem_.begin_s(i) + problem_.end_s(i)), row_s_);
      all[slot] += residual_(i);
      if (Rests(i)) at_rest[slot] += residual_(i);
    }
    out.at_rest = PowerOf(at_rest);
    out.all = PowerOf(all);
    for (double& gain : out.at_rest) gain *= 2.0 / static_cast<double>(resting_);
    return out;
  }

  // Of the samples' length: a tone is in a row by what its integral is at the end less what it is at
  // the begin.
  Spectrum OfSamples() const {
    std::vector<double> at_rest, all;
    Spectrum out = Empty(fine_s_, &at_rest, &all);
    std::map<std::size_t, double> lengths;  // of rows at rest, in slots: how many
    for (Eigen::Index i = first_; i < end_ && !all.empty(); ++i) {
      const std::size_t begin = SlotOf(problem_.begin_s(i), fine_s_),
                        end = SlotOf(problem_.end_s(i), fine_s_);
      all[begin] -= residual_(i);
      all[end] += residual_(i);
      if (!Rests(i)) continue;
      at_rest[begin] -= residual_(i);
      at_rest[end] += residual_(i);
      lengths[end - begin] += 1.0;
    }
    out.at_rest = PowerOf(at_rest);
    out.all = PowerOf(all);
    const double step_rad = std::numbers::pi * out.step_Hz * fine_s_;
    for (std::size_t f = 0; f < out.at_rest.size(); ++f) {
      double square = 0.0;
      for (const auto& [slots, count] : lengths)
        square += count * std::pow(2.0 * std::sin(step_rad * static_cast<double>(f * slots)), 2);
      // Rows of a whole number of periods do not show it.
      constexpr double kShown = 1e-6;
      const bool shown = square > kShown * static_cast<double>(resting_);
      out.at_rest[f] *= shown ? 2.0 / square : 0.0;
      out.all[f] *= shown ? 1.0 / square : 0.0;
    }
    return out;
  }

  std::size_t SlotOf(double t_s, double step_s) const {
    return static_cast<std::size_t>(std::lround((t_s - problem_.begin_s(first_)) / step_s));
  }

  // Grids that are empty where they would be too long.
  Spectrum Empty(double step_s, std::vector<double>* at_rest, std::vector<double>* all) const {
    constexpr std::size_t kMost = 1u << 22;
    const std::size_t slots = SlotOf(problem_.end_s(end_ - 1), step_s) + 2;
    const std::size_t size = slots > kMost ? 0 : PowerOfTwo(2 * slots);
    at_rest->assign(size, 0.0);
    all->assign(size, 0.0);
    return {1.0 / (static_cast<double>(size) * step_s),
            static_cast<double>(slots),
            5 * size / slots,
            {},
            {}};
  }

  std::vector<ScanPeak> PeaksOf(const Spectrum& spectrum, std::size_t most) const {
    std::vector<ScanPeak> peaks;
    for (const std::size_t f : Clearest(spectrum, most)) {
      ScanPeak& peak = peaks.emplace_back();
      peak.effect = &ScannedEffect(Search::kFrequency, EffectDomain::kRateIntegral);
      peak.nonlinear = spectrum.step_Hz * static_cast<double>(f);
      peak.row = first_;
      peak.gain = spectrum.at_rest[f];
      peak.tried = spectrum.tried;
      constexpr Eigen::Index kFewPart = 5;
      peak.last_resort = kFewPart * resting_ < end_ - first_;
    }
    return peaks;
  }

  // Numbers of frequencies. Short rests far from each other show several tones as clearly as the
  // true one: of these those that all rows show come first.
  std::vector<std::size_t> Clearest(const Spectrum& spectrum, std::size_t most) const {
    constexpr double kAsClear = 0.8;
    constexpr std::size_t kSamePeak = 3;
    const std::vector<double>&at_rest = spectrum.at_rest, &all = spectrum.all;
    const std::size_t fastest =
        std::min(at_rest.size(), static_cast<std::size_t>(fastest_Hz_ / spectrum.step_Hz));
    double highest = 0.0;
    for (std::size_t f = spectrum.slowest; f < fastest; ++f)
      highest = std::max(highest, at_rest[f]);
    std::vector<std::size_t> out;
    for (std::size_t f = spectrum.slowest; f < fastest; ++f) {
      if (!(at_rest[f] > kAsClear * highest)) continue;
      if (out.empty() || f > out.back() + kSamePeak) {
        out.push_back(f);
      } else if (all[f] > all[out.back()]) {
        out.back() = f;
      }
    }
    std::ranges::stable_sort(out, std::greater(), [&](std::size_t f) { return all[f]; });
    out.resize(std::min(out.size(), most));
    std::ranges::sort(out);
    return out;
  }

  const ChannelProblem& problem_;
  const Eigen::VectorXd& residual_;
  Eigen::Index first_ = 0, end_ = 0, resting_ = 0;  // rows of the longest power-on
  double row_s_ = 0.0, fine_s_ = 0.0, fastest_Hz_ = 0.0;
};

}  // namespace

std::vector<ScanPeak> ScanTones(const ChannelProblem& problem, const Eigen::VectorXd& residual,
                                std::size_t most_peaks) {
  return Tones(problem, residual).Best(most_peaks);
}

}  // namespace gyrobench::calibration
