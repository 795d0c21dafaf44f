// Follows a run to its end. The control socket says how it stands and when it has ended; LCM brings
// the estimates in between, and nothing but they is missing when a message is lost.
#pragma once

#include <string>

#include "cli/control_client.h"
#include "cli/interrupt_watch.h"
#include "cli/run_display.h"
#include "cli/senders.h"

namespace gyrobench::cli {

class LiveFeed;
struct LiveMessage;

struct RunEnd {
  std::string outcome;  // done, failed_limits, aborted, fault, error
  std::string message;
};

class RunFollower {
 public:
  // `may_ask`: someone sits at the terminal who can answer the procedure's questions.
  RunFollower(const ControlClient& client, InterruptWatch& interrupts, RunDisplay& display,
              bool may_ask);

  // Takes a message of the live feed; those of other runs are passed over, and those of strangers,
  // who are named once.
  void OnLive(const LiveMessage& message);
  // Returns when the run `run_id` has ended. `feed` may be null. Ctrl-C asks the daemon to abort in
  // order, a second one to stop. Throws UnreachableError when the daemon is gone.
  RunEnd Follow(const std::string& run_id, LiveFeed* feed);

 private:
  using Steady = std::chrono::steady_clock;

  void Wait(LiveFeed* feed);
  void Poll();
  void TakeStatus(const nlohmann::json& status);
  void TakeQuestion(const nlohmann::json& question);
  void TakeRun(const nlohmann::json& run);
  void Interrupt();
  void ReadAnswer();
  void UpdatePace();

  const ControlClient& client_;
  InterruptWatch& interrupts_;
  RunDisplay& display_;
  bool may_ask_;
  std::string run_id_;
  StrangerNames strangers_;
  RunView view_;
  bool segment_is_live_ = false;  // LCM says it sooner, and with its kind
  RunEnd end_;
  bool ended_ = false;
  int interrupts_seen_ = 0;
  std::string asked_;  // id and text of the question that stands on the terminal
  bool prompting_ = false;
  std::string input_;  // typed so far
  Steady::time_point next_poll_{};
  // Where the measurement of the pace began.
  Steady::time_point pace_since_{};
  double pace_from_s_ = -1.0;
};

}  // namespace gyrobench::cli
