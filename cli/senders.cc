#include "cli/senders.h"

#include <fmt/format.h>

#include "cli/bench_place.h"
#include "cli/control_client.h"
#include "cli/json_field.h"

namespace gyrobench::cli {
namespace {

constexpr std::chrono::seconds kAskAgain{1};
constexpr std::chrono::seconds kSilent{3};  // a daemon speaks once a second
constexpr double kAskTimeout_s = 1.0;
constexpr std::size_t kMostStrangers = 100;

}  // namespace

bool Senders::IsStranger(const Id& sender, Steady::time_point now) {
  if (own_ == sender) {
    own_heard_ = now;
    return false;
  }
  if (strangers_.contains(sender)) return true;
  const Whose whose = Judge(sender, now);
  if (whose != Whose::kDaemons) return whose == Whose::kStrangers;
  own_ = sender;
  own_heard_ = now;
  first_heard_.clear();
  return false;
}

Senders::Whose Senders::Judge(const Id& sender, Steady::time_point now) {
  if (strangers_.size() >= kMostStrangers) return Whose::kStrangers;
  const Id said = now >= next_ask_ ? ask_() : std::nullopt;
  if (!said) {
    if (now >= next_ask_) next_ask_ = now + kAskAgain;
    return JudgeByEar(sender, now);
  }
  own_ = said;
  own_heard_ = now;
  strangers_.erase(said);
  if (said == sender) return Whose::kDaemons;
  strangers_.insert(sender);
  return Whose::kStrangers;
}

Senders::Whose Senders::JudgeByEar(const Id& sender, Steady::time_point now) {
  if (!own_ || now - own_heard_ >= kSilent) return Whose::kDaemons;
  if (first_heard_.size() >= kMostStrangers) return Whose::kStrangers;
  const auto [first, is_new] = first_heard_.try_emplace(sender, now);
  return !is_new && own_heard_ > first->second ? Whose::kStrangers : Whose::kUndecided;
}

Senders::Id AskInstance(const ControlClient& client) {
  return recording::SenderNamed(Text(client.Get("/v1/status"), "instance"));
}

Senders::Ask InstanceAt(const BenchPlace& place) {
  if (!place.KnowsItsDaemon()) return [] { return Senders::Id(); };
  return [client = ControlClient(place.Socket(), place.DaemonCommand(), kAskTimeout_s)] {
    try {
      return AskInstance(client);
    } catch (const Error&) {
      return Senders::Id();
    }
  };
}

std::string StrangerNames::Tell(const std::string& stranger, const std::string& channel) {
  if (stranger.empty() || told_.size() >= kMostStrangers || !told_.insert(stranger).second)
    return {};
  return fmt::format(
      "another sender than this bench's daemon publishes here, first heard on {}: {}. What it says "
      "is not of this bench. Give it another url or channel_prefix ([lcm] of its stand file)",
      channel, stranger);
}

}  // namespace gyrobench::cli
