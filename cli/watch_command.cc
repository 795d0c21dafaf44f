#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "base/json_text.h"
#include "base/measurement.h"
#include "cli/bench_place.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/interrupt_watch.h"
#include "cli/live_feed.h"
#include "cli/live_text.h"
#include "cli/terminal_text.h"

namespace gyrobench::cli {
namespace {

using Steady = std::chrono::steady_clock;

class Watcher {
 public:
  explicit Watcher(const Options& options)
      : options_(options), terminal_(presentation::DescribeTerminal(fileno(stdout))) {}

  bool done() const { return done_; }

  void OnLive(const LiveMessage& message) {
    if (done_) return;
    if (const std::string told = strangers_.Tell(message.stranger, message.channel);
        !told.empty()) {
      PrintError("watch", told);
    }
    const bool samples =
        message.channel == "GYRO" || message.channel == "ANGLE" || message.channel == "AXES";
    if (samples && !options_.data) {
      // Their loss is told all the same, and that a daemon began anew, which is said once.
      if (message.lost > 0 || (message.restarted && !options_.json)) Print(message);
      return;
    }
    if (!options_.json && message.lost == 0 && !message.restarted && !IsNews(message)) return;
    Print(message);
    ++printed_;
    const auto* run = std::get_if<run_t>(&message.body);
    if (options_.until_stop && message.stranger.empty() && run != nullptr &&
        run->event == run_t::STOP)
      done_ = true;
    if (options_.count > 0 && printed_ >= options_.count) done_ = true;
  }

 private:
  void Print(const LiveMessage& message) {
    const std::string line =
        options_.json ? JsonText(LiveJson(message)) : LiveLine(message, terminal_);
    std::fputs((line + "\n").c_str(), stdout);
  }

  // Whether the message says what was not said before. Events of the run are always news; how far
  // it is, and what the sensor measures, once a second at most: on a bench whose time runs fast
  // they would drown the results.
  bool IsNews(const LiveMessage& message) {
    const auto* run = std::get_if<run_t>(&message.body);
    if (run != nullptr && run->event != run_t::PROGRESS) return true;
    if (message.channel == "GYRO" || message.channel == "ANGLE" || message.channel == "AXES")
      return true;
    Said& said = said_[message.stranger + message.channel + NewsKey(message)];
    const std::string text = NewsText(message);
    const auto* status = std::get_if<status_t>(&message.body);
    const bool warmer = status != nullptr && HasMoved(*status, said);
    if (text == said.text && !warmer) return false;
    const Steady::time_point now = Steady::now();
    const bool often = run != nullptr || status != nullptr;
    const bool other_state = status != nullptr && status->state != said.state;
    if (often && !other_state && now - said.at < std::chrono::seconds(1)) return false;
    said = {text, now};
    if (status != nullptr) {
      said.state = static_cast<unsigned char>(status->state);
      said.temperature_degC = status->temperature_degC;
      said.gyro_rate_hz = status->gyro_rate_hz;
    }
    return true;
  }

  struct Said {
    std::string text;
    Steady::time_point at;
    // Of a status.
    int state = -1;
    double temperature_degC = kMissing, gyro_rate_hz = kMissing;
  };

  // Away from what was said last, so that a value between two roundings does not repeat itself.
  static bool HasMoved(const status_t& status, const Said& said) {
    const auto moved = [](double now, double before, double step) {
      return std::isfinite(now) != std::isfinite(before) || std::fabs(now - before) >= step;
    };
    return moved(status.temperature_degC, said.temperature_degC, 1.0) ||
           moved(status.gyro_rate_hz, said.gyro_rate_hz, 5.0);
  }

  const Options& options_;
  presentation::Terminal terminal_;
  std::int64_t printed_ = 0;
  bool done_ = false;
  StrangerNames strangers_;
  std::map<std::string, Said> said_;  // last, of each channel and what it speaks of
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
  LiveFeed feed(place.LcmUrl(), place.ChannelPrefix(), InstanceAt(place),
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
