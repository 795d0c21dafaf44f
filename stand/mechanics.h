// Motor, shaft, worm and table of one axis.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "config/scenario.h"
#include "stand/motion.h"

namespace gyrobench::stand {

// What the axis is doing at a moment. Degrees of the table unless said.
struct AxisTruth {
  double table_deg = 0.0;    // true angle, right-handed
  double coupled_deg = 0.0;  // the same behind the play of the encoder's coupling
  double shaft_deg = 0.0;    // shaft angle over the gear ratio: no worm, no play
  double rate_deg_s = 0.0;   // of the motor over the gear ratio
};

// The chain, in degrees of the table, psi = shaft angle, which is the drive's count but for what
// jams and runs away:
//   x = psi / ratio + worm_1 sin(psi + p1) + worm_2 sin(2 psi + p2)
//   table = play(x) + lost steps + ripple(rate) sin(k psi)
// Within one segment the motor does not turn back, so the play is a function of where the segment
// began, and the truth of any moment of the recent past can be asked in any order.
class AxisMechanics {
 public:
  AxisMechanics(const config::MechanicsScenario& scenario, double encoder_play_deg,
                double gear_ratio, double pulses_per_turn);

  // Goes to command.target (whole pulses) from where the axis is at `t_s`.
  void Move(double t_s, const MoveCommand& command);
  // Brakes; `ramp_down_ms` per 1000 rpm. Ends what runs away.
  void Stop(double t_s, double ramp_down_ms);

  // The motor loses pulses now, or when it moves next.
  void Lose(double t_s, double pulses);
  // Of the drive's count the shaft does not make the share `part`, from 0 to 1 (all: it is jammed).
  void Drag(double begin_s, double end_s, double part);
  // The shaft turns by itself, unknown to the drive, until it is stopped.
  void RunAway(double begin_s, double end_s, double table_deg_s);

  AxisTruth At(double t_s) const;
  // True angle of the table alone.
  double TableAngle(double t_s) const;
  // Mean square of the vibration of the table [g^2].
  double Vibration(double t_s) const;
  // Nothing moves from `t_s` on, as far as is known now.
  bool RestsFrom(double t_s) const;
  // The drive's own count.
  double Pulses(double t_s) const { return Find(t_s).Position(t_s); }
  bool Moving(double t_s) const { return !Find(t_s).Rests(); }

 private:
  struct Slip {
    double begin_s = 0.0, end_s = 0.0;
    double pulses = 0.0;
  };
  struct Dragged {
    double begin_s = 0.0, end_s = 0.0;
    double part = 0.0;
    double begin_pulses = 0.0;
    std::optional<double> end_pulses = std::nullopt;  // once the past may be forgotten
  };
  struct Runaway {
    double begin_s = 0.0, end_s = 0.0;
    double pulses_s = 0.0;
  };

  const Segment& Find(double t_s) const;
  void Append(std::span<const Segment> plan);
  void AddSlip(double begin_s, double end_s, double pulses);
  double SlipPulses(double t_s) const;
  // Where the shaft is, in pulses.
  double ShaftPulses(double t_s) const;
  double WormAngle(double psi_rad) const;
  double Resonance(double rate_deg_s) const;
  double Rate(const Segment& segment, double t_s) const {
    return segment.Rate(t_s) * deg_per_pulse_;
  }

  config::MechanicsScenario scenario_;
  double half_play_deg_, half_encoder_play_deg_;
  double psi_per_pulse_;  // rad of shaft
  double deg_per_pulse_;  // of table
  double pulses_per_turn_;
  // The worm's error as s sin(psi) + c cos(psi) + ..., so that one sine and cosine give it all.
  double worm_1_sin_, worm_1_cos_, worm_2_sin_, worm_2_cos_;

  // The recent past and the plan, oldest first.
  static constexpr std::size_t kSegments = 48;
  std::array<Segment, kSegments> segments_;
  std::size_t count_ = 1;
  static constexpr std::size_t kSlips = 8;
  std::array<Slip, kSlips> slips_;
  std::size_t slip_count_ = 0;
  double slip_before_ = 0.0;
  double lost_next_ = 0.0;  // pulses, in the next motion
  std::vector<Dragged> dragged_;
  std::vector<Runaway> runaways_;
};

}  // namespace gyrobench::stand
