#include "calibration/signal/clock_offset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <vector>

#include "calibration/signal/bad_times.h"
#include "calibration/signal/line_sums.h"

namespace gyrobench::calibration {
namespace {

constexpr double kStep_s = 0.1;
constexpr std::ptrdiff_t kLags = 50;  // 5 s
constexpr double kLeastTurned_deg = 45.0;
constexpr double kLeastTime_s = 10.0;
// The reference is silent: what turned meanwhile has no rate.
constexpr double kLongestInterval_s = 1.0;
// What is left of the rates' variance must be this small, and this much smaller than without the
// offset: latencies, filters and the noise of coarse encoders leave no such difference.
constexpr double kLeastCorrelation = 0.9;
constexpr double kLeftOfIt = 0.5;
// Motion that repeats has several offsets that do: those that leave up to so many times as much as
// the best. Of a stepper that goes to and fro, half a period off leaves a third of what the truth
// does, as backlash and lag are the same in both directions.
constexpr double kAsGood = 8.0;
// Odds, in nats.
constexpr double kClear = 25.0;

// Rates on the grid; NaN where one of the two is not known.
struct Rates {
  std::vector<double> gyro, reference;
};

std::size_t MostTurned(const Recording& recording) {
  Vector3 path_deg = {};
  const std::vector<Node>& nodes = recording.columns.nodes;
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (recording.info.gyro_present[c])
        path_deg[c] += std::fabs(nodes[k].rotation_deg[c] - nodes[k - 1].rotation_deg[c]);
    }
  }
  return static_cast<std::size_t>(std::ranges::max_element(path_deg) - path_deg.begin());
}

// Integrals are joined by straight lines between the nodes, and the rates are their differences.
// Where the reference is silent the grid begins anew, so far on that nothing is paired across.
Rates RatesOnGrid(const Recording& recording, std::size_t c) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  BadTimes bad(recording.columns.bad, c);
  Rates rates;
  bool parted = false;  // once is enough, however many silences follow
  double t_s = nodes[0].at.t_s, z = nodes[0].at.z[c], turned_deg = nodes[0].rotation_deg[c];
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    const Node &before = nodes[k - 1], &after = nodes[k];
    const double length_s = after.at.t_s - before.at.t_s;
    if (length_s > kLongestInterval_s) {
      if (!parted) rates.gyro.resize(rates.gyro.size() + kLags, kMissing);
      rates.reference.resize(rates.gyro.size(), kMissing);
      parted = true;
      t_s = after.at.t_s;
      z = after.at.z[c];
      turned_deg = after.rotation_deg[c];
    }
    for (; t_s + kStep_s <= after.at.t_s; t_s += kStep_s) {
      const double part = (t_s + kStep_s - before.at.t_s) / length_s;
      const double next_z = std::lerp(before.at.z[c], after.at.z[c], part);
      const double next_deg = std::lerp(before.rotation_deg[c], after.rotation_deg[c], part);
      const bool known = !bad.Touch(t_s, t_s + kStep_s);
      rates.gyro.push_back(known ? (next_z - z) / kStep_s : kMissing);
      rates.reference.push_back(known ? (next_deg - turned_deg) / kStep_s : kMissing);
      z = next_z;
      turned_deg = next_deg;
      parted = false;
    }
  }
  return rates;
}

// About its median, and no farther from it than the usual largest: wild values would decide alone.
void Clip(std::vector<double>* values) {
  constexpr double kUsual = 0.98, kBeyondUsual = 1.5;
  std::vector<double> known;
  std::ranges::copy_if(*values, std::back_inserter(known), [](double v) { return !std::isnan(v); });
  if (known.empty()) return;
  const auto at = [&](double share) {
    const auto nth =
        known.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(known.size() - 1));
    std::ranges::nth_element(known, nth);
    return *nth;
  };
  const double middle = at(0.5);
  for (double& value : known) value = std::fabs(value - middle);
  const double limit = kBeyondUsual * at(kUsual);
  for (double& value : *values)
    value = std::isnan(value) ? value : std::clamp(value - middle, -limit, limit);
}

struct Correlation {
  double r = 0.0, pairs = 0.0;
};

// Of gyro[i] with reference[i + lag].
Correlation CorrelationAt(const Rates& rates, std::ptrdiff_t lag) {
  const auto size = static_cast<std::ptrdiff_t>(rates.gyro.size());
  LineSums sums;
  for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -lag);
       i < size - std::max<std::ptrdiff_t>(0, lag); ++i) {
    const double g = rates.gyro[static_cast<std::size_t>(i)];
    const double r = rates.reference[static_cast<std::size_t>(i + lag)];
    if (std::isnan(g) || std::isnan(r)) continue;
    sums.Add(g, r);
  }
  const double variance = sums.SquareX() * sums.SquareY();
  return {variance > 0.0 ? sums.Product() / std::sqrt(variance) : 0.0, sums.n};
}

// Share of the variance that is left.
double Left(double r) { return std::max(1e-12, 1.0 - r * r); }

