// From the columns kept of a measurement to the intervals that an estimate is made of.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "base/tick_fit.h"
#include "calibration/estimators/analyzer.h"
#include "calibration/gls/interval_gls.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// What the estimators work on.
struct Estimation {
  const MeasurementInfo& info;
  const AnalyzerOptions& options;
  const Columns& columns;
  const TickFit& ticks;
  bool orientation_known = false;
  std::array<bool, 3> usable = {};  // channels with valid samples
  // Standard deviation of one reading of the reference, as the rests show it; NaN without.
  double reading_error_deg = kMissing;
};

// One interval: increments of the integrals over it.
struct Row {
  double begin_s = 0.0, end_s = 0.0;
  bool still = false;
  std::size_t rest = 0;  // still: the rest it is part of; moving between rests: the rest before
  Vector3 z = {};
  Vector3 rotation_deg = {};  // 0 when still
  Vector3 earth_deg = {};
  double temperature_degC = kMissing;
  std::array<bool, 3> usable = {};

  double duration_s() const { return end_s - begin_s; }
};

// A rest without what belongs to the turns before and after it.
struct InnerRest {
  IntegralMark begin, end;
};

// Rests end where the gyro sees motion begin, to a sample. Of a ramp that begins softly its noise
// hides the first part, and of one that ends softly the last: the output over the turn lacks that
// rotation, the reference does not, and the scale factor is wrong by the same in each turn. So a
// turn is begun earlier and ended later, by 0.7 of the time in which its rate comes to half of its
// largest from where it was seen, 0.5 s and a quarter of the rest at most. A rate that grows as t^2
// (an even jerk) is hidden for no longer as long as noise hides less than an eighth of the largest
// rate; where the rate is there at once nothing is added. The measurement's own ends, and rests
// that no reference has shown, stay as they are. One entry for each of the rests.
std::vector<InnerRest> FindInnerRests(const Columns& columns);

// The rests, in pieces of about `piece_s` (never longer than 1.5 of it).
std::vector<Row> RestRows(const Columns& columns, double piece_s);
// The rests in pieces, and one moving row from each to the next: what the reference says in motion
// is not used, so that its latency does not matter.
std::vector<Row> StopRows(const Columns& columns, double piece_s);
// Node to node; stretches at rest are still, in pieces.
std::vector<Row> NodeRows(const Columns& columns, double piece_s);

// Of each row the integral of what an accelerometer at rest would show in the sensor's frame [g s].
// Empty where the reference does not say how the sensor lies.
std::vector<Vector3> GravityOver(const Columns& columns, const std::vector<Row>& rows);

// The intervals of one channel, unusable rows left out. `fill(row, columns)` writes the columns.
template <typename Fill>
IntervalSeries MakeSeries(const std::vector<Row>& rows, std::size_t channel, int columns,
                          Fill fill) {
  IntervalSeries series(columns);
  series.Reserve(rows.size());
  bool skipped_motion = true;
  const Row* last = nullptr;
  for (const Row& row : rows) {
    if (!row.usable[channel]) {
      skipped_motion = skipped_motion || !row.still;
      continue;
    }
    Interval interval;
    interval.duration_s = row.duration_s();
    interval.still = row.still;
    interval.gap_before_s = last != nullptr ? std::max(0.0, row.begin_s - last->end_s) : 0.0;
    interval.new_reference = skipped_motion;
    fill(row, series.Add(interval));
    last = &row;
    skipped_motion = false;
  }
  return series;
}

// What the kind of reference, and whether it moves, keeps from being estimated.
void RemarkOnReference(const Estimation& estimation, std::vector<std::string>* remarks);

// Mean over the rows' time, least and largest temperature of the rows that a channel uses. NaN
// without.
struct TemperatureRange {
  double mean = kMissing, min = kMissing, max = kMissing;
};
TemperatureRange Temperatures(const std::vector<Row>& rows, std::size_t channel);

}  // namespace gyrobench::calibration
