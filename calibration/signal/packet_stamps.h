// Stamps of samples that come in packets.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/measurement.h"
#include "calibration/signal/late_rows.h"
#include "calibration/signal/packet_watch.h"
#include "calibration/signal/stamp_line.h"
#include "calibration/signal/whole_line.h"

namespace gyrobench::calibration {

// A serial adapter hands over what it has every 16 ms or so: samples of an even clock are then
// stamped a few at once, each late by another part of that, and at 40 deg/s each angle is off by up
// to 0.6 deg, in a beat of the clock with the packets that passes for ripples of the angle. Where
// stamps come so (PacketWatch), or are known to come evenly, they are put on a straight line
// through them, by least squares of the last 100 s, or 20 s of a clock that drifts; or on that of
// the whole recording, where this is known. Such times are late by the mean delay. Else stamps that
// come one by one stay as they are, and so do the first ones. Constant memory; what it gives
// depends on the stamps so far alone.
class PacketStamps {
 public:
  // `even`: where it is known, what comes one by one is put on the line as well, from the begin on.
  explicit PacketStamps(const KnownClock& even = {}) : even_(even) {}
  // The time of a sample by its stamp [s], in order; those of one packet may have the same stamp.
  // `of_other_axes`: as PacketWatch::Take.
  double TimeOf(double stamp_s, bool of_other_axes = false);
  // Whether the last stamp was put on the line, or the next will be.
  bool mends() const { return watch_.in_packets() || std::isfinite(even_.interval_s); }
  // How many were put on the line; its interval, and the standard deviation of stamps about it [s],
  // as they were last.
  std::int64_t on_line() const { return on_line_; }
  double interval_s() const { return interval_s_; }
  double scatter_s() const { return scatter_s_; }
  // That of the line where there is one, else roughly; unknown at first, and where rows have axes
  // of their own.
  KnownClock Clock() const;
  // Samples that did not come, as the stamps of the others show; and where the last stamp showed
  // some, the time since which those given before it may be off. NaN else.
  std::int64_t lost() const { return lost_; }
  double wrong_since_s() const { return wrong_since_s_; }

 private:
  bool IsEarlyGap(double step_s) const;
  bool LossesShow() const;
  void Begin(double stamp_s);
  void Add(double stamp_s);
  void EndPacket();
  void Skip(double beyond_s);
  double RoughInterval_s() const;
  bool LineIsSure() const;
  double LineAt() const;

  PacketWatch watch_;
  KnownClock even_;
  bool on_ = false;
  bool held_ = false;  // on the line that is known for this stretch
  std::int64_t on_line_ = 0, lost_ = 0, stamps_ = 0, of_other_axes_ = 0;
  double wrong_since_s_ = kMissing;
  double interval_s_ = kMissing, scatter_s_ = kMissing;
  double last_stamp_s_ = kMissing, last_s_ = kMissing;
  // This stretch: stamps, the first of them, the number of the last one's interval, their lines.
  std::int64_t count_ = 0;
  double first_s_ = 0.0, place_ = 0.0;
  StampLine short_, long_;
  LongestLine whole_;
  double share_of_long_ = 1.0;  // goes over slowly: a change of lines is no step
  // By how much the last sample is behind the line; the least of the last sample of each packet in
  // a window, and what that usually is [s].
  double late_s_ = 0.0, least_late_s_ = 0.0, usual_least_s_ = 0.0;
  std::int64_t samples_ = 0, packets_ = 0, windows_ = 0, late_in_a_row_ = 0;
  double packet_begin_s_ = 0.0, packet_end_s_ = 0.0;  // stamps of this packet so far
  double window_s_ = 0.0, window_before_s_ = 0.0;     // when they began
};

}  // namespace gyrobench::calibration
