// Whether a table that is turned to and fro follows, though each of its moves is too short to tell.
#pragma once

#include <optional>

#include "base/clock.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"

namespace gyrobench::daemon {

// A reference that shows the table as it was up to `age` ago shows, within [a, c + age], all places
// where the table was within [a, c], whatever its delay is. So its readings must span what the
// drive's places do:
//   span of the reference in [a, c + age] >= span of the drive in [a, c] - allowed - rate * gap
// with `rate` the fastest of the moves and `gap` the longest time between two readings, in which an
// end of the swing may pass unseen. [a, c] holds two moves; after c + age the next one is begun.
class SpanGuard {
 public:
  // Angles that do not belong together [deg].
  struct Excess {
    double reference_deg, drive_deg, allowed_deg;
  };

  // A move begins, from where the drive is.
  void Begin(const drivers::AxisState& drive, double rate_deg_s, Utime age);
  void Polled(const drivers::AxisState& drive);
  std::optional<Excess> Read(const drivers::AngleReading& reading, double allowed_deg);
  // What was seen before does not belong to what comes.
  void Forget() { span_.reset(); }

 private:
  struct Range {
    double min_deg, max_deg;
    void Add(double deg);
    double width_deg() const { return max_deg - min_deg; }
  };
  struct Span {
    Range drive;
    double rate_deg_s = 0.0;
    int moves = 0;
    Utime read = 0;  // the last reading, or a
    Utime gap = 0;
    std::optional<Range> reference;
    std::optional<Utime> ends;  // c + age, once c is there
  };
  std::optional<Span> span_;
};

}  // namespace gyrobench::daemon
