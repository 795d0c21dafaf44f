// A bench that keeps a journal of what its commands gave, and gives it again where a run is taken
// up whose daemon had ended: the script comes to where it was without anything moving.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

// `outcome`: what the command gave as `result`, and what the script may know from then on:
// `angles_deg` by axis, `temperature_degC`, `elapsed_s`.
struct FinishedCommand {
  std::string command;  // "turn inner 9 deg at 20 deg/s, 400 deg/s2"
  nlohmann::json outcome;
};

// Angles, temperature and time are those at the end of the last command, so that a script that is
// run again on its journal asks for the same. Throws Error where it asks for something else.
class JournalBench final : public procedures::Bench {
 public:
  struct Context {
    procedures::Bench& live;
    std::function<void(const FinishedCommand&)> record;
    // Before the first command that the journal does not hold.
    std::function<void()> take_up;
  };
  // `journal`: as it was recorded; empty for a run that begins.
  JournalBench(Context context, std::vector<FinishedCommand> journal);

  double ElapsedS() const override;
  std::vector<procedures::AxisFacts> Axes() const override;
  StandGeometry Geometry() const override { return context_.live.Geometry(); }
  double TemperatureDegC() const override;
  std::vector<std::string> Outputs() const override { return context_.live.Outputs(); }
  void SwitchOutput(const std::string& output, bool on) override;
  procedures::TurnOutcome Turn(const procedures::TurnCommand& command) override;
  procedures::SwingOutcome Swing(const procedures::SwingCommand& command) override;
  void Rest(double duration_s) override;
  procedures::SoakOutcome Soak(const procedures::SoakCommand& command) override;
  std::string Ask(const procedures::Question& question) override;
  procedures::Estimate ReadEstimate(const std::string& what) override;
  std::vector<procedures::AxisVerdict> Trace() override;
  procedures::Choice Choose(const std::vector<procedures::Rehearsal>& menu,
                            double small_below) override;
  void RecordLimit(const procedures::LimitCheck& check) override {
    context_.live.RecordLimit(check);
  }
  void Say(const std::string& text) override { context_.live.Say(text); }
  void Progress(double fraction) override { context_.live.Progress(fraction); }
  void SafePoint() override { context_.live.SafePoint(); }

 private:
  nlohmann::json Do(const std::string& command, const std::function<nlohmann::json()>& live);
  void Finish(const std::string& command, nlohmann::json result);
  void GoLive();

  Context context_;
  const std::vector<FinishedCommand> journal_;
  std::size_t next_ = 0;
  bool live_ = false;
  nlohmann::json state_;  // the last outcome
};

// What a journal begins with, and what the commands begin with behind which no run is taken up.
inline constexpr const char* kBeginCommand = "begin";
inline constexpr const char* kNotTakenUp = "cannot be taken up:";

}  // namespace gyrobench::daemon
