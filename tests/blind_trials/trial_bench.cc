#include "tests/blind_trials/trial_bench.h"

#include <cmath>

#include "daemon/bench_facts.h"
#include "daemon/run_trace.h"
#include "procedures/engine/motion_time.h"
#include "stand/bench_physics.h"

namespace gyrobench::blind_trials {
namespace {

// A drive begins at a whole microsecond, and not before it has ended.
constexpr double kSlack_s = 2e-6;

}  // namespace

TrialBench::TrialBench(const config::StandConfig& stand, const config::Scenario& specimen,
                       std::uint64_t noise_seed, const RecorderOptions& options)
    : recorder_(stand, specimen, noise_seed, options, collector_) {
  for (const config::AxisConfig& axis : stand.axes) axes_.push_back(daemon::FactsOf(axis, 0.0));
  recorder_.RunTo(0.0);
}

void TrialBench::Pass(double duration_s, const char* kind) {
  traced_.reset();
  const double end_s = now_s_ + std::ceil(duration_s * 1e6) * 1e-6;
  recorder_.Add(SegmentMark{now_s_, end_s, kind, kind});
  recorder_.RunTo(end_s);
  now_s_ = end_s;
}

double TrialBench::TemperatureDegC() const {
  const calibration::Recording recording = collector_.Take();
  const auto& nodes = recording.columns.nodes;
  return nodes.empty() ? kMissing : nodes.back().temperature_degC;
}

double TrialBench::Move(const procedures::TurnCommand& command) {
  for (procedures::AxisFacts& axis : axes_) {
    if (axis.name != command.axis) continue;
    procedures::CheckTurn(command, axis, 1e-6);
    axis.angle_deg += command.angle_deg;
    recorder_.Add(gyrobench::blind_trials::Turn{now_s_, stand::AxisIndex(axis.name), axis.angle_deg,
                                                command.rate_deg_s, command.acceleration_deg_s2});
  }
  const double duration_s = procedures::MoveDuration_s(command.angle_deg, command.rate_deg_s,
                                                       command.acceleration_deg_s2);
  Pass(duration_s + kSlack_s, "turn");
  return duration_s;
}

procedures::TurnOutcome TrialBench::Turn(const procedures::TurnCommand& command) {
  return {command.angle_deg, command.rate_deg_s, Move(command)};
}

procedures::SwingOutcome TrialBench::Swing(const procedures::SwingCommand& command) {
  double duration_s = 0.0;
  for (const procedures::TurnCommand& move : procedures::MovesOf(command)) duration_s += Move(move);
  return {command.frequency_hz, duration_s};
}

void TrialBench::Rest(double duration_s) { Pass(duration_s, "rest"); }

procedures::SoakOutcome TrialBench::Soak(const procedures::SoakCommand& command) {
  Pass(command.max_s, "soak");
  return {true, command.max_s, TemperatureDegC()};
}

std::string TrialBench::Ask(const procedures::Question& question) {
  if (question.id == "fan_on") recorder_.SetFan(true);
  if (question.id == "fan_off") recorder_.SetFan(false);
  return question.choices.empty() ? "" : question.choices.front();
}

const calibration::Traced& TrialBench::Traced() {
  if (!traced_) {
    const calibration::Recording recording = collector_.Take();
    const calibration::Recording* one = &recording;
    calibration::TraceOptions options;
    options.curves = false;
    options.try_on_rest = false;
    traced_ = calibration::Trace(std::span(&one, 1), options);
  }
  return *traced_;
}

std::vector<procedures::AxisVerdict> TrialBench::Trace() {
  std::vector<procedures::AxisVerdict> verdicts;
  for (const calibration::ChannelTrace& channel : Traced().result.channels)
    verdicts.push_back(daemon::VerdictOf(channel));
  return verdicts;
}

procedures::Choice TrialBench::Choose(const std::vector<procedures::Rehearsal>& menu,
                                      double small_below) {
  return daemon::ChooseAmong(menu, small_below, collector_.Take(), Traced(), loop_);
}

}  // namespace gyrobench::blind_trials
