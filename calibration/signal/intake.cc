#include "calibration/signal/intake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/robust.h"
#include "calibration/signal/collector.h"
#include "calibration/signal/even_stamps.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/reference_track.h"
#include "calibration/signal/wrong_unit.h"

namespace gyrobench::calibration {
namespace {

// No sensor of silicon measures beyond these; a column that does is of another unit, or of
// something else. Empty where all is well.
std::string RemarkOnTemperature(const Columns& columns) {
  constexpr double kColdest_degC = -80.0, kHottest_degC = 175.0;
  // What a laboratory's temperatures are in kelvin.
  constexpr double kLeast_K = 200.0, kMost_K = 450.0;
  double low = kMissing, high = kMissing;
  for (const Node& node : columns.nodes) {
    low = std::fmin(low, node.temperature_degC);
    high = std::fmax(high, node.temperature_degC);
  }
  if (!(low < kColdest_degC) && !(high > kHottest_degC)) return "";
  return fmt::format(
      "the temperature goes from {:.1f} to {:.1f} degC, in which no sensor of silicon works{}: "
      "what "
      "is said of offset and temperature is not to be trusted",
      low, high,
      low > kLeast_K && high < kMost_K
          ? "; it reads as kelvin: subtract 273.15 from the column temp_degC"
          : "; does the column temp_degC hold another quantity?");
}

// Of the specific force, whose size is 1 g in the median of any measurement on a table or in a
// hand. Of two axes only what a larger unit makes of it is told. Empty where all is well.
std::string RemarkOnSpecificForce(const Recording& recording) {
  std::vector<double> sizes_g;
  for (const Node& node : recording.columns.nodes) {
    double square = 0.0;
    bool any = false;
    for (const double part : node.accel_g) {
      if (!std::isfinite(part)) continue;
      square += part * part;
      any = true;
    }
    if (any) sizes_g.push_back(std::sqrt(square));
  }
  const double size_g = Median(std::move(sizes_g));
  const std::array<bool, 3>& present = recording.info.accel_present;
  const bool whole = std::ranges::all_of(present, [](bool axis) { return axis; });
  const std::optional<std::string> unit = OtherUnitOfAccelerometer(size_g);
  if (!unit || (!whole && size_g < 1.0)) return "";
  return fmt::format(
      "the accelerometer shows {:.4g} g in the median, 1 g was expected of any sensor at rest. "
      "Most "
      "likely the unit: {}. What is said of gravity is not to be trusted",
      size_g, *unit);
}

// Fastest turn that the reference shows, of any axis [deg/s].
double FastestTurn_deg_s(const std::vector<Node>& nodes) {
  double fastest = 0.0;
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const double length_s = nodes[i].at.t_s - nodes[i - 1].at.t_s;
    for (std::size_t c = 0; c < 3 && length_s > 0.0; ++c) {
      const double turn_deg = nodes[i].rotation_deg[c] - nodes[i - 1].rotation_deg[c];
      fastest = std::fmax(fastest, std::fabs(turn_deg) / length_s);
    }
  }
  return fastest;
}

// Of stamps that are printed so coarsely that they do not tell an even clock. Empty where all is
// well, as where all steps are the same.
std::string RemarkOnStamps(const Recording& recording) {
  constexpr double kMatters_deg = 0.02, kFine = 0.01;
  const StampSteps& stamps = recording.stamps;
  const double digit_s = stamps.digit_s;
  const auto steps = static_cast<double>(recording.samples - 1 - stamps.gaps);
  if (!(digit_s > 0.0) || !(steps > 0.0)) return "";
  const double length_s = recording.last_time_s - recording.first_time_s - stamps.gaps_s;
  const double digits = length_s / steps / digit_s;
  const bool even = std::fabs(length_s - steps * digit_s * std::round(digits)) < 0.5 * digit_s;
  const double wrong_deg = digit_s * FastestTurn_deg_s(recording.columns.nodes);
  if (!(digits < kLeastDigitsOfInterval) || even || !(wrong_deg > kMatters_deg)) return "";
  return fmt::format(
      "the gyro's stamps are printed to {:.4g} s, and its samples come every {:.4g} s, unless some "
      "are missing: when each was taken is known to {:.4g} s alone, in which the fastest turn goes "
      "on by {:.2g} deg. Steps of the angle, ripples, resonances and errors of the scale factor "
      "that come from that are none of sensor or bench; print the stamps to {:.4g} s",
      digit_s, length_s / steps, digit_s, wrong_deg, kFine * digit_s);
}

// Of channels whose mean at rest is larger than any part's zero-rate offset. Empty where all is
// well, where nothing rests, where no sensitivity is known, and where the counts are known to be
// unsigned, which is said by itself.
std::string RemarkOnOffsets(const Recording& recording) {
  if (HasUnsignedGyro(recording)) return "";
  const double units_per_deg_s = NominalUnitsPerDegPerS(recording.info);
  std::string found;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> rates_deg_s;
    for (const Rest& rest : recording.columns.rests) {
      const double rate_deg_s =
          (rest.end.z[c] - rest.begin.z[c]) / (rest.end.t_s - rest.begin.t_s) / units_per_deg_s;
      if (!rest.turns && std::isfinite(rate_deg_s)) rates_deg_s.push_back(rate_deg_s);
    }
    const double offset_deg_s = Median(std::move(rates_deg_s));
    if (!(std::fabs(offset_deg_s) > kLargestOffset_deg_s)) continue;
    found +=
        fmt::format("{}gyro {} {:.0f} deg/s", found.empty() ? "" : ", ", "xyz"[c], offset_deg_s);
  }
  if (found.empty()) return "";
  return fmt::format(
      "at rest the output is {}, more than the zero-rate offset of a MEMS gyro is. Most likely "
      "it has the zero of a converter or of a voltage in it: {}",
      found,
      recording.info.gyro_unit == RateUnit::kLsb
          ? "give the count of zero above the header, such as \"# gyro_lsb_zero = 32768\""
          : "subtract that from the columns");
}

