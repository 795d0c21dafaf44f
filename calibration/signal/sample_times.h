// When the values of a measurement are of, from the stamps of its rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/measurement.h"
#include "calibration/signal/clock_drift.h"
#include "calibration/signal/even_stamps.h"
#include "calibration/signal/late_rows.h"
#include "calibration/signal/packet_stamps.h"

namespace gyrobench::calibration {

// In the order of the rows. Rounded stamps, and those of samples that come in packets, are put on
// the line of the clock behind them (EvenStamps, PacketStamps).
class SampleTimes {
 public:
  // `even`: those whose stamps alone are known to be uneven (LateRows).
  explicit SampleTimes(const EvenRows& even = {});
  // `has_axis`: the axes of which the sample says something.
  double OfGyro(double stamp_s, const std::array<bool, 3>& has_axis);
  double OfCovariates(double stamp_s) { return covariates_.Mend(stamp_s); }
  // A reading of the row of the last sample has its time. Rounded stamps of two clocks are now and
  // then the same as well: in milliseconds every fifth, beside a gyro of 200 Hz. Axes may be read
  // one after the other: each has a clock of its own, and an orientation's counts as the first.
  // `angle_deg`: as LateRows::Take, NaN where there is no angle of an axis. The result is on the
  // gyro's clock.
  double OfReference(std::size_t axis, double stamp_s, double angle_deg);
  StampSteps GyroSteps() const { return gyro_.Steps(); }
  const PacketStamps& gyro_packets() const { return gyro_packets_; }
  // Where the last stamp showed that times given before it may be off: since when; NaN else.
  double wrong_since_s() const { return wrong_since_s_; }
  // By which the times of the reference's readings are later than their stamps say.
  const DriftCorrection& drift_correction() const { return drift_; }
  RowTiming Rows() const;
  // The unit restarted: its clocks begin anew.
  void BeginAnew(const EvenRows& even);

 private:
  struct Axis {
    EvenStamps clock;
    PacketStamps packets;
    std::int64_t readings = 0;
    double beside_samples = 0.0;  // share of the last readings that have a sample's stamp
    bool share_rows = false;
    double stamp_s = kMissing, s = kMissing;  // of the last reading, before and after
  };
  static void Count(bool beside_sample, Axis* axis);
  void BeginWith(double stamp_s);

  EvenStamps gyro_, covariates_;
  PacketStamps gyro_packets_;
  LateRows shared_rows_, own_rows_, by_stamps_{true};
  bool gyro_is_polled_ = false;
  DriftCorrection drift_;  // from the first stamp on
  bool began_ = false;
  std::array<Axis, 3> reference_;
  double wrong_since_s_ = kMissing;
  std::int64_t samples_ = 0;
  double gyro_stamp_s_ = kMissing, gyro_s_ = kMissing;  // of the last sample, before and after
  std::array<bool, 3> gyro_axes_ = {};                  // that it has
};

}  // namespace gyrobench::calibration