// Peaks that are about as good as the best, as indices, the nearest to 0 first.
std::vector<std::size_t> GoodPeaks(const std::vector<double>& r) {
  const double least = Left(*std::ranges::max_element(r));
  std::vector<std::size_t> peaks;
  for (std::size_t i = 1; i + 1 < r.size(); ++i) {
    const bool peak = r[i] >= r[i - 1] && r[i] >= r[i + 1];
    if (peak && r[i] >= kLeastCorrelation && Left(r[i]) <= kAsGood * least) peaks.push_back(i);
  }
  std::ranges::stable_sort(
      peaks, {}, [](std::size_t i) { return std::abs(static_cast<std::ptrdiff_t>(i) - kLags); });
  return peaks;
}

// Of a parabola through a peak and its neighbours [s].
double OffsetAt_s(const std::vector<double>& r, std::size_t peak) {
  const double before = r[peak - 1], after = r[peak + 1], bend = before - 2.0 * r[peak] + after;
  const double beside = bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
  return kStep_s * (static_cast<double>(peak) - static_cast<double>(kLags) + beside);
}

bool MovesEnough(const Rates& rates) {
  double turned_deg = 0.0, time_s = 0.0;
  for (const double rate : rates.reference) {
    if (std::isnan(rate)) continue;
    turned_deg += std::fabs(rate) * kStep_s;
    time_s += kStep_s;
  }
  return turned_deg >= kLeastTurned_deg && time_s >= kLeastTime_s;
}

}  // namespace

std::optional<ClockOffset> FindClockOffset(const Recording& recording) {
  if (recording.info.reference == ReferenceKind::kNone || recording.columns.nodes.size() < 3)
    return std::nullopt;
  Rates rates = RatesOnGrid(recording, MostTurned(recording));
  if (!MovesEnough(rates)) return std::nullopt;
  Clip(&rates.gyro);
  Clip(&rates.reference);
  // An axis may be mounted the other way round: the sign does not matter.
  std::vector<double> r;
  for (std::ptrdiff_t lag = -kLags; lag <= kLags; ++lag)
    r.push_back(std::fabs(CorrelationAt(rates, lag).r));
  const std::vector<std::size_t> peaks = GoodPeaks(r);
  constexpr std::ptrdiff_t kLatency = 1;  // step of the grid
  if (peaks.empty() || std::abs(static_cast<std::ptrdiff_t>(peaks[0]) - kLags) <= kLatency)
    return std::nullopt;
  const double best = r[peaks[0]], as_is = r[static_cast<std::size_t>(kLags)];
  const double nats = 0.5 * CorrelationAt(rates, 0).pairs * std::log(Left(as_is) / Left(best));
  if (!(nats > kClear && Left(best) < kLeftOfIt * Left(as_is))) return std::nullopt;
  ClockOffset found{OffsetAt_s(r, peaks[0]), best, as_is, {}};
  for (std::size_t i = 1; i < peaks.size(); ++i)
    found.others_late_s.push_back(OffsetAt_s(r, peaks[i]));
  return found;
}

namespace {

std::string InWords(double late_s) {
  return fmt::format("{:.2f} s {} the gyro does", std::fabs(late_s),
                     late_s > 0.0 ? "after" : "before");
}

// "take 0.50 s off the t column of the reference ...".
std::string WhatToDo(const MeasurementInfo& info, double late_s) {
  constexpr double kLargestDelay_s = 1.0;  // that a table may declare
  const bool late = late_s > 0.0;
  const double declared_s = std::fabs(late_s) + (late ? info.reference_delay_s : info.gyro_delay_s);
  std::string text = fmt::format("take {:.2f} s off the t column of the {}, as its logger wrote it",
                                 std::fabs(late_s), late ? "reference" : "gyro");
  if (info.first_row_line > 0 && declared_s <= kLargestDelay_s) {
    text += fmt::format(", or write \"# {} = {:.2f}\" above the header",
                        late ? "ref_delay_s" : "gyro_delay_s", declared_s);
  }
  return text;
}

}  // namespace

bool Contradicts(const ClockOffset& offset) {
  return std::fabs(offset.reference_late_s) > kLargestLatency_s;
}

std::string RemarkOnClocks(const MeasurementInfo& info, const ClockOffset& offset) {
  std::string others;
  for (const double late_s : offset.others_late_s) others += ", or " + InWords(late_s);
  if (!others.empty()) others += ", as the motion repeats,";
  return fmt::format(
      "the reference turns {}{} (their rates correlate by {:.3f} with this taken off, by {:.3f} as "
      "they are): the clocks of the two loggers were probably not started together, and nothing "
      "that comes from the two together can be relied on; {}{}, and repeat the command",
      InWords(offset.reference_late_s), others, offset.correlation, offset.correlation_as_is,
      others.empty() ? "" : "where the first is right, ", WhatToDo(info, offset.reference_late_s));
}

std::string RemarkOnClocks(const Recording& recording) {
  const std::optional<ClockOffset> offset = FindClockOffset(recording);
  return offset ? RemarkOnClocks(recording.info, *offset) : "";
}

}  // namespace gyrobench::calibration
