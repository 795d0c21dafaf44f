#include "cli/follow_run.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "base/measurement.h"
#include "cli/json_field.h"
#include "cli/live_feed.h"
#include "cli/live_text.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

constexpr std::chrono::milliseconds kPollInterval{500};
constexpr std::chrono::milliseconds kRedrawInterval{100};

std::string RunIdOf(const LiveMessage& message) {
  if (const auto* m = std::get_if<run_t>(&message.body)) return m->run_id;
  if (const auto* m = std::get_if<scale_result_t>(&message.body)) return m->run_id;
  if (const auto* m = std::get_if<bias_result_t>(&message.body)) return m->run_id;
  return "";
}

std::string NoteText(const std::string& text) {
  std::string lines =
      presentation::WrappedParagraph(text, presentation::DescribeTerminal(STDOUT_FILENO), 2);
  lines.pop_back();  // the end of the last line
  return lines;
}

}  // namespace

RunFollower::RunFollower(const ControlClient& client, InterruptWatch& interrupts,
                         RunDisplay& display, bool may_ask)
    : client_(client), interrupts_(interrupts), display_(display), may_ask_(may_ask) {
  view_.remaining_s = kMissing;
}

RunEnd RunFollower::Follow(const std::string& run_id, LiveFeed* feed) {
  run_id_ = run_id;
  Poll();
  while (!ended_) {
    if (!prompting_) display_.Show(view_);
    Wait(feed);
    if (Steady::now() >= next_poll_) Poll();
  }
  display_.Clear();
  return end_;
}

void RunFollower::Wait(LiveFeed* feed) {
  std::array<pollfd, 3> waits = {{{interrupts_.descriptor(), POLLIN, 0},
                                  {feed != nullptr ? feed->descriptor() : -1, POLLIN, 0},
                                  {prompting_ ? STDIN_FILENO : -1, POLLIN, 0}}};
  const int timeout_ms = static_cast<int>(kRedrawInterval.count());
  if (poll(waits.data(), waits.size(), timeout_ms) < 0 && errno != EINTR) {
    throw Error(fmt::format("poll: {}", std::strerror(errno)));
  }
  if (waits[0].revents != 0 && interrupts_.Take()) Interrupt();
  if (waits[1].revents != 0) feed->Dispatch();
  if (waits[2].revents != 0) ReadAnswer();
}

void RunFollower::OnLive(const LiveMessage& message) {
  if (const std::string told = strangers_.Tell(message.stranger, message.channel); !told.empty()) {
    display_.Line(NoteText(told));
  }
  if (!message.stranger.empty() || RunIdOf(message) != run_id_) return;
  if (const auto* scale = std::get_if<scale_result_t>(&message.body)) {
    view_.estimate = EstimateText(*scale);
  } else if (const auto* bias = std::get_if<bias_result_t>(&message.body)) {
    // While turns are measured the scale factor is what one waits for.
    if (view_.estimate.rfind("scale", 0) != 0) view_.estimate = EstimateText(*bias);
  } else if (const auto* run = std::get_if<run_t>(&message.body)) {
    if (run->event == run_t::SEGMENT_BEGIN) {
      view_.segment = SegmentText(*run);
      segment_is_live_ = true;
    }
    if (run->event == run_t::NOTE) display_.Line(NoteText(run->text));
    if (run->event == run_t::SUSPEND) {
      display_.Line(
          NoteText("suspended: " + run->text + (run->text.ends_with('.') ? "" : ".") +
                   " The run goes on when the device is back, and is a fault where it is not "
                   "within safety.resume_within_s; to end it now: gyrobench abort"));
    }
    if (run->event == run_t::STOP || run->event == run_t::QUESTION) next_poll_ = {};
  }
}

void RunFollower::Poll() {
  next_poll_ = Steady::now() + kPollInterval;
  try {
    TakeStatus(client_.Get("/v1/status"));
  } catch (const UnreachableError& error) {
    display_.Clear();
    throw UnreachableError(fmt::format(
        "lost the daemon while run {} was under way: {}. What was measured is in its record: "
        "gyrobench show {}",
        run_id_, error.what(), run_id_));
  }
}

