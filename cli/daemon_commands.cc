// Commands that are one request to the daemon.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/json_text.h"
#include "cli/commands.h"
#include "cli/control_client.h"
#include "cli/exit_status.h"
#include "cli/json_field.h"
#include "cli/terminal_text.h"
#include "presentation/number.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

ControlClient ClientOf(const Options& options) {
  const BenchPlace place(options.bench);
  return {place.Socket(), place.DaemonCommand()};
}

int PrintJson(const Json& json) {
  fmt::print("{}\n", JsonText(json, 2));
  return kDone;
}

// Empty where the bench's state lets a run begin. What a procedure does is checked in every state.
std::string WhyNotNow(const Json& status) {
  const std::string state = Text(status, "state");
  if (state.empty() || state == "idle") return "";
  std::string why;
  if (const Json& fault = Field(status, "fault"); fault.is_object()) {
    why = WithSource(Text(fault, "source"), Text(fault, "message")) +
          ". When its cause is gone: gyrobench reset";
  } else if (state == "disconnected") {
    for (const Json& device : Field(status, "devices")) {
      if (const Json& ok = Field(device, "ok"); ok.is_boolean() && !ok.get<bool>() && why.empty())
        why = WithSource(Text(device, "name"), Text(device, "message"));
    }
  } else {
    why = "run " + Text(Field(status, "run"), "run_id") + " is under way";
  }
  return fmt::format("the bench is {}{}{}", state == "fault" ? "in the state fault" : state,
                     why.empty() ? "" : ": ", why);
}

// A request whose answer is the new state.
int ChangeState(const Options& options, const std::string& target,
                const Json& body = Json::object()) {
  const Json answer = ClientOf(options).Post(target, body);
  if (options.json) return PrintJson(answer);
  const std::string state = Text(answer, "state");
  std::string_view more;
  if (state == "pausing") {
    more = ": the segment under way ends first";
  } else if (target == "/v1/pause" && state != "paused") {
    more = ": the pause is made as soon as there is a segment to end";
  }
  fmt::print("{}{}\n", state, more);
  return kDone;
}

// "ready | abort"; empty where any answer will do.
std::string ChoicesOf(const Json& object) {
  std::string text;
  for (const Json& choice : Field(object, "choices"))
    text += (text.empty() ? "" : " | ") + Plain(choice);
  return text;
}

std::string ChoicesText(const Json& question) {
  const std::string choices = ChoicesOf(question);
  return choices.empty() ? "" : " [" + choices + "]";
}

std::string RangeOf(const Json& parameter) {
  if (std::string choices = ChoicesOf(parameter); !choices.empty()) return choices;
  const double min = Number(parameter, "min"), max = Number(parameter, "max");
  if (std::isfinite(min) && std::isfinite(max)) {
    return fmt::format("{} .. {}", presentation::FormatNumber(min),
                       presentation::FormatNumber(max));
  }
  if (std::isfinite(min)) return "from " + presentation::FormatNumber(min);
  if (std::isfinite(max)) return "up to " + presentation::FormatNumber(max);
  return Text(parameter, "type");
}

std::string ProcedureText(const Json& procedure, const presentation::Terminal& terminal) {
  std::string text = presentation::WrappedParagraph(
      terminal.Bold(Text(procedure, "name")) + "  " + Text(procedure, "summary"), terminal, 0);
  const std::string problem = Text(procedure, "problem");
  if (!problem.empty()) {
    text += presentation::WrappedParagraph(terminal.Red("cannot be run: ") + problem, terminal, 2);
  }
  if (const Json& resumable = Field(procedure, "resumable");
      resumable.is_boolean() && resumable.get<bool>()) {
    text += presentation::WrappedParagraph(
        "After a kill or a loss of power it can be taken up: gyrobench resume latest", terminal, 2);
  }
  Rows rows;
  for (const Json& p : Field(procedure, "parameters")) {
    rows.push_back({Text(p, "name"),
                    presentation::WithUnit(Plain(Field(p, "default")), Text(p, "unit")), RangeOf(p),
                    Text(p, "help")});
  }
  return text + WrappedColumns(rows, 4, terminal, 2);
}

std::string RunText(const Json& run) {
  if (!run.is_object()) return "none since the daemon started";
  const std::string outcome = Text(run, "outcome");
  std::string text =
      fmt::format("{}, {}", Text(run, "run_id"), outcome.empty() ? Text(run, "state") : outcome);
  if (outcome.empty()) {
    text += fmt::format(": {:.0f} %", 100.0 * Number(run, "progress"));
    if (const std::string segment = Text(run, "segment"); !segment.empty()) text += ", " + segment;
    const double remaining = Number(run, "remaining_s");
    if (std::isfinite(remaining))
      text += ", " + presentation::FormatDuration(remaining) + " of bench time left";
  }
  const std::string message = Text(run, "message");
  return message.empty() ? text : text + ": " + message;
}

