#include "procedures/engine/dry_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "procedures/engine/bench.h"
#include "procedures/engine/motion_time.h"

namespace gyrobench::procedures {
namespace {

// Rounding of many added angles; a plan is exact otherwise.
constexpr double kRounding_deg = 1e-6;
constexpr std::size_t kMostNotes = 1000;

}  // namespace

DryBench::DryBench(std::vector<AxisFacts> axes, DryOptions options)
    : axes_(std::move(axes)), options_(std::move(options)) {}

double DryBench::TemperatureDegC() const {
  const double fan_degC = on_.contains("fan") ? -options_.fan_degC : 0.0;
  const double heater_degC = on_.contains("heater") ? options_.heater_degC : 0.0;
  return options_.room_degC + fan_degC + heater_degC -
         options_.cold_degC * std::exp(-plan_.expected_duration_s / options_.time_constant_s);
}

void DryBench::AddSegment(const std::string& kind, const std::string& name, double duration_s,
                          double expected_s) {
  const double end_s = plan_.duration_s + duration_s;
  if (end_s > options_.max_duration_s) {
    throw LimitError(fmt::format(
        "the run would take {:.10g} s or more, beyond the limit {:.10g} s: this {} of {:.10g} s "
        "begins at {:.10g} s",
        end_s, options_.max_duration_s, kind, duration_s, plan_.duration_s));
  }
  if (plan_.segments.size() >= options_.max_segments) {
    throw LimitError(fmt::format("the run would have more than {} segments (an endless loop?)",
                                 options_.max_segments));
  }
  plan_.segments.push_back({kind, name, plan_.duration_s, end_s});
  plan_.duration_s = end_s;
  plan_.expected_duration_s += expected_s;
}

double DryBench::AddMove(const TurnCommand& command, double begin_s) {
  CheckTurn(command, FindAxis(axes_, command.axis), kRounding_deg);
  const auto axis = std::find_if(axes_.begin(), axes_.end(), [&](const AxisFacts& facts) {
    return facts.name == command.axis;
  });
  const double duration_s =
      MoveDuration_s(command.angle_deg, command.rate_deg_s, command.acceleration_deg_s2);
  const double to_deg = axis->angle_deg + command.angle_deg;
  plan_.moves.push_back({command.axis, begin_s, duration_s, axis->angle_deg, to_deg,
                         command.rate_deg_s, command.acceleration_deg_s2});
  plan_.axes.insert(command.axis);
  axis->angle_deg = to_deg;
  return duration_s;
}

TurnOutcome DryBench::Turn(const TurnCommand& command) {
  const double duration_s = AddMove(command, plan_.duration_s);
  AddSegment("turn", fmt::format("{} {:+g} deg", command.axis, command.angle_deg), duration_s,
             duration_s);
  return {command.angle_deg, command.rate_deg_s, duration_s};
}

SwingOutcome DryBench::Swing(const SwingCommand& command) {
  double duration_s = 0.0;
  for (const TurnCommand& move : MovesOf(command))
    duration_s += AddMove(move, plan_.duration_s + duration_s);
  AddSegment("swing", Describe(command), duration_s, duration_s);
  return {command.frequency_hz, duration_s};
}

void DryBench::Rest(double duration_s) {
  CheckRest(duration_s);
  AddSegment("rest", fmt::format("{:g} s", duration_s), duration_s, duration_s);
}

SoakOutcome DryBench::Soak(const SoakCommand& command) {
  CheckSoak(command);
  const double expected_s = ExpectedSoak_s(command, plan_.expected_duration_s, options_.cold_degC,
                                           options_.time_constant_s);
  AddSegment("soak", fmt::format("{:g} degC in {:g} s", command.drift_degC, command.window_s),
             command.max_s, expected_s);
  return {true, expected_s, TemperatureDegC()};
}

std::string DryBench::Ask(const Question& question) {
  plan_.questions.push_back({question, plan_.expected_duration_s});
  for (const std::string& output : KnownOutputs()) {
    if (question.id == SwitchQuestion(output, true).id) on_.insert(output);
    if (question.id == SwitchQuestion(output, false).id) on_.erase(output);
  }
  if (const auto found = options_.answers.find(question.id); found != options_.answers.end()) {
    plan_.questions.back().configured_answer = found->second;
    return found->second;
  }
  return question.choices.empty() ? "" : question.choices.front();
}

void DryBench::SwitchOutput(const std::string& output, bool on) {
  if (on) {
    on_.insert(output);
  } else {
    on_.erase(output);
  }
}

void DryBench::Say(const std::string& text) {
  if (plan_.notes.size() < kMostNotes) plan_.notes.push_back(text);
}

Estimate DryBench::ReadEstimate(const std::string& what) {
  if (what == "bias") return {true, options_.nominal_bias_lsb, 0.0, "LSB"};
  return {true, options_.nominal_scale_deg_s_per_lsb, 0.0, "deg/s per LSB"};
}

std::vector<AxisVerdict> DryBench::Trace() {
  return {{"x", "none", "", {}}, {"y", "none", "", {}}, {"z", "none", "", {}}};
}

Choice DryBench::Choose(const std::vector<Rehearsal>& menu, double /*small_below*/) {
  Choice choice;
  if (choices_ == 0) {
    Say("which manoeuvre tells the most is known in the run alone: here each of the menu in turn "
        "stands for the one that is chosen");
  }
  for (std::size_t tried = 0; tried < menu.size() && !choice.best; ++tried) {
    const std::size_t next = choices_++ % menu.size();
    if (menu[next].affordable) choice.best = next;
  }
  for (const Rehearsal& rehearsal : menu) {
    for (const PlannedMove& move : rehearsal.moves) plan_.axes.insert(move.axis);
  }
  return choice;
}

WiringReport DryBench::FindWiring() {
  // Some two dozen small moves of each axis.
  constexpr double kOfOneAxis_s = 25.0;
  for (const AxisFacts& axis : axes_) {
    if (axis.min_deg > -kWiringRoom_deg || axis.max_deg < kWiringRoom_deg) {
      throw LimitError(
          fmt::format("axis.{}: its soft limits, {:g} .. {:g} deg, leave no {:g} deg both "
                      "ways, which it takes to find out how a stand is wired",
                      axis.name, axis.min_deg, axis.max_deg, kWiringRoom_deg));
    }
    plan_.axes.insert(axis.name);
  }
  const double duration_s = kOfOneAxis_s * static_cast<double>(axes_.size());
  AddSegment("commission", "small moves of each drive", duration_s, duration_s);
  Say(fmt::format("each axis turns by up to {:g} deg; what is found is known in the run alone",
                  kWiringRoom_deg));
  return {};
}

Plan DryRun(const Procedure& procedure, const Parameters& parameters, std::vector<AxisFacts> axes,
            const DryOptions& options, const RunHooks& hooks) {
  DryBench bench(std::move(axes), options);
  RunProcedure(procedure, parameters, bench, hooks);
  return bench.plan();
}

}  // namespace gyrobench::procedures
