#include "calibration/state/inputs_together.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "calibration/signal/fingerprints.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr double kSameRange = 1e-6;

std::string NameOf(const MeasurementInfo& info) {
  return info.source.empty() ? "measurement" : info.source;
}

// "a.csv:3" of a table whose head has the key, else "a.csv".
std::string PlaceOf(const MeasurementInfo& info, const std::string& key) {
  const auto line = info.key_lines.find(key);
  return line == info.key_lines.end() ? NameOf(info)
                                      : fmt::format("{}:{}", NameOf(info), line->second);
}

// Of the line with the names of the columns.
std::string HeaderOf(const MeasurementInfo& info) {
  return info.first_row_line > 1 ? fmt::format("{}:{}", NameOf(info), info.first_row_line - 1)
                                 : NameOf(info);
}

std::string FirstRowOf(const MeasurementInfo& info) {
  return info.first_row_line > 0 ? fmt::format("{}:{}", NameOf(info), info.first_row_line)
                                 : NameOf(info);
}

void CheckUnit(const MeasurementInfo& first, const MeasurementInfo& other) {
  constexpr const char* kUnits[] = {"_lsb", "_deg_s", "_rad_s"};
  if (first.gyro_unit == other.gyro_unit) return;
  throw DataError(fmt::format(
      "{}: expected columns of the gyro that end in {}, as in {}, found {}: measurements that are "
      "traced together have one unit; convert one of them, or trace them one by one",
      HeaderOf(other), kUnits[static_cast<std::size_t>(first.gyro_unit)], HeaderOf(first),
      kUnits[static_cast<std::size_t>(other.gyro_unit)]));
}

void CheckRange(const MeasurementInfo& first, const MeasurementInfo& other) {
  const double expected = NominalUnitsPerDegPerS(first), found = NominalUnitsPerDegPerS(other);
  if (!std::isfinite(expected) || !std::isfinite(found)) return;
  if (std::fabs(found / expected - 1.0) <= kSameRange) return;
  const std::string key = "gyro_lsb_per_deg_s";
  throw DataError(
      fmt::format("{}: expected {:.6g} units per deg/s, as in {}, found {:.6g}: record with one "
                  "range, or trace "
                  "them one by one",
                  PlaceOf(other, key), expected, PlaceOf(first, key), found));
}

// What one table takes off, the other has in its zero-rate offset.
void CheckZero(const Recording& with, const Recording& without) {
  const std::string key = "gyro_lsb_zero";
  const std::optional<double>&first = with.info.gyro_lsb_zero, &other = without.info.gyro_lsb_zero;
  if (first && other && *first != *other) {
    throw DataError(fmt::format(
        "{}: expected {} as count of zero, as in {}, found {}: a converter has one zero; give the "
        "same in all tables of one sensor, or trace them one by one",
        PlaceOf(without.info, key), *first, PlaceOf(with.info, key), *other));
  }
  if (!with.info.gyro_lsb_zero || without.info.gyro_lsb_zero || !HasUnsignedGyro(without)) return;
  throw DataError(fmt::format(
      "{}: expected the key gyro_lsb_zero, as in {} (= {}), found unsigned counts without it: give "
      "it in all tables of one sensor",
      HeaderOf(without.info), PlaceOf(with.info, "gyro_lsb_zero"), *with.info.gyro_lsb_zero));
}

// Mean output of the channel whose is largest [counts]; NaN where nothing was measured.
double Level(const Recording& recording) {
  double most = kMissing;
  const std::vector<Node>& nodes = recording.columns.nodes;
  const double length_s = nodes.empty() ? 0.0 : nodes.back().at.t_s - nodes.front().at.t_s;
  for (std::size_t c = 0; c < 3 && length_s > 0.0; ++c)
    most = std::fmax(most, std::fabs(nodes.back().at.z[c] - nodes.front().at.z[c]) / length_s);
  return most;
}

// Of tables without a count of zero: unsigned counts and signed ones are not of one converter. One
// that stays on a side of its zero does not show which it is, but for where it is.
void CheckSigns(const Recording& with_sign, const Recording& other) {
  constexpr double kElsewhere = 16384.0;  // counts
  if (with_sign.info.gyro_lsb_zero || other.info.gyro_lsb_zero || HasUnsignedGyro(with_sign))
    return;
  if (!HasUnsignedGyro(other) || !(Level(other) - Level(with_sign) > kElsewhere)) return;
  throw DataError(fmt::format(
      "{}: expected signed counts, as in {}, found those of an unsigned converter: give its count "
      "of zero above the header, such as \"# gyro_lsb_zero = 32768\", or trace them one by one",
      FirstRowOf(other.info), FirstRowOf(with_sign.info)));
}

