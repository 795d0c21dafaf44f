// A bench that moves nothing: checks every command against the limits and adds up the time.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "procedures/engine/bench.h"
#include "procedures/engine/engine.h"
#include "procedures/engine/procedure.h"
#include "procedures/engine/settling.h"

namespace gyrobench::procedures {

struct PlannedSegment {
  std::string kind;  // rest, turn, soak
  std::string name;
  double begin_s = 0.0;
  double end_s = 0.0;
};

// Put to the operator, unless the stand file answers in his place.
struct PlannedQuestion {
  Question question;
  double at_s = 0.0;  // since the start, with soaks as long as they are expected
  std::optional<std::string> configured_answer = {};
};

// What a run would do. Times count from its start; the operator's time is not in them.
struct Plan {
  double duration_s = 0.0;           // at worst: every soak takes its max_s
  double expected_duration_s = 0.0;  // with soaks as long as DryOptions expects them
  std::vector<PlannedSegment> segments;
  std::vector<PlannedMove> moves;
  std::set<std::string> axes;  // that move, or would by a choice that may be made
  std::vector<PlannedQuestion> questions;
  std::vector<std::string> notes;  // what the script says, the first 1000 of it
};

struct DryOptions {
  double max_duration_s = 86400.0;
  std::size_t max_segments = 100'000;
  // Answers by question id. Otherwise the first choice, or "" where there are none.
  std::map<std::string, std::string> answers = {};
  // Estimates are there from the first command on, exact (std_error 0): a loop that waits for a
  // small standard error is planned at its shortest.
  double nominal_scale_deg_s_per_lsb = 1.0 / 131.0;
  double nominal_bias_lsb = 0.0;
  // Temperature that soaks are expected to see: room_degC - cold_degC exp(-t / time_constant_s), t
  // the expected time since the start. It settles when its change within the window is below the
  // drift asked for.
  double room_degC = 25.0;
  double cold_degC = kExpectedCold_degC;
  double time_constant_s = kExpectedTimeConstant_s;
  // A fan makes the sensor colder by this, a heater warmer, whoever switches it.
  double fan_degC = 8.0;
  double heater_degC = 8.0;
  std::vector<std::string> outputs = {};  // that the stand switches by itself
  StandGeometry geometry = {};
};

// Soaks settle, after max_s. Not thread-safe.
class DryBench final : public Bench {
 public:
  explicit DryBench(std::vector<AxisFacts> axes, DryOptions options = {});

  const Plan& plan() const { return plan_; }

  double ElapsedS() const override { return plan_.duration_s; }
  std::vector<AxisFacts> Axes() const override { return axes_; }
  double TemperatureDegC() const override;
  std::vector<std::string> Outputs() const override { return options_.outputs; }
  void SwitchOutput(const std::string& output, bool on) override;
  StandGeometry Geometry() const override { return options_.geometry; }
  // These four throw LimitError: a limit of the axis, or a run that grows beyond the options'
  // budget.
  TurnOutcome Turn(const TurnCommand& command) override;
  SwingOutcome Swing(const SwingCommand& command) override;
  void Rest(double duration_s) override;
  SoakOutcome Soak(const SoakCommand& command) override;
  std::string Ask(const Question& question) override;
  Estimate ReadEstimate(const std::string& what) override;
  // Nothing beyond the baseline, on all axes: takes no time.
  std::vector<AxisVerdict> Trace() override;
  // One after the other, again and again: what a run takes at worst.
  Choice Choose(const std::vector<Rehearsal>& menu, double small_below) override;
  WiringReport FindWiring() override;
  std::string WriteStandFile() override { return "(a new stand file)"; }
  void RecordLimit(const LimitCheck& /*check*/) override {}
  void Say(const std::string& text) override;
  void Progress(double /*fraction*/) override {}
  void SafePoint() override {}

 private:
  // Checks a move and plans it, begun at `begin_s`. Returns its duration.
  double AddMove(const TurnCommand& command, double begin_s);
  void AddSegment(const std::string& kind, const std::string& name, double duration_s,
                  double expected_s);

  std::vector<AxisFacts> axes_;
  DryOptions options_;
  std::set<std::string> on_;  // outputs, by whomever they were switched
  Plan plan_;
  std::size_t choices_ = 0;
};

// Runs the procedure dry from the axes' present angles. Throws what RunProcedure throws: LimitError
// "scale.lua:41: axis.inner: 369 deg is beyond the soft limit 360 deg ..." where it would break a
// limit.
Plan DryRun(const Procedure& procedure, const Parameters& parameters, std::vector<AxisFacts> axes,
            const DryOptions& options = {}, const RunHooks& hooks = {});

}  // namespace gyrobench::procedures
