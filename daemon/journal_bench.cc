#include "daemon/journal_bench.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "base/json_text.h"
#include "base/measurement.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

double NumberOr(const json& value, double missing) {
  return value.is_number() ? value.get<double>() : missing;
}

}  // namespace

JournalBench::JournalBench(Context context, std::vector<FinishedCommand> journal)
    : context_(std::move(context)), journal_(std::move(journal)) {
  Do(kBeginCommand, [] { return json(); });
}

// Numbers are written so that they read back as the same.
void JournalBench::Finish(const std::string& command, json result) {
  json angles_deg = json::object();
  for (const procedures::AxisFacts& axis : context_.live.Axes()) {
    angles_deg[axis.name] = Number(axis.angle_deg);
  }
  state_ = {{"result", std::move(result)},
            {"angles_deg", std::move(angles_deg)},
            {"temperature_degC", Number(context_.live.TemperatureDegC())},
            {"elapsed_s", context_.live.ElapsedS()}};
  context_.record({command, state_});
}

void JournalBench::GoLive() {
  if (std::exchange(live_, true) || journal_.empty()) return;
  context_.take_up();
}

json JournalBench::Do(const std::string& command, const std::function<json()>& live) {
  if (next_ == journal_.size()) {
    GoLive();
    Finish(command, live());
  } else {
    const FinishedCommand& before = journal_[next_++];
    if (before.command != command) {
      throw Error(fmt::format(
          "the run cannot be taken up: its script asks for '{}' where it had asked for '{}'. It "
          "depends on something that is not the same every time; run it anew",
          command, before.command));
    }
    state_ = before.outcome;
  }
  return state_.at("result");
}

double JournalBench::ElapsedS() const { return state_.at("elapsed_s"); }

double JournalBench::TemperatureDegC() const {
  return NumberOr(state_.at("temperature_degC"), kMissing);
}

std::vector<procedures::AxisFacts> JournalBench::Axes() const {
  std::vector<procedures::AxisFacts> axes = context_.live.Axes();
  const json& angles_deg = state_.at("angles_deg");
  for (procedures::AxisFacts& axis : axes) {
    if (angles_deg.contains(axis.name)) axis.angle_deg = NumberOr(angles_deg[axis.name], kMissing);
  }
  return axes;
}

procedures::TurnOutcome JournalBench::Turn(const procedures::TurnCommand& command) {
  const json result =
      Do(fmt::format("turn {} {} deg at {} deg/s, {} deg/s2", command.axis, command.angle_deg,
                     command.rate_deg_s, command.acceleration_deg_s2),
         [&] {
           const procedures::TurnOutcome outcome = context_.live.Turn(command);
           return json{{"moved_deg", outcome.moved_deg},
                       {"rate_deg_s", outcome.rate_deg_s},
                       {"duration_s", outcome.duration_s}};
         });
  return {result.at("moved_deg"), result.at("rate_deg_s"), result.at("duration_s")};
}

procedures::SwingOutcome JournalBench::Swing(const procedures::SwingCommand& command) {
  const json result =
      Do(fmt::format("swing {} {} deg at {} Hz, {} times", command.axis, command.amplitude_deg,
                     command.frequency_hz, command.periods),
         [&] {
           const procedures::SwingOutcome outcome = context_.live.Swing(command);
           return json{{"frequency_hz", outcome.frequency_hz}, {"duration_s", outcome.duration_s}};
         });
  return {result.at("frequency_hz"), result.at("duration_s")};
}

void JournalBench::Rest(double duration_s) {
  Do(fmt::format("rest {} s", duration_s), [&] {
    context_.live.Rest(duration_s);
    return json();
  });
}

procedures::SoakOutcome JournalBench::Soak(const procedures::SoakCommand& command) {
  const json result = Do(fmt::format("soak {} degC in {} s, {} to {} s", command.drift_degC,
                                     command.window_s, command.min_s, command.max_s),
                         [&] {
                           const procedures::SoakOutcome outcome = context_.live.Soak(command);
                           return json{{"settled", outcome.settled},
                                       {"duration_s", outcome.duration_s},
                                       {"temperature_degC", Number(outcome.temperature_degC)}};
                         });
  return {result.at("settled"), result.at("duration_s"),
          NumberOr(result.at("temperature_degC"), kMissing)};
}

std::string JournalBench::Ask(const procedures::Question& question) {
  return Do("ask " + question.id, [&] { return json(context_.live.Ask(question)); });
}

procedures::Estimate JournalBench::ReadEstimate(const std::string& what) {
  const json result = Do("estimate " + what, [&] {
    const procedures::Estimate estimate = context_.live.ReadEstimate(what);
    return json{{"available", estimate.available},
                {"value", Number(estimate.value)},
                {"std_error", Number(estimate.std_error)},
                {"unit", estimate.unit}};
  });
  return {result.at("available"), NumberOr(result.at("value"), kMissing),
          NumberOr(result.at("std_error"), kMissing), result.at("unit")};
}

// What these lead to is not in the journal: where it holds one of them, nothing is taken up.
void JournalBench::SwitchOutput(const std::string& output, bool on) {
  Do(fmt::format("{} {} {}", kNotTakenUp, output, on ? "on" : "off"), [&] {
    context_.live.SwitchOutput(output, on);
    return json();
  });
}

std::vector<procedures::AxisVerdict> JournalBench::Trace() {
  std::vector<procedures::AxisVerdict> verdicts;
  Do(fmt::format("{} trace", kNotTakenUp), [&] {
    verdicts = context_.live.Trace();
    return json();
  });
  return verdicts;
}

procedures::Choice JournalBench::Choose(const std::vector<procedures::Rehearsal>& menu,
                                        double small_below) {
  procedures::Choice choice;
  Do(fmt::format("{} choose", kNotTakenUp), [&] {
    choice = context_.live.Choose(menu, small_below);
    return json();
  });
  return choice;
}

}  // namespace gyrobench::daemon
