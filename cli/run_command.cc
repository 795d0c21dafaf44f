#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "base/json_text.h"
#include "cli/commands.h"
#include "cli/control_client.h"
#include "cli/exit_status.h"
#include "cli/follow_run.h"
#include "cli/json_field.h"
#include "cli/live_feed.h"
#include "cli/run_display.h"
#include "cli/senders.h"
#include "cli/stored_results.h"
#include "cli/terminal_text.h"
#include "presentation/number.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

int ExitStatusOf(const std::string& outcome) {
  if (outcome == "done") return kDone;
  return outcome == "failed_limits" ? kFailedLimits : kFailed;
}

std::string OutcomeText(const RunEnd& end) {
  std::string text = end.outcome;
  if (end.outcome == "failed_limits") text = "done, but the part failed its limits";
  if (end.outcome == "fault") text = "ended by a fault";
  if (end.outcome == "error") text = "ended by an error";
  return end.message.empty() ? text : text + ": " + end.message;
}

// A file of the record, null when there is none. The daemon's user may keep it from others:
// `why_not` then says so, and is left alone otherwise.
Json ReadOf(const std::string& record, const char* name, std::string& why_not) {
  std::error_code error;
  const auto file = std::filesystem::path(record) / name;
  if (!std::filesystem::exists(file, error)) {
    if (error) why_not = error.message();
    return nullptr;
  }
  try {
    return recording::ReadJson(file);
  } catch (const DataError& failure) {
    why_not = failure.what();
    return nullptr;
  }
}

// What the record has of the end of a run; null where it has not.
struct EndOfRecord {
  explicit EndOfRecord(const std::string& record)
      : result(ReadOf(record, recording::kResultJsonName, why_not)),
        trace(ReadOf(record, recording::kTraceJsonName, why_not)),
        wiring(Field(ReadOf(record, recording::kRunJsonName, why_not), recording::kWiringKey)) {}

  std::string why_not;  // it cannot be read
  Json result, trace, wiring;
};

void PrintEnd(const Json& started, const RunEnd& end, const EndOfRecord& of) {
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  const std::string text = fmt::format("run {}: {}", Text(started, "run_id"), OutcomeText(end));
  fmt::print("{}\n", end.outcome == "done" ? terminal.Bold(text) : terminal.Red(text));
  const StoredTrace verdicts = ReadTrace(of.trace);
  presentation::Document document = WiringDocument(of.wiring);
  if (!of.result.is_null())
    document = presentation::AnalysisDocument(
        presentation::WithTraceRemarks(ReadAnalysis(of.result), verdicts.result));
  Add(document, presentation::TraceSummary(verdicts.result, verdicts.not_known));
  if (!document.empty()) fmt::print("\n{}", RenderText(document, terminal));
  if (!of.why_not.empty()) fmt::print("results cannot be shown: {}\n", of.why_not);
  fmt::print("\nrecord: {}\n", Text(started, "record"));
}

void PrintStart(const Options& options, const Json& started) {
  if (options.json) return;
  fmt::print("run {}: {} of bench time\n", Text(started, "run_id"),
             presentation::FormatDuration(Number(started, "duration_s")));
  std::fflush(stdout);
}

std::unique_ptr<LiveFeed> JoinLiveFeed(const BenchPlace& place, Senders::Ask ask,
                                       const LiveFeed::Handler& handler) {
  try {
    return std::make_unique<LiveFeed>(place.LcmUrl(), place.ChannelPrefix(), std::move(ask),
                                      handler);
  } catch (const ConfigError&) {
    throw;
  } catch (const Error& error) {
    PrintError("run", fmt::format("{}. Following by the control socket, without live estimates.",
                                  error.what()));
    return nullptr;
  }
}

// What asks for a run.
struct RunStart {
  const char* path;
  Json body;
};

int RunDetached(const Options& options, const ControlClient& client, const RunStart& start) {
  const Json started = client.Post(start.path, start.body);
  if (options.json) {
    fmt::print("{}\n", JsonText(started, 2));
  } else {
    PrintStart(options, started);
    fmt::print("record: {}\n", Text(started, "record"));
  }
  return kDone;
}

// A daemon that is told to end answers until the record of its run is closed.
std::optional<RunEnd> EndInRecord(const std::string& record) {
  std::string why_not;
  const Json run = ReadOf(record, recording::kRunJsonName, why_not);
  const std::string outcome = Text(run, recording::kOutcomeKey);
  if (outcome.empty() || outcome == recording::kRunningOutcome) return std::nullopt;
  return RunEnd{outcome, Text(run, "message")};
}

RunEnd FollowToItsEnd(RunFollower& follower, RunDisplay& display, const Json& started,
                      LiveFeed* feed) {
  try {
    return follower.Follow(Text(started, "run_id"), feed);
  } catch (const UnreachableError&) {
    display.Clear();
    const std::optional<RunEnd> end = EndInRecord(Text(started, "record"));
    if (!end) throw;
    return *end;
  }
}

int StartAndFollow(const Options& options, const RunStart& start) {
  const BenchPlace place(options.bench);
  const ControlClient client(place.Socket(), place.DaemonCommand());
  if (options.detach) return RunDetached(options, client, start);

  InterruptWatch interrupts;
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  const auto display = MakeRunDisplay(terminal, options.json);
  const bool may_ask = terminal.is_terminal && isatty(STDIN_FILENO) == 1 && !options.json;
  RunFollower follower(client, interrupts, *display, may_ask);
  // Before the start, so that nothing of the run is missed; not at all when the daemon is not
  // there.
  const Senders::Id daemon = AskInstance(client);
  const auto feed = JoinLiveFeed(
      place, [daemon] { return daemon; },
      [&](const LiveMessage& message) { follower.OnLive(message); });
  const Json started = client.Post(start.path, start.body);
  PrintStart(options, started);

  const RunEnd end = FollowToItsEnd(follower, *display, started, feed.get());
  const EndOfRecord of(Text(started, "record"));
  if (options.json) {
    Json whole = started;
    whole.update({{"outcome", end.outcome},
                  {"message", end.message},
                  {"result", of.result},
                  {"trace", of.trace}});
    if (!of.wiring.is_null()) whole["wiring"] = of.wiring;
    fmt::print("{}\n", JsonText(whole, 2));
  } else {
    PrintEnd(started, end, of);
  }
  const Json& findings = Field(of.wiring, "findings");
  // As of devices: something is not as the stand file says.
  if (end.outcome == "done" && findings.is_array() && !findings.empty()) return kFailed;
  return ExitStatusOf(end.outcome);
}

}  // namespace

int Run(const Options& options) {
  return StartAndFollow(options, {"/v1/runs", RunRequest(options)});
}

int TakeUp(const Options& options) {
  return StartAndFollow(options, {"/v1/runs/resume", Json{{"run", options.name}}});
}

}  // namespace gyrobench::cli
