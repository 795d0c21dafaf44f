#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>

#include "cli/bench_place.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/interrupt_watch.h"
#include "cli/live_feed.h"
#include "cli/live_text.h"

namespace gyrobench::cli {
namespace {

using Steady = std::chrono::steady_clock;

class Watcher {
 public:
  explicit Watcher(const Options& options)
      : options_(options), terminal_(DescribeTerminal(fileno(stdout))) {}

  bool done() const { return done_; }

  void OnLive(const LiveMessage& message) {
    if (done_) return;
    const bool samples =
        message.channel == "GYRO" || message.channel == "ANGLE" || message.channel == "AXES";
    if (samples && !options_.data) {
      // Their loss is told all the same.
      if (message.lost > 0) Print(message);
      return;
    }
    // On a bench whose time runs fast, these would drown the results.
    if (!options_.json && message.lost == 0 && IsRepetitive(message) && !IsDue(message)) return;
    Print(message);
    ++printed_;
    const auto* run = std::get_if<run_t>(&message.body);
    if (options_.until_stop && run != nullptr && run->event == run_t::STOP) done_ = true;
    if (options_.count > 0 && printed_ >= options_.count) done_ = true;
  }

 private:
  void Print(const LiveMessage& message) {
    const std::string line =
        options_.json ? LiveJson(message).dump() : LiveLine(message, terminal_);
    std::fputs((line + "\n").c_str(), stdout);
  }

  static bool IsRepetitive(const LiveMessage& message) {
    if (const auto* run = std::get_if<run_t>(&message.body)) return run->event == run_t::PROGRESS;
    return std::holds_alternative<status_t>(message.body);
  }

  // A status that says something new, or one second after the last.
  bool IsDue(const LiveMessage& message) {
    const Steady::time_point now = Steady::now();
    if (const auto* status = std::get_if<status_t>(&message.body)) {
      const std::string says = StateName(status->state) + status->message;
      if (says != status_) {
        status_ = says;
        last_[message.channel] = now;
        return true;
      }
    }
    const auto [last, first] = last_.try_emplace(message.channel, now);
    if (!first && now - last->second < std::chrono::seconds(1)) return false;
    last->second = now;
    return true;
  }

  const Options& options_;
  Terminal terminal_;
  std::int64_t printed_ = 0;
  bool done_ = false;
  std::string status_;
  std::map<std::string, Steady::time_point> last_;
};

// False when Ctrl-C came.
bool WaitForMessages(const LiveFeed& feed, InterruptWatch& interrupts) {
  std::array<pollfd, 2> waits = {
      {{feed.descriptor(), POLLIN, 0}, {interrupts.descriptor(), POLLIN, 0}}};
  if (poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) {
    throw Error(fmt::format("poll: {}", std::strerror(errno)));
  }
  return !(waits[1].revents != 0 && interrupts.Take());
}

}  // namespace

int Watch(const Options& options) {
  const BenchPlace place(options.bench);
  InterruptWatch interrupts;
  Watcher watcher(options);
  LiveFeed feed(place.LcmUrl(), place.ChannelPrefix(),
                [&](const LiveMessage& message) { watcher.OnLive(message); });
  fmt::print(stderr, "listening to {}_* on {}; Ctrl-C ends\n", place.ChannelPrefix(),
             place.LcmUrl());
  while (!watcher.done() && WaitForMessages(feed, interrupts)) {
    feed.Dispatch();
    std::fflush(stdout);
  }
  fmt::print(stderr, "{} message{} received, {} lost\n", feed.received(),
             feed.received() == 1 ? "" : "s", feed.lost());
  return kDone;
}

}  // namespace gyrobench::cli
