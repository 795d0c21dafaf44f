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
#include "calibration/gls/statistics.h"
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
  std::vector<double> power(grid.size() / 2);
  for (std::size_t f = 0; f < power.size(); ++f) power[f] = std::norm(spectrum[f]);
  return power;
}

// Of the longest power-on. Where the channel feels no turn a tone speaks: in motion it cannot be
// told from the ripple of a table that turns. Of an orientation no ripple is known.
class Tones {
 public:
  Tones(const ChannelProblem& problem, const Eigen::VectorXd& residual)
      : problem_(problem), residual_(residual) {
    std::tie(first_, end_) = LongestPowerOn(problem);
    if (end_ == first_) return;
    for (Eigen::Index i = first_; i < end_; ++i) resting_ += Rests(i) ? 1 : 0;
    origin_s_ = problem.begin_s(first_);
    duration_s_ = problem.end_s(end_ - 1) - origin_s_;
    std::vector<double> lengths, samples_s;
    for (const Interval& interval : problem.intervals()) lengths.push_back(interval.duration_s);
    for (const StateHistory& history : problem.histories()) {
      const double sample_s = history.recording->median_interval_s;
      if (sample_s > 0.0) samples_s.push_back(sample_s);
    }
    row_s_ = Median(std::move(lengths));
    const double sample_s = samples_s.empty() ? row_s_ : Median(std::move(samples_s));
    constexpr double kMostFiner = 20.0;
    fine_s_ = std::max({0.5 * sample_s, row_s_ / kMostFiner, duration_s_ / kMostFineSlots});
    // Times are rounded to the grid, which takes a fifth of the power at a quarter of its rate.
    fastest_Hz_ = std::min(0.5 / sample_s, 0.25 / fine_s_);
  }

  // The one that is clearest up to half of the rate of the rows. It may be the alias of faster ones:
  // these follow, the slowest first, as rows that do not come quite evenly tell them apart.
  std::vector<ScanPeak> Best(std::size_t most) const {
    // With less than a twentieth at rest no tone is seen.
    constexpr Eigen::Index kLeastRest = 64, kLeastPart = 20;
    if (resting_ < kLeastRest || kLeastPart * resting_ < end_ - first_) return {};
    std::vector<ScanPeak> peaks = PeaksOf(OfRows(), 1);
    if (peaks.empty()) return {};
    // One residual of noise in a thousand has such a peak.
    constexpr double kByChance = 1e-3;
    const double clear = ChiSquareQuantile(std::log(kByChance / peaks.front().tried), 2.0);
    if (most == 1 || peaks.front().gain < clear) return peaks;
    // What has an alias is about as clear as that.
    const ScanPeak slow = peaks.front();
    for (const ScanPeak& peak : PeaksOf(OfSamples(), most - 1)) {
      if (peak.gain > kAsClear * slow.gain && MayAlias(peak.nonlinear, slow.nonlinear))
        peaks.push_back(peak);
    }
    return peaks;
  }

 private:
  static constexpr double kMostFineSlots = 1u << 20;
  static constexpr double kAsClear = 0.8;
  static constexpr double kUsual = 0.005;  // by which the rows' rate may be off

  struct Spectrum {
    double step_Hz = 0.0;
    double tried = 0.0;
    std::size_t begin = 0, end = 0;    // frequencies to be looked at
    std::vector<double> at_rest = {};  // gains, relative to white noise of unit variance
    std::vector<double> all = {};      // the same by all rows; of OfRows in another unit
  };

  bool Rests(Eigen::Index i) const {
    constexpr double kUnfelt = 0.01;
    if (problem_.history(i).recording->info.reference == ReferenceKind::kOrientation) return true;
    const Interval& interval = problem_.intervals()[static_cast<std::size_t>(i)];
    return interval.still ||
           std::max(interval.begin_reference_share, interval.end_reference_share) < kUnfelt;
  }

  std::size_t SlotOf(double t_s, double step_s) const {
    return static_cast<std::size_t>(std::lround(std::max(t_s - origin_s_, 0.0) / step_s));
  }
  std::vector<double> Grid(double step_s) const {
    return std::vector<double>(PowerOfTwo(2 * (SlotOf(origin_s_ + duration_s_, step_s) + 2)), 0.0);
  }
  static double StepOf(const std::vector<double>& grid, double step_s) {
    return 1.0 / (static_cast<double>(grid.size()) * step_s);
  }
  // Slower than five periods a measurement is drift.
  double slowest_Hz() const { return 5.0 / duration_s_; }

  // Of the residual on a grid of the rows' length, as if all were as long. None where it would be
  // too long.
  Spectrum OfRows() const {
    constexpr double kMostSlots = 1u << 22;
    if (duration_s_ > kMostSlots * row_s_) return {};
    std::vector<double> at_rest = Grid(row_s_), all = at_rest;
    for (Eigen::Index i = first_; i < end_; ++i) {
      const std::size_t slot = SlotOf(problem_.begin_s(i), row_s_);
      all[slot] += residual_(i);
      if (Rests(i)) at_rest[slot] += residual_(i);
    }
    Spectrum out{.step_Hz = StepOf(all, row_s_), .tried = duration_s_ / row_s_ + 2.0};
    out.begin = static_cast<std::size_t>(slowest_Hz() / out.step_Hz);
    out.end = all.size() / 2;
    out.at_rest = PowerOf(at_rest);
    out.all = PowerOf(all);
    for (double& gain : out.at_rest) gain *= 2.0 / static_cast<double>(resting_);
    return out;
  }

