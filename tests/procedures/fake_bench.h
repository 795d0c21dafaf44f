// A bench in memory that moves by small steps of time and can be told to fail.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "procedures/engine/bench.h"
#include "procedures/engine/procedure.h"

namespace gyrobench::procedures {

// Distinct numbers, so that a swap shows.
inline std::vector<AxisFacts> ThreeAxes() {
  return {{"outer", 40.0, 1.0, -720.0, 730.0, 50.0, 200.0},
          {"middle", 60.0, 2.0, -80.0, 90.0, 30.0, 100.0},
          {"inner", 40.0, 0.0, -360.0, 360.0, 40.0, 80.0}};
}

// As the hardware stand: all axes alike, with room for ten turns of the table.
inline std::vector<AxisFacts> Roomy(const std::vector<std::string>& names) {
  std::vector<AxisFacts> axes;
  for (const std::string& name : names) axes.push_back({name, 40, 0, -3600, 3600, 60, 200});
  return axes;
}

class FakeBench : public Bench {
 public:
  std::vector<Choice> choices;                  // answers of Choose, one after the other
  std::vector<std::vector<Rehearsal>> offered;  // what it was asked
  std::vector<double> small_limits;             // and below which share an effect is small
  // What was called, in order: "turn inner 9", "rest 2", "say hello".
  std::vector<std::string> calls;
  std::vector<TurnCommand> turns;
  std::vector<double> fractions;
  std::vector<SwingCommand> swings;
  std::vector<SoakCommand> soaks;
  std::vector<Question> questions;
  std::vector<LimitCheck> checks;
  std::vector<AxisFacts> axes = ThreeAxes();
  std::map<std::string, std::string> answers;
  std::map<std::string, Estimate> estimates;
  std::vector<AxisVerdict> verdicts;
  StandGeometry geometry;
  double temperature_degC = 21.5;
  // How far a question changes the temperature, by its id: a fan, a heater.
  std::map<std::string, double> warms_degC;
  std::vector<std::string> outputs;  // that it switches by itself; warms_degC as for a question
  bool settles = true;
  // Called at every safe point and before every turn: throw to fail.
  std::function<void()> on_safe_point = [] {};
  std::function<void()> on_turn = [] {};

  double ElapsedS() const override { return elapsed_s_; }
  std::vector<AxisFacts> Axes() const override { return axes; }
  StandGeometry Geometry() const override { return geometry; }
  double TemperatureDegC() const override { return temperature_degC; }

  std::vector<std::string> Outputs() const override { return outputs; }
  void SwitchOutput(const std::string& output, bool on) override {
    const std::string what = output + (on ? "_on" : "_off");
    calls.push_back("switch " + what);
    temperature_degC += warms_degC[what];
  }

  TurnOutcome Turn(const TurnCommand& command) override {
    const double duration_s = Move(command);
    calls.push_back("turn " + command.axis);
    return {command.angle_deg + 0.01, command.rate_deg_s + 0.5, duration_s};
  }

  // Over to the other side and back, as often as asked; rates as the largest of a sine's third
  // part.
  SwingOutcome Swing(const SwingCommand& command) override {
    swings.push_back(command);
    calls.push_back("swing " + command.axis);
    const double third_s = 1.0 / command.frequency_hz / 6.0;
    const double rate = command.amplitude_deg / third_s, begin_s = elapsed_s_;
    double from_deg = 0.0;
    for (int side = 0; side <= 2 * command.periods; ++side) {
      const bool home = side == 2 * command.periods;
      const double to_deg = home ? 0.0 : command.amplitude_deg * (side % 2 == 0 ? 1.0 : -1.0);
      Move({command.axis, to_deg - from_deg, rate, rate / third_s});
      from_deg = to_deg;
    }
    return {0.98 * command.frequency_hz, elapsed_s_ - begin_s};
  }

  void Rest(double duration_s) override {
    elapsed_s_ += duration_s;
    calls.push_back("rest");
  }

  SoakOutcome Soak(const SoakCommand& command) override {
    soaks.push_back(command);
    elapsed_s_ += command.max_s;
    calls.push_back("soak");
    return {settles, command.max_s, temperature_degC};
  }

  std::string Ask(const Question& question) override {
    questions.push_back(question);
    calls.push_back("ask " + question.id);
    temperature_degC += warms_degC[question.id];
    const auto found = answers.find(question.id);
    if (found != answers.end()) return found->second;
    return question.choices.empty() ? "" : question.choices.front();
  }

  Estimate ReadEstimate(const std::string& what) override { return estimates[what]; }
  Choice Choose(const std::vector<Rehearsal>& menu, double small_below) override {
    offered.push_back(menu);
    small_limits.push_back(small_below);
    if (choices.empty()) return {};
    Choice choice = choices.front();
    choices.erase(choices.begin());
    return choice;
  }
  std::vector<AxisVerdict> Trace() override {
    calls.push_back("trace");
    return verdicts;
  }
  void RecordLimit(const LimitCheck& check) override { checks.push_back(check); }
  void Say(const std::string& text) override { calls.push_back("say " + text); }
  void Progress(double fraction) override { fractions.push_back(fraction); }
  void SafePoint() override { on_safe_point(); }

  // The last thing said, without "say ".
  std::string LastSaid() const {
    const auto said = std::find_if(calls.rbegin(), calls.rend(),
                                   [](const auto& call) { return call.starts_with("say "); });
    return said == calls.rend() ? "" : said->substr(4);
  }

 private:
  double Move(const TurnCommand& command) {
    on_turn();
    turns.push_back(command);
    const double duration_s = SteppedDuration_s(command);
    elapsed_s_ += duration_s;
    for (AxisFacts& axis : axes) {
      if (axis.name == command.axis) axis.angle_deg += command.angle_deg;
    }
    return duration_s;
  }

  // By simulation: as fast as rate, acceleration and the braking distance allow.
  static double SteppedDuration_s(const TurnCommand& command) {
    constexpr double kStep_s = 1e-4;
    double left_deg = std::abs(command.angle_deg);
    double rate_deg_s = 0.0;
    double time_s = 0.0;
    const double acceleration = command.acceleration_deg_s2;
    while (left_deg > 1e-6) {
      rate_deg_s = std::min({rate_deg_s + acceleration * kStep_s, command.rate_deg_s,
                             std::sqrt(2.0 * acceleration * left_deg)});
      left_deg -= rate_deg_s * kStep_s;
      time_s += kStep_s;
    }
    return time_s;
  }

  double elapsed_s_ = 0.0;
};

// A procedure whose run(p) is `body`, which begins in line 2 of try.lua.
inline Procedure Script(const std::string& body) {
  return Procedure::FromSource(
      "try", "try.lua", "procedure = { summary = 'a test' } function run(p)\n" + body + "\nend");
}

// The message of the exception of type E that `action` throws; empty when it throws none.
template <class E>
std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const E& error) {
    return error.what();
  }
  return "";
}

}  // namespace gyrobench::procedures
