#include "stand/mechanics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/geometry.h"
#include "stand/motion.h"

namespace gyrobench::stand {
namespace {

// A motor that loses steps stalls for about so long.
constexpr double kStall_s = 0.05;
// A stepper that falls out of step catches again after whole electrical periods.
constexpr double kElectricalPeriodsPerTurn = 50.0;

}  // namespace

AxisMechanics::AxisMechanics(const config::MechanicsScenario& scenario, double encoder_play_deg,
                             double gear_ratio, double pulses_per_turn)
    : scenario_(scenario),
      half_play_deg_(0.5 * scenario.backlash_deg),
      half_encoder_play_deg_(0.5 * encoder_play_deg),
      psi_per_pulse_(2.0 * std::numbers::pi / pulses_per_turn),
      deg_per_pulse_(360.0 / pulses_per_turn / gear_ratio),
      pulses_per_turn_(pulses_per_turn),
      worm_1_sin_(scenario.worm_1_deg * std::cos(scenario.worm_1_phase_deg * kRadPerDeg)),
      worm_1_cos_(scenario.worm_1_deg * std::sin(scenario.worm_1_phase_deg * kRadPerDeg)),
      worm_2_sin_(scenario.worm_2_deg * std::cos(scenario.worm_2_phase_deg * kRadPerDeg)),
      worm_2_cos_(scenario.worm_2_deg * std::sin(scenario.worm_2_phase_deg * kRadPerDeg)) {
  // The table stands in the middle of its play.
  segments_[0].t0_s = -1e9;
  segments_[0].table0_deg = segments_[0].coupled0_deg = WormAngle(0.0);
}

const Segment& AxisMechanics::Find(double t_s) const {
  std::size_t i = count_ - 1;
  while (i > 0 && segments_[i].t0_s > t_s) --i;
  return segments_[i];
}

double AxisMechanics::WormAngle(double psi_rad) const {
  const double sine = std::sin(psi_rad);
  const double cosine = std::cos(psi_rad);
  return worm_1_sin_ * sine + worm_1_cos_ * cosine + worm_2_sin_ * 2.0 * sine * cosine +
         worm_2_cos_ * (1.0 - 2.0 * sine * sine);
}

// 1 at the resonance, 1/2 at its width.
double AxisMechanics::Resonance(double rate_deg_s) const {
  const double off =
      (std::abs(rate_deg_s) - scenario_.resonance_deg_s) / scenario_.resonance_width_deg_s;
  return 1.0 / (1.0 + off * off);
}

double AxisMechanics::SlipPulses(double t_s) const {
  double slip = slip_before_;
  for (std::size_t i = 0; i < slip_count_; ++i) {
    const Slip& s = slips_[i];
    slip += s.pulses * std::clamp((t_s - s.begin_s) / (s.end_s - s.begin_s), 0.0, 1.0);
  }
  return slip;
}

double AxisMechanics::ShaftPulses(double t_s) const {
  double pulses = Pulses(t_s);
  for (const Dragged& d : dragged_) {
    if (t_s <= d.begin_s) continue;
    const double gone = t_s < d.end_s ? Pulses(t_s) : d.end_pulses.value_or(Pulses(d.end_s));
    pulses -= d.part * (gone - d.begin_pulses);
  }
  for (const Runaway& r : runaways_) {
    pulses += r.pulses_s * std::max(0.0, std::min(t_s, r.end_s) - r.begin_s);
  }
  return pulses;
}

AxisTruth AxisMechanics::At(double t_s) const {
  const Segment& segment = Find(t_s);
  const double pulses = ShaftPulses(t_s);
  const double psi = pulses * psi_per_pulse_;
  const double rate = Rate(segment, t_s);
  const double x = pulses * deg_per_pulse_ + WormAngle(psi);
  const double table = Follow(segment.table0_deg, x, half_play_deg_);
  const double coupled = Follow(segment.coupled0_deg, table, half_encoder_play_deg_);
  const double slip = SlipPulses(t_s) * deg_per_pulse_;
  double ripple = scenario_.ripple_deg;
  if (scenario_.resonance_ripple_deg != 0.0) {
    ripple += scenario_.resonance_ripple_deg * Resonance(rate);
  }
  if (ripple != 0.0) ripple *= std::sin(scenario_.ripple_per_turn * psi);
  return {.table_deg = table + slip + ripple,
          .coupled_deg = coupled + slip + ripple,
          .shaft_deg = pulses * deg_per_pulse_ + slip,
          .rate_deg_s = rate};
}

double AxisMechanics::TableAngle(double t_s) const { return At(t_s).table_deg; }

double AxisMechanics::Vibration(double t_s) const {
  if (scenario_.resonance_vibration_g == 0.0) return 0.0;
  const Segment& segment = Find(t_s);
  if (segment.Rests()) return 0.0;
  const double peak = scenario_.resonance_vibration_g;
  return peak * peak * Resonance(Rate(segment, t_s));
}

bool AxisMechanics::RestsFrom(double t_s) const {
  const Segment& last = segments_[count_ - 1];
  if (!last.Rests() || last.t0_s > t_s) return false;
  const auto over = [t_s](const Runaway& r) { return r.end_s <= t_s; };
  if (!std::ranges::all_of(runaways_, over)) return false;
  return slip_count_ == 0 || slips_[slip_count_ - 1].end_s <= t_s;
}

void AxisMechanics::Append(std::span<const Segment> plan) {
  // The command replaces what was still to come.
  const double t_s = plan.front().t0_s;
  while (count_ > 1 && segments_[count_ - 1].t0_s >= t_s) --count_;
  for (Dragged& d : dragged_) {
    if (!d.end_pulses && d.end_s <= t_s) d.end_pulses = Pulses(d.end_s);
  }
  for (Segment segment : plan) {
    const Segment& before = segments_[count_ - 1];
    const double pulses = ShaftPulses(segment.t0_s);
    const double x = pulses * deg_per_pulse_ + WormAngle(pulses * psi_per_pulse_);
    segment.table0_deg = Follow(before.table0_deg, x, half_play_deg_);
    segment.coupled0_deg = Follow(before.coupled0_deg, segment.table0_deg, half_encoder_play_deg_);
    if (count_ == kSegments) {
      std::move(segments_.begin() + 1, segments_.end(), segments_.begin());
      --count_;
    }
    segments_[count_++] = segment;
  }
}

void AxisMechanics::Move(double t_s, const MoveCommand& command) {
  const Segment& now = Find(t_s);
  const Ramp ramp = RampOf(command, pulses_per_turn_, scenario_.clock_rel);
  const Plan plan = PlanMove(t_s, now.Position(t_s), now.Rate(t_s), command.target, ramp);
  Append(plan.segments());
  if (plan.segments().size() > 1 && lost_next_ != 0.0) Lose(t_s, std::exchange(lost_next_, 0.0));
  const double rpm_per_s = 1000.0 / (command.ramp_up_ms * 1e-3);
  if (plan.segments().size() > 1 && rpm_per_s > scenario_.pull_out_rpm_per_s) {
    const double periods = std::ceil(rpm_per_s / scenario_.pull_out_rpm_per_s - 1.0);
    const double sign = plan.segments().front().a > 0 ? -1.0 : 1.0;
    AddSlip(t_s, t_s + kStall_s, sign * periods * pulses_per_turn_ / kElectricalPeriodsPerTurn);
  }
}

void AxisMechanics::Stop(double t_s, double ramp_down_ms) {
  for (Runaway& r : runaways_) r.end_s = std::clamp(t_s, r.begin_s, r.end_s);
  const Segment& now = Find(t_s);
  if (now.Rests()) return;
  const Ramp ramp = RampOf({.rpm = 1.0, .ramp_up_ms = ramp_down_ms, .ramp_down_ms = ramp_down_ms},
                           pulses_per_turn_, scenario_.clock_rel);
  Append(PlanStop(t_s, now.Position(t_s), now.Rate(t_s), ramp.down).segments());
}

void AxisMechanics::Lose(double t_s, double pulses) {
  const auto is_motion = [t_s](const Segment& s) { return s.t0_s >= t_s && !s.Rests(); };
  const std::span<const Segment> known(segments_.data(), count_);
  const bool moves = Moving(t_s) || std::ranges::any_of(known, is_motion);
  if (!moves) {
    lost_next_ += pulses;
    return;
  }
  const double sign = known.back().x0 > Pulses(t_s) ? -1.0 : 1.0;
  AddSlip(t_s, t_s + kStall_s, sign * pulses);
}

void AxisMechanics::Drag(double begin_s, double end_s, double part) {
  dragged_.push_back({.begin_s = begin_s,
                      .end_s = end_s,
                      .part = std::clamp(part, 0.0, 1.0),
                      .begin_pulses = Pulses(begin_s)});
}

void AxisMechanics::RunAway(double begin_s, double end_s, double table_deg_s) {
  runaways_.push_back(
      {.begin_s = begin_s, .end_s = end_s, .pulses_s = table_deg_s / deg_per_pulse_});
}

void AxisMechanics::AddSlip(double begin_s, double end_s, double pulses) {
  if (slip_count_ == kSlips) {
    slip_before_ += slips_[0].pulses;
    std::move(slips_.begin() + 1, slips_.end(), slips_.begin());
    --slip_count_;
  }
  slips_[slip_count_++] = {.begin_s = begin_s, .end_s = end_s, .pulses = pulses};
}

}  // namespace gyrobench::stand
