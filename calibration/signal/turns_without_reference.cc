// Whether the gyro turned in a measurement that has no reference and is taken to be at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/robust.h"
#include "calibration/signal/collector.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr double kMean_s = 0.5;
constexpr double kTurns_deg_s = 5.0, kWithin_s = 5.0, kLeastTurning_s = 1.0;
// Counts of a signed word that is written as an unsigned one stand there below zero.
constexpr double kTopOfWord = 65536.0 * 15.0 / 16.0, kWord = 65536.0;

// Mean of a channel over a while.
struct Mean {
  double begin_s = 0.0, end_s = 0.0, rate_deg_s = 0.0;
  bool turns = false;
};

bool Overlaps(const std::vector<BadStretch>& bad, std::size_t channel, double begin_s,
              double end_s) {
  return std::ranges::any_of(bad, [&](const BadStretch& one) {
    return one.channel[channel] && one.begin_s < end_s && one.end_s > begin_s;
  });
}

std::vector<Mean> MeansOf(const Recording& recording, std::size_t channel, double units_per_deg_s) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  std::vector<Mean> means;
  for (const Rest& rest : recording.columns.rests) {
    auto from_node = std::ranges::lower_bound(nodes, rest.begin.t_s, {},
                                              [](const Node& node) { return node.at.t_s; });
    for (auto node = from_node; node != nodes.end() && node->at.t_s <= rest.end.t_s; ++node) {
      const IntegralMark &from = from_node->at, &to = node->at;
      if (to.t_s - from.t_s < kMean_s) continue;
      const double rate = (to.z[channel] - from.z[channel]) / (to.t_s - from.t_s);
      if (!Overlaps(recording.columns.bad, channel, from.t_s, to.t_s))
        means.push_back({from.t_s, to.t_s, rate / units_per_deg_s});
      from_node = node;
    }
  }
  return means;
}

// Another mean within kWithin_s is as far from this one as a turn makes it.
bool ChangesAbout(const std::vector<Mean>& means, std::size_t k) {
  const auto differs = [&](std::size_t other) {
    return std::fabs(means[other].rate_deg_s - means[k].rate_deg_s) > kTurns_deg_s;
  };
  for (std::size_t i = k; i-- > 0 && means[k].begin_s - means[i].end_s < kWithin_s;)
    if (differs(i)) return true;
  for (std::size_t i = k + 1; i < means.size() && means[i].begin_s - means[k].end_s < kWithin_s;
       ++i)
    if (differs(i)) return true;
  return false;
}

struct Turns {
  int count = 0;
  double turning_s = 0.0;
  Mean first;
};

// Stretches in which the rate is not the usual one, and that begin or end as turns do.
Turns FindTurns(std::vector<Mean> means, double usual_deg_s) {
  for (Mean& mean : means) mean.turns = std::fabs(mean.rate_deg_s - usual_deg_s) > kTurns_deg_s;
  Turns found;
  for (std::size_t k = 0; k < means.size();) {
    std::size_t end = k;
    bool changes = false;
    while (end < means.size() && means[end].turns) changes = ChangesAbout(means, end++) || changes;
    if (changes) {
      Mean whole = means[k];
      whole.end_s = means[end - 1].end_s;
      if (found.count++ == 0) found.first = whole;
      found.turning_s += whole.end_s - whole.begin_s;
    }
    k = std::max(end, k + 1);
  }
  return found;
}

constexpr const char* kWhatToDo =
    "without a reference only a sensor at rest can be analysed: give the reference's angle "
    "(ref_angle_z_deg and the like), or cut the table to the times at rest";

std::string OffsetText(const Recording& recording, char axis, double usual_deg_s, double units) {
  const bool counts = recording.info.gyro_unit == RateUnit::kLsb;
  const double level = usual_deg_s * units + recording.info.gyro_lsb_zero.value_or(0.0);
  const std::string stands = fmt::format(
      "gyro {} stands at {:.4g} deg/s, far beyond any part's zero-rate offset ({:g} deg/s at "
      "most): ",
      axis, usual_deg_s, kLargestOffset_deg_s);
  if (counts && !recording.info.gyro_lsb_zero && level > kTopOfWord && level < kWord) {
    return fmt::format(
        "gyro {} stands at {:.0f} counts: most likely they are those of a signed 16-bit word that "
        "was written as an unsigned one, 65535 for -1. Take 65536 off every count above 32767",
        axis, level);
  }
  return stands +
         (counts ? "it turned, or the counts are of another sensitivity, or have a zero "
                   "that is not given (# gyro_lsb_zero = ...); "
                 : "it turned, or its values are of another unit than the column says; ") +
         kWhatToDo;
}

std::string TurnsOf(const Recording& recording, std::size_t channel) {
  const double nominal = NominalUnitsPerDegPerS(recording.info);
  const bool known = std::isfinite(nominal);
  const double units = known ? nominal : RoughUnitsPerDeg_s(recording.info);
  const std::vector<Mean> means = MeansOf(recording, channel, units);
  std::vector<double> rates;
  for (const Mean& mean : means) rates.push_back(mean.rate_deg_s);
  if (rates.empty()) return "";
  const double usual_deg_s = Median(Crowd(std::move(rates), 2.0 * kTurns_deg_s));
  const char axis = "xyz"[channel];
  const Turns turns = FindTurns(means, usual_deg_s);
  if (turns.turning_s >= kLeastTurning_s) {
    const std::string unit = known ? "deg/s" : "LSB";
    const double shown = known ? 1.0 : units;
    return fmt::format(
        "there is no reference, and gyro {} turns: {} time{} its rate leaves the {:.3g} {} at "
        "which it stands most, {:.0f} s in all, first from {:.1f} to {:.1f} s at {:.3g} {}; {}",
        axis, turns.count, turns.count == 1 ? "" : "s", usual_deg_s * shown, unit, turns.turning_s,
        turns.first.begin_s, turns.first.end_s, turns.first.rate_deg_s * shown, unit, kWhatToDo);
  }
  const double level = usual_deg_s * units + recording.info.gyro_lsb_zero.value_or(0.0);
  const bool top = !known && level > kTopOfWord && level < kWord;
  const bool beyond = known && std::fabs(usual_deg_s) > kLargestOffset_deg_s;
  if (!(beyond || top) || HasUnsignedGyro(recording)) return "";
  return OffsetText(recording, axis, usual_deg_s, units);
}

}  // namespace

std::string TurnsWithoutReference(const Recording& recording) {
  if (recording.info.reference != ReferenceKind::kNone) return "";
  for (std::size_t c = 0; c < 3; ++c) {
    if (!recording.info.gyro_present[c] || recording.valid_samples[c] < 2) continue;
    if (std::string says = TurnsOf(recording, c); !says.empty()) return says;
  }
  return "";
}

}  // namespace gyrobench::calibration