// Of samples that were put on the clock behind the packets in which they came. Empty where there
// are none.
std::string RemarkOnPackets(const Recording& recording) {
  if (recording.packed_samples == 0) return "";
  const std::string lost =
      recording.rows.lost == 0
          ? ""
          : fmt::format(" {} did not come, and the seconds about each such place are left out.",
                        recording.rows.lost);
  return fmt::format(
      "the gyro's samples come evenly and are stamped when a serial adapter or a computer got to "
      "them: {} stamps, off by {:.2g} ms (standard deviation), were put on an even clock of {:.4g} "
      "ms.{} They are late by a mean delay that nobody knows, and readings of the reference in "
      "rows of their own by another. Best let the unit stamp its samples, and log gyro and "
      "reference in one row",
      recording.packed_samples, 1e3 * recording.packed_scatter_s, 1e3 * recording.packed_interval_s,
      lost);
}

// Of readings that were put on the gyro's clock. Empty where they were not.
std::string RemarkOnDrift(const Recording& recording) {
  const DriftCorrection& drift = recording.drift_correction;
  if (drift.drift_ppm == 0.0) return "";
  return fmt::format(
      "the clocks of gyro and reference part by {:.0f} ppm: the reference's readings were put on "
      "the "
      "gyro's clock, from nothing at the begin to {:.2g} s at the end. That the clocks part is "
      "judged as an effect all the same, against the readings as they were stamped",
      drift.drift_ppm, drift.AtTime_s(recording.last_time_s));
}

std::string RemarkOnSilentAxis(const Defect& defect) {
  if (defect.count > 1)
    return fmt::format(
        "the stand's {} axis has no angle at the begin: what was measured before its first one is "
        "left out",
        defect.where);
  return fmt::format(
      "the stand's {0} axis is announced and has no angle: it is taken to stand at 0 deg, and the "
      "first seconds, in which it was waited for, are not used; in a table, fill the column "
      "ref_{0}_deg or remove it",
      defect.where);
}

}  // namespace

void DefectLog::Add(std::string_view kind, std::string_view where, double t_s, std::int64_t count) {
  for (Defect& defect : defects_) {
    if (defect.kind == kind && defect.where == where) {
      // Damaged files announce counts that no sum could hold.
      defect.count += std::min(count, std::numeric_limits<std::int64_t>::max() - defect.count);
      return;
    }
  }
  defects_.push_back(Defect{std::string(kind), count, t_s, std::string(where)});
}

bool HasUnsignedGyro(const Recording& recording) {
  return std::ranges::any_of(recording.defects, [](const Defect& defect) {
    return defect.kind == "unsigned_counts" && defect.where.starts_with("gyro");
  });
}