void RunFollower::TakeStatus(const nlohmann::json& status) {
  view_.state = Text(status, "state");
  TakeRun(Field(status, "run"));
  if (!ended_) TakeQuestion(Field(status, "question"));
}

void RunFollower::TakeRun(const nlohmann::json& run) {
  if (Text(run, "run_id") != run_id_) {
    throw Error(fmt::format(
        "run {} has ended and another is under way; its end is in its record: gyrobench show {}",
        run_id_, run_id_));
  }
  if (!segment_is_live_) view_.segment = Text(run, "segment");
  view_.segments_done = Integer(run, "segments_done");
  const double progress = Number(run, "progress");
  if (std::isfinite(progress)) view_.progress = progress;
  view_.elapsed_s = Number(run, "elapsed_s");
  view_.remaining_s = Number(run, "remaining_s");
  UpdatePace();
  end_ = {Text(run, "outcome"), Text(run, "message")};
  ended_ = !end_.outcome.empty();
}

void RunFollower::UpdatePace() {
  const Steady::time_point now = Steady::now();
  // A question stops the bench, or lets it crawl: begin anew after it.
  if (pace_from_s_ < 0.0 || view_.state != "running") {
    pace_from_s_ = std::isfinite(view_.elapsed_s) ? view_.elapsed_s : -1.0;
    pace_since_ = now;
    return;
  }
  const double here_s = std::chrono::duration<double>(now - pace_since_).count();
  if (here_s > 0.9) view_.pace = (view_.elapsed_s - pace_from_s_) / here_s;
}

void RunFollower::TakeQuestion(const nlohmann::json& question) {
  const std::string key = question.is_object() ? Text(question, "id") + Text(question, "text") : "";
  if (key == asked_) return;
  if (prompting_) display_.Line("");
  asked_ = key;
  prompting_ = false;
  if (key.empty()) return;
  std::string choices;
  for (const nlohmann::json& choice : Field(question, "choices")) {
    choices += (choices.empty() ? "" : " | ") + Plain(choice);
  }
  display_.Line("? " + Text(question, "text"));
  if (!may_ask_) {
    display_.Line("  answer with: gyrobench answer " + (choices.empty() ? "TEXT" : choices));
    return;
  }
  display_.Clear();
  fmt::print("  {} > ", choices.empty() ? "answer" : "[" + choices + "]");
  std::fflush(stdout);
  prompting_ = true;
}

void RunFollower::ReadAnswer() {
  std::array<char, 512> buffer{};
  const ssize_t n = read(STDIN_FILENO, buffer.data(), buffer.size());
  if (n <= 0) {
    may_ask_ = prompting_ = false;
    display_.Line("\n  no more input here; answer with: gyrobench answer TEXT");
    return;
  }
  input_.append(buffer.data(), static_cast<std::size_t>(n));
  const std::size_t end = input_.find('\n');
  if (end == std::string::npos) return;
  const std::string answer = input_.substr(0, end);
  input_.erase(0, end + 1);
  prompting_ = false;
  try {
    client_.Post("/v1/answer", {{"answer", answer}});
  } catch (const RefusedError& error) {
    display_.Line(std::string("  ") + error.what());
    asked_.clear();
  }
  next_poll_ = {};
}

void RunFollower::Interrupt() {
  const bool first = interrupts_seen_++ == 0;
  display_.Line(first ? "\nCtrl-C: the run is aborted in order (once more: stop all motion now)"
                      : "\nCtrl-C: stop");
  try {
    client_.Post(first ? "/v1/abort" : "/v1/stop", nlohmann::json::object());
  } catch (const RefusedError& error) {
    display_.Line(std::string("  ") + error.what());
  }
  next_poll_ = {};
}

}  // namespace gyrobench::cli