  // The faster ones, on a grid of about the samples' length: a row shows of a tone what its integral
  // is at the end less what it is at the begin.
  Spectrum OfSamples() const {
    const double half_of_rows_Hz = 0.5 / row_s_;
    if (fastest_Hz_ <= half_of_rows_Hz) return {};
    std::vector<double> at_rest = Grid(fine_s_), all = at_rest;
    std::map<std::size_t, double> rests, rows;  // by their lengths in slots: how many
    for (Eigen::Index i = first_; i < end_; ++i) {
      const std::size_t begin = SlotOf(problem_.begin_s(i), fine_s_),
                        end = SlotOf(problem_.end_s(i), fine_s_);
      all[begin] -= residual_(i);
      all[end] += residual_(i);
      rows[end - begin] += 1.0;
      if (!Rests(i)) continue;
      at_rest[begin] -= residual_(i);
      at_rest[end] += residual_(i);
      rests[end - begin] += 1.0;
    }
    Spectrum out{.step_Hz = StepOf(all, fine_s_), .tried = 2.0 * fastest_Hz_ * duration_s_};
    out.begin = static_cast<std::size_t>(half_of_rows_Hz / out.step_Hz) + 1;
    out.end = std::min(static_cast<std::size_t>(fastest_Hz_ / out.step_Hz), all.size() / 2);
    out.at_rest = GainsOf(at_rest, rests, out);
    out.all = GainsOf(all, rows, out);
    return out;
  }

  // Of a grid of ends less begins.
  std::vector<double> GainsOf(const std::vector<double>& grid,
                              const std::map<std::size_t, double>& lengths,
                              const Spectrum& of) const {
    std::vector<double> gains = PowerOf(grid);
    const double step_rad = std::numbers::pi * of.step_Hz * fine_s_;
    double count = 0.0;
    for (const auto& [slots, rows] : lengths) count += rows;
    for (std::size_t f = of.begin; f < of.end; ++f) {
      double square = 0.0;
      for (const auto& [slots, rows] : lengths)
        square += rows * std::pow(2.0 * std::sin(step_rad * static_cast<double>(f * slots)), 2);
      // Rows of about a whole number of periods hardly show it.
      constexpr double kShown = 1e-6;
      const bool shown =
          square > kShown * count && !IsAliasOfDrift(of.step_Hz * static_cast<double>(f));
      gains[f] *= shown ? 2.0 / square : 0.0;
    }
    return gains;
  }

  bool IsAliasOfDrift(double f_Hz) const {
    return std::fabs(std::remainder(f_Hz, 1.0 / row_s_)) < slowest_Hz() + kUsual * f_Hz;
  }

  // Whether rows may show a tone as a slower one. They follow each other at a rate that is not quite
  // the usual one, or where longer and shorter ones take turns at half of it.
  bool MayAlias(double f_Hz, double slower_Hz) const {
    // What is folded at the whole rate is, at half of it, on one side or the other.
    const double half_Hz = 0.5 / row_s_;
    const double folded_Hz = std::fabs(std::remainder(f_Hz, half_Hz));
    const double off_Hz =
        std::min(std::fabs(folded_Hz - slower_Hz), std::fabs(half_Hz - folded_Hz - slower_Hz));
    return off_Hz < slowest_Hz() + kUsual * f_Hz;
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
      // With less than a fifth at rest a tone is a last resort.
      constexpr Eigen::Index kFewPart = 5;
      peak.last_resort = kFewPart * resting_ < end_ - first_;
    }
    return peaks;
  }

  // Numbers of frequencies, the slowest first. Short rests far from each other show several tones as
  // clearly as the true one: of these it is those that all rows show best.
  static std::vector<std::size_t> Clearest(const Spectrum& spectrum, std::size_t most) {
    constexpr std::size_t kSamePeak = 3;
    const std::vector<double>&at_rest = spectrum.at_rest, &all = spectrum.all;
    double highest = 0.0;
    for (std::size_t f = spectrum.begin; f < spectrum.end; ++f)
      highest = std::max(highest, at_rest[f]);
    std::vector<std::size_t> out;
    for (std::size_t f = spectrum.begin; f < spectrum.end; ++f) {
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
  double origin_s_ = 0.0, duration_s_ = 0.0;
  double row_s_ = 0.0, fine_s_ = 0.0, fastest_Hz_ = 0.0;
};

}  // namespace

std::vector<ScanPeak> ScanTones(const ChannelProblem& problem, const Eigen::VectorXd& residual,
                                std::size_t most_peaks) {
  return Tones(problem, residual).Best(most_peaks);
}

}  // namespace gyrobench::calibration
