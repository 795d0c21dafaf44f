// Which of the senders on a channel is the daemon of this bench, and which are strangers: a second
// daemon, a log that is played back, any program of the network.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "recording/sender.h"

namespace gyrobench::cli {

class BenchPlace;
class ControlClient;

// A sender that is not known yet is looked up where the daemon can be asked: its control socket
// says its instance. Where it cannot, the daemon is who was heard of first.
// Another one is a stranger once that is heard beside it: until then it may be the same daemon,
// started anew. After 3 s of silence it is.
class Senders {
 public:
  using Id = std::optional<recording::Sender>;  // nothing: it names no instance
  using Steady = std::chrono::steady_clock;
  // Nothing where it cannot be asked now.
  using Ask = std::function<Id()>;

  explicit Senders(Ask ask) : ask_(std::move(ask)) {}
  bool IsStranger(const Id& sender, Steady::time_point now);

 private:
  enum class Whose { kDaemons, kStrangers, kUndecided };
  Whose Judge(const Id& sender, Steady::time_point now);
  Whose JudgeByEar(const Id& sender, Steady::time_point now);

  const Ask ask_;
  std::optional<Id> own_;
  Steady::time_point own_heard_{};
  Steady::time_point next_ask_{};                 // where it did not answer
  std::set<Id> strangers_;                        // by the daemon's own word
  std::map<Id, Steady::time_point> first_heard_;  // beside the daemon, where it cannot be asked
};

// The daemon's word for who it is; nothing where it is an older one. Throws as ControlClient does.
Senders::Id AskInstance(const ControlClient& client);
// The same of the daemon at `place`, where that says which it is; nothing where it does not answer.
Senders::Ask InstanceAt(const BenchPlace& place);

// Says each stranger once.
class StrangerNames {
 public:
  // Empty where nothing is new. `stranger` as in LiveMessage.
  std::string Tell(const std::string& stranger, const std::string& channel);

 private:
  std::set<std::string> told_;
};

}  // namespace gyrobench::cli