std::vector<std::string> IntakeRemarks(const Recording& recording) {
  std::vector<std::string> remarks;
  if (std::string remark = RemarkOnTemperature(recording.columns); !remark.empty())
    remarks.push_back(std::move(remark));
  if (std::string remark = RemarkOnSpecificForce(recording); !remark.empty())
    remarks.push_back(std::move(remark));
  if (std::string remark = RemarkOnOffsets(recording); !remark.empty())
    remarks.push_back(std::move(remark));
  if (std::string remark = RemarkOnStamps(recording); !remark.empty())
    remarks.push_back(std::move(remark));
  if (std::string remark = RemarkOnPackets(recording); !remark.empty())
    remarks.push_back(std::move(remark));
  if (std::string remark = RemarkOnDrift(recording); !remark.empty())
    remarks.push_back(std::move(remark));
  if (recording.info.reference != ReferenceKind::kNone && recording.reference_samples == 0) {
    remarks.emplace_back(
        "a reference is named, and has no value at any time: nothing tells what the sensor turned "
        "by; is its column filled, and its device read?");
  }
  for (const Defect& defect : recording.defects) {
    if (defect.kind == "reference_jump" && defect.where == kByWholeTurns) {
      remarks.push_back(fmt::format(
          "the reference jumps by whole turns ({} times, first at {:.1f} s), and what was measured "
          "across each jump is left out: its count of turns was lost, or its angle is wrapped and "
          "read too seldom to tell; let the column run on beyond 180 or 360 deg",
          defect.count, defect.first_t_s));
    }
    if (defect.kind == "reference_wrapped") {
      remarks.push_back(fmt::format(
          "the angle of the reference begins again after a turn ({} times, first at {:.1f} s): "
          "whole turns were added{}, so that it runs on",
          defect.count, defect.first_t_s,
          defect.where.empty() ? "" : fmt::format(", {}", defect.where)));
    }
    if (defect.kind == kSilentReference) remarks.push_back(RemarkOnSilentAxis(defect));
    if (defect.kind == kUnitRestarted) {
      remarks.push_back(fmt::format(
          "the gyro's unit started anew within the measurement ({} times, first at {:.1f} s), and "
          "its zero-rate offset may be another one since: what is said of the offset is of both "
          "parts together, and its error is too small where they differ. Measure again",
          defect.count, defect.first_t_s));
    }
    if (defect.kind != "unsigned_counts") continue;
    const bool accel = defect.where.starts_with("accel");
    remarks.push_back(fmt::format(
        "the counts of {} run through 32767 and 32768 and stay within 0 .. 65535: they are those "
        "of an unsigned converter, and its count of zero is contained in the {}; give it above the "
        "header, such as \"# {}_lsb_zero = 32768\"",
        defect.where, accel ? "specific force" : "zero-rate offset", accel ? "accel" : "gyro"));
  }
  return remarks;
}

void RefuseNoSamples(const std::string& source, std::int64_t samples,
                     const std::vector<Defect>& defects, const char* expected) {
  if (samples > 0) return;
  std::string wrong;
  if (!defects.empty()) {
    const Defect& first = defects.front();
    wrong =
        fmt::format("; found {} {}, the first at {}", first.count, first.kind,
                    first.where.empty() ? fmt::format("{:.3f} s", first.first_t_s) : first.where);
  }
  throw DataError(fmt::format("{}: no gyro sample; expected {}{}",
                              source.empty() ? "measurement" : source, expected, wrong));
}

void RefuseSamplesFarApart(const Recording& recording) {
  constexpr double kFarthest_s = 1.0;
  if (!(recording.median_interval_s > kFarthest_s)) return;
  const std::string& source = recording.info.source;
  throw DataError(fmt::format(
      "{}: expected samples of the gyro less than {:g} s apart, found {:g} s from one to the next: "
      "no angle can be summed up from them. t_s is in seconds; is it in milliseconds here? Then "
      "divide the column by 1000",
      source.empty() ? "measurement" : source, kFarthest_s, recording.median_interval_s));
}

std::string WithoutReference(const MeasurementInfo& info) {
  const auto all = [](const std::array<bool, 3>& axes) {
    return std::ranges::all_of(axes, [](bool present) { return present; });
  };
  if (all(info.gyro_present) && all(info.accel_present)) {
    return "poses held still with turns by hand between them are calibrated by gyrobench hold";
  }
  return "gyrobench hold calibrates without a reference, by poses held still, where the table has "
         "all three axes of gyro and accelerometer";
}

}  // namespace gyrobench::calibration
