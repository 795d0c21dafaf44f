// A procedure on the physics of the virtual stand, without buses, drivers and messages: what the
// daemon's bench does, in a fraction of the time.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/plan/next_manoeuvre.h"
#include "calibration/trace/trace.h"
#include "procedures/engine/bench.h"
#include "tests/blind_trials/bench_recorder.h"

namespace gyrobench::blind_trials {

class TrialBench final : public procedures::Bench {
 public:
  // The arguments must outlive it.
  TrialBench(const config::StandConfig& stand, const config::Scenario& specimen,
             std::uint64_t noise_seed, const RecorderOptions& options);

  double ElapsedS() const override { return now_s_; }
  std::vector<procedures::AxisFacts> Axes() const override { return axes_; }
  StandGeometry Geometry() const override { return {}; }
  double TemperatureDegC() const override;
  std::vector<std::string> Outputs() const override { return {}; }
  void SwitchOutput(const std::string& /*output*/, bool /*on*/) override {}
  procedures::TurnOutcome Turn(const procedures::TurnCommand& command) override;
  procedures::SwingOutcome Swing(const procedures::SwingCommand& command) override;
  void Rest(double duration_s) override;
  procedures::SoakOutcome Soak(const procedures::SoakCommand& command) override;
  std::string Ask(const procedures::Question& question) override;
  procedures::Estimate ReadEstimate(const std::string& /*what*/) override { return {}; }
  std::vector<procedures::AxisVerdict> Trace() override;
  procedures::Choice Choose(const std::vector<procedures::Rehearsal>& menu,
                            double small_below) override;
  void RecordLimit(const procedures::LimitCheck& /*check*/) override {}
  void Say(const std::string& text) override { said_.push_back(text); }
  void Progress(double /*fraction*/) override {}
  void SafePoint() override {}

  // Of everything that was done; nothing new is measured for it.
  const calibration::Traced& Traced();
  const std::vector<std::string>& said() const { return said_; }

 private:
  void Pass(double duration_s, const char* kind);
  double Move(const procedures::TurnCommand& command);

  std::vector<procedures::AxisFacts> axes_;
  calibration::Collector collector_;
  BenchRecorder recorder_;
  std::optional<calibration::Traced> traced_;
  calibration::LoopMemory loop_;
  std::vector<std::string> said_;
  double now_s_ = 0.0;
};

}  // namespace gyrobench::blind_trials