// A record and the table that was exported from it are one measurement, and so are parts of it that
// overlap.
void CheckNotTwice(const Recording& one, const Recording& other) {
  constexpr std::size_t kLeast = 4;  // of some 128 samples each
  const std::vector<Node>&a = one.columns.nodes, &b = other.columns.nodes;
  const bool same = one.samples == other.samples && a.size() == b.size() && !a.empty() &&
                    a.back().at.z == b.back().at.z;
  const std::size_t shared = same ? 0 : SharedPassages(one.passages, other.passages);
  if (!same && shared < kLeast) return;
  const std::size_t all = std::min(one.passages.size(), other.passages.size());
  const std::string how_much =
      same || 2 * shared > all
          ? "the same measurement"
          : fmt::format("some {} samples of the same measurement", shared * Fingerprints::kOneOf);
  const auto [first, second] = std::minmax({FirstRowOf(one.info), FirstRowOf(other.info)});
  throw DataError(fmt::format("{} and {} hold {}: give each once, twice it would count double",
                              first, second, how_much));
}

}  // namespace

void CheckPowerOns(std::span<const InputSpan> inputs) {
  std::vector<InputSpan> order(inputs.begin(), inputs.end());
  std::sort(order.begin(), order.end(), [](const InputSpan& a, const InputSpan& b) {
    if (a.info->power_on != b.info->power_on) return a.info->power_on < b.info->power_on;
    if (a.first_time_s != b.first_time_s) return a.first_time_s < b.first_time_s;
    return a.info->source < b.info->source;
  });
  for (std::size_t k = 1; k < order.size(); ++k) {
    const InputSpan &before = order[k - 1], &after = order[k];
    const std::string& power_on = after.info->power_on;
    if (power_on.empty() || before.info->power_on != power_on) continue;
    if (after.first_time_s >= before.last_time_s) continue;
    throw DataError(fmt::format(
        "{}: power_on = {}: expected times after those of {}, which names the same power-on and "
        "ends at t_s = {:.9g}; found a first row at t_s = {:.9g} ({}). Times of one power-on count "
        "from it in all of its tables: give each power-on a name of its own, let t_s run "
        "on, or leave one out where both are one measurement",
        PlaceOf(*after.info, "power_on"), power_on, PlaceOf(*before.info, "power_on"),
        before.last_time_s, after.first_time_s, FirstRowOf(*after.info)));
  }
}

void CheckTogether(std::span<const Recording* const> recordings) {
  std::vector<InputSpan> inputs;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Recording &first = *recordings.front(), &one = *recordings[i];
    CheckUnit(first.info, one.info);
    CheckRange(first.info, one.info);
    for (std::size_t j = 0; j < i; ++j) {
      CheckNotTwice(*recordings[j], one);
      CheckZero(*recordings[j], one);
      CheckZero(one, *recordings[j]);
      CheckSigns(*recordings[j], one);
      CheckSigns(one, *recordings[j]);
    }
    inputs.push_back({&one.info, one.first_time_s, one.last_time_s});
  }
  CheckPowerOns(inputs);
}

namespace {

bool Before(const Recording& a, const Recording& b) {
  const auto key = [](const Recording& recording) {
    return std::tie(recording.info.power_on, recording.first_time_s, recording.last_time_s,
                    recording.info.source, recording.samples);
  };
  if (key(a) != key(b)) return key(a) < key(b);
  // Files of one name, one length: what they hold.
  const std::vector<Node>&x = a.columns.nodes, &y = b.columns.nodes;
  return std::lexicographical_compare(
      x.begin(), x.end(), y.begin(), y.end(),
      [](const Node& one, const Node& other) { return one.at.z < other.at.z; });
}

// Runs [begin, end) are of one power-on.
void PlaceRestarts(std::span<const Recording* const> recordings, std::size_t begin, std::size_t end,
                   std::vector<OrderedRun>* runs, std::vector<std::string>* remarks) {
  const auto run = [&](std::size_t k) -> const Recording& { return *recordings[(*runs)[k].index]; };
  for (std::size_t k = begin + 1; k < end; ++k) {
    if (run(k).first_time_s >= run(k - 1).last_time_s) continue;
    remarks->push_back(fmt::format(
        "{} and {} say power-on {} and overlap in time, so that their times do not count from it: "
        "each of its measurements is taken to begin with a power-on",
        run(k - 1).info.source, run(k).info.source, run(k).info.power_on));
    return;
  }
  for (std::size_t k = begin + 1; k < end; ++k) (*runs)[k].restart = false;
}

}  // namespace

std::vector<OrderedRun> OrderRuns(std::span<const Recording* const> recordings,
                                  std::vector<std::string>* remarks) {
  std::vector<OrderedRun> runs;
  for (std::size_t i = 0; i < recordings.size(); ++i) runs.push_back({i, true});
  std::sort(runs.begin(), runs.end(), [&](const OrderedRun& a, const OrderedRun& b) {
    return Before(*recordings[a.index], *recordings[b.index]);
  });
  const auto power_on = [&](std::size_t k) -> const std::string& {
    return recordings[runs[k].index]->info.power_on;
  };
  for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
    for (end = begin + 1; end < runs.size() && power_on(end) == power_on(begin);) ++end;
    if (!power_on(begin).empty()) PlaceRestarts(recordings, begin, end, &runs, remarks);
  }
  return runs;
}

}  // namespace gyrobench::calibration
