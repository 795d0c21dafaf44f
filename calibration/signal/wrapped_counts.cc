#include "calibration/signal/wrapped_counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

constexpr std::array<int, 2> kWords = {16, 32};
constexpr double kLeastJump = 15.0 / 16.0;  // of 2^n
constexpr std::int64_t kFewestJumps = 3;

}  // namespace

void WrappedCounts::Start(const MeasurementInfo& info) {
  *this = {};
  // Who gives the count of zero has an unsigned converter.
  watched_ = info.gyro_unit == RateUnit::kLsb && !info.gyro_lsb_zero;
}

void WrappedCounts::Add(double t_s, const std::array<double, 3>& counts) {
  // Most sensors have put out a count below zero soon, and nothing is left to be told.
  if (!watched_ || lowest_ < 0.0) return;
  for (std::size_t c = 0; c < 3; ++c) {
    Channel& channel = channels_[c];
    const double now = counts[c];
    if (!std::isfinite(now)) continue;
    lowest_ = std::min(lowest_, now);
    highest_ = std::max(highest_, now);
    for (std::size_t word = 0; word < kWords.size(); ++word) {
      if (!(std::fabs(now - channel.last) > kLeastJump * std::ldexp(1.0, kWords[word]))) continue;
      Jumps& jumps = channel.jumps[word];
      if (jumps.count++ == 0) jumps = {1, t_s, channel.last, now};
    }
    channel.last = now;
  }
}

std::optional<WrappedCounts::Finding> WrappedCounts::Found() const {
  if (!(lowest_ >= 0.0)) return std::nullopt;
  for (std::size_t word = 0; word < kWords.size(); ++word) {
    if (highest_ > std::ldexp(1.0, kWords[word]) - 1.0) continue;
    Finding found;
    for (std::size_t c = 0; c < 3; ++c) {
      const Jumps& jumps = channels_[c].jumps[word];
      if (jumps.count > found.jumps)
        found = {c, kWords[word], jumps.count, jumps.first_t_s, jumps.from, jumps.to};
    }
    if (found.jumps >= kFewestJumps) return found;
    break;  // jumps of a shorter word are none of a longer one
  }
  return std::nullopt;
}

Defect DefectOf(const WrappedCounts::Finding& finding) {
  return {kWrappedCounts, finding.jumps, finding.first_t_s,
          fmt::format("gyro {}: {:.0f} to {:.0f}, word of {} bits", "xyz"[finding.channel],
                      finding.from, finding.to, finding.bits)};
}

void RefuseWrappedCounts(const std::string& source, const std::vector<Defect>& defects) {
  const auto found = std::ranges::find(defects, kWrappedCounts, &Defect::kind);
  if (found == defects.end()) return;
  const bool wide = found->where.ends_with("32 bits");
  const char* const all = wide ? "4294967296" : "65536";
  throw DataError(fmt::format(
      "{}: the gyro's counts are those of a signed {}-bit word that was written as an unsigned "
      "one, {} for -1: {} time{} they jump from one end of 0 .. {} to the other between two "
      "samples, first at {:.3f} s ({}). Take {} off every count above {} of all its columns, as "
      "whoever reads signed words does",
      source.empty() ? "measurement" : source, wide ? 32 : 16, wide ? "4294967295" : "65535",
      found->count, found->count == 1 ? "" : "s", wide ? "4294967295" : "65535", found->first_t_s,
      found->where.substr(0, found->where.find(',')), all, wide ? "2147483647" : "32767"));
}

}  // namespace gyrobench::calibration