std::string LiveDataText(const Json& lcm) {
  if (!lcm.is_object()) return Plain(lcm);
  std::string message = Text(lcm, "message");
  if (!message.empty()) return message;
  return fmt::format("{}, channels {}_*", Text(lcm, "url"), Text(lcm, "channel_prefix"));
}

std::string BenchText(const Json& status) {
  std::string text;
  if (const std::string stand = Text(status, "stand"); !stand.empty()) text += ", stand " + stand;
  const Json& simulated = Field(status, "virtual_stand");
  if (simulated.is_boolean() && simulated.get<bool>()) text += " (virtual)";
  const Json& still = Field(status, "time_stands_still");
  if (still.is_boolean() && still.get<bool>()) text += ", bench time stands still";
  const double temperature = Number(status, "temperature_degC");
  if (std::isfinite(temperature)) text += fmt::format(", sensor {:.2f} degC", temperature);
  for (const auto& [output, on] : Field(status, "outputs").items()) {
    const bool known = on.is_boolean();
    text += fmt::format(", {} {}", output, !known ? "unknown" : on.get<bool>() ? "on" : "off");
  }
  return text;
}

// "outer 0.00 deg, middle unknown, inner 54.21 deg and moving": by the reference sensors.
std::string AxesText(const Json& axes) {
  std::string text;
  for (const Json& axis : axes) {
    const double angle_deg = Number(axis, "reference_deg");
    const Json& moving = Field(axis, "moving");
    text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", Text(axis, "name"),
                        std::isfinite(angle_deg) ? fmt::format("{:.2f} deg", angle_deg) : "unknown",
                        moving.is_boolean() && moving.get<bool>() ? " and moving" : "");
    for (const Json& input : Field(axis, "inputs"))
      text += fmt::format(" ({} input acts)", Plain(input));
  }
  return text;
}

std::string StatusText(const Json& status, const presentation::Terminal& terminal) {
  Rows rows;
  const std::string state = Text(status, "state");
  rows.push_back({"bench", (state == "fault" ? terminal.Red(state) : terminal.Bold(state)) +
                               BenchText(status)});
  const Json& fault = Field(status, "fault");
  if (fault.is_object()) {
    rows.push_back(
        {"fault", terminal.Red(WithSource(Text(fault, "source"), Text(fault, "message")))});
    for (const Json& left : Field(fault, "left")) {
      if (left.is_string()) rows.push_back({"", "left: " + left.get<std::string>()});
    }
    rows.push_back({"", "when its cause is gone: gyrobench reset"});
  }
  const Json& question = Field(status, "question");
  if (question.is_object()) {
    rows.push_back({"question", Text(question, "text") + ChoicesText(question)});
    rows.push_back({"", "answer with: gyrobench answer TEXT"});
  }
  if (const std::string axes = AxesText(Field(status, "axes")); !axes.empty()) {
    rows.push_back({"axes", axes});
  }
  for (const Json& notice : Field(status, "notices")) {
    const std::string text = Text(notice, "text");
    const bool said = Text(fault, "message").find(text) != std::string::npos;
    if (!said) rows.push_back({"notice", terminal.Red(text)});
  }
  rows.push_back({"run", RunText(Field(status, "run"))});
  const std::string record = Text(Field(status, "run"), "record");
  if (!record.empty()) rows.push_back({"record", record});
  if (const std::string live = LiveDataText(Field(status, "lcm")); !live.empty()) {
    rows.push_back({"live data", live});
  }
  if (const std::string version = Text(status, "version"); !version.empty()) {
    rows.push_back({"daemon", "gyrobenchd " + version});
  }
  return WrappedColumns(rows, 2, terminal);
}

std::string DevicesText(const Json& devices, const presentation::Terminal& terminal) {
  Rows rows;
  for (const Json& device : devices) {
    const Json& ok = Field(device, "ok");
    const bool well = ok.is_boolean() && ok.get<bool>();
    rows.push_back({Text(device, "name"), Text(device, "kind"),
                    fmt::format("{} unit {}", Text(device, "bus"), Plain(Field(device, "unit"))),
                    well ? "ok" : terminal.Red("NOT OK"), Text(device, "message")});
  }
  if (rows.empty()) return "";
  return "\n" + WrappedColumns(rows, 5, terminal);
}

std::string MoveText(const Json& move) {
  const double angle = Number(move, "angle_deg"), rate = Number(move, "rate_deg_s");
  return fmt::format("{} by {} deg at {} deg/s", Text(move, "axis"),
                     presentation::FormatNumber(angle), presentation::FormatNumber(rate));
}

// Equal moves that follow each other as one line.
std::string MovesText(const Json& moves) {
  Rows rows;
  for (std::size_t i = 0; i < moves.size();) {
    const std::string text = MoveText(moves[i]);
    std::size_t end = i + 1;
    while (end < moves.size() && MoveText(moves[end]) == text) ++end;
    rows.push_back({fmt::format("{} x", end - i), text});
    i = end;
  }
  constexpr std::size_t kShown = 20;
  const std::size_t more = rows.size() > kShown ? rows.size() - kShown : 0;
  rows.resize(rows.size() - more);
  if (more > 0) rows.push_back({"", fmt::format("... and {} more; all with --json", more)});
  return presentation::AlignColumns(rows, {presentation::Align::kRight, presentation::Align::kLeft},
                                    2);
}

// Minutes and seconds of the run: when somebody has to be there.
std::string QuestionsText(const Json& questions, const presentation::Terminal& terminal) {
  std::string all;
  for (const Json& question : questions) {
    const auto at_s = static_cast<long long>(std::round(Number(question, "at_s")));
    std::string text = fmt::format("asks at about {}:{:02} min:s: {}", at_s / 60, at_s % 60,
                                   Text(question, "text"));
    text += ChoicesText(question);
    if (const Json& answer = Field(question, "configured_answer"); answer.is_string())
      text += " (the stand file answers: " + answer.get<std::string>() + ")";
    all += presentation::WrappedParagraph(text, terminal, 0);
  }
  return all;
}

}  // namespace

int Procedures(const Options& options) {
  const Json answer = ClientOf(options).Get("/v1/procedures");
  if (options.json) return PrintJson(answer);
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  bool first = true;
  for (const Json& procedure : Field(answer, "procedures")) {
    fmt::print("{}{}", first ? "" : "\n", ProcedureText(procedure, terminal));
    first = false;
  }
  return kDone;
}

int Check(const Options& options) {
  const Json answer = ClientOf(options).Post("/v1/check", RunRequest(options));
  if (options.json) return PrintJson(answer);
  const Json& segments = Field(answer, "segments");
  const Json& moves = Field(answer, "moves");
  const std::string not_now = WhyNotNow(ClientOf(options).Get("/v1/status"));
  fmt::print(
      "{} may run: {} of bench time, {} segments, {} moves. Nothing has moved.\n", options.name,
      presentation::FormatDuration(Number(answer, "duration_s")),
      segments.is_array() ? segments.size() : static_cast<std::size_t>(Integer(answer, "segments")),
      moves.size());
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  fmt::print("{}{}", MovesText(moves), QuestionsText(Field(answer, "questions"), terminal));
  for (const Json& note : Field(answer, "notes")) {
    const std::string text = note.is_string() ? note.get<std::string>() : JsonText(note);
    fmt::print("{}", presentation::WrappedParagraph("note: " + text, terminal, 0));
  }
  if (!not_now.empty())
    fmt::print(
        "{}", presentation::WrappedParagraph("note: it cannot begin now, " + not_now, terminal, 0));
  return kDone;
}

int Status(const Options& options) {
  const Json answer = ClientOf(options).Get("/v1/status");
  if (options.json) return PrintJson(answer);
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  fmt::print("{}{}", StatusText(answer, terminal), DevicesText(Field(answer, "devices"), terminal));
  return kDone;
}

int Pause(const Options& options) { return ChangeState(options, "/v1/pause"); }
int Resume(const Options& options) {
  return options.name.empty() ? ChangeState(options, "/v1/resume") : TakeUp(options);
}
int Abort(const Options& options) { return ChangeState(options, "/v1/abort"); }
int Stop(const Options& options) { return ChangeState(options, "/v1/stop"); }
int Reset(const Options& options) {
  const int status = ChangeState(options, "/v1/reset");
  if (options.json) return status;
  const std::string not_now = WhyNotNow(ClientOf(options).Get("/v1/status"));
  if (not_now.empty()) return status;
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  fmt::print("{}", presentation::WrappedParagraph("a run cannot begin: " + not_now, terminal, 0));
  return status;
}
int Answer(const Options& options) {
  return ChangeState(options, "/v1/answer", {{"answer", options.answer}});
}

}  // namespace gyrobench::cli
