#include "cli/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <iostream>
#include <optional>
#include <set>
#include <string_view>

#include "base/nearest_word.h"
#include "base/version.h"
#include "cli/exit_status.h"
#include "cli/terminal_text.h"
#include "config/bus_load.h"
#include "config/stand_config.h"
#include "export/exporter.h"

namespace gyrobench::cli {
namespace {

constexpr const char* kExample = "Example:\n  ";
constexpr std::int64_t kMostMessages = 1'000'000'000;

// Nothing where not the whole text is one.
template <typename Number>
std::optional<Number> ReadNumber(std::string_view text) {
  Number value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Of "1-31,40", in order and each once.
std::optional<std::vector<int>> UnitNumbers(const std::string& text) {
  std::set<int> units;
  for (const std::string& range : CLI::detail::split(text, ',')) {
    const std::size_t dash = std::min(range.find('-'), range.size());
    const auto first = ReadNumber<int>(std::string_view(range).substr(0, dash));
    const auto last =
        dash == range.size() ? first : ReadNumber<int>(std::string_view(range).substr(dash + 1));
    if (!first || !last || *first < config::kFirstUnit || *last < *first ||
        *last > config::kLastUnit)
      return std::nullopt;
    for (int unit = *first; unit <= *last; ++unit) units.insert(unit);
  }
  return std::vector<int>(units.begin(), units.end());
}

// CLI11 validators return what is wrong.
std::string CheckUnits(const std::string& text) {
  if (UnitNumbers(text)) return "";
  return fmt::format("expected unit numbers of {} to {}, as 1-31,40; found '{}'",
                     config::kFirstUnit, config::kLastUnit, text);
}

std::string CheckSeconds(const std::string& text) {
  const auto seconds = ReadNumber<double>(text);
  if (seconds && *seconds >= 0.1 && *seconds <= 3600.0) return "";
  return fmt::format("expected seconds, 0.1 to 3600, found '{}'; such as --every 2", text);
}

std::string CheckBaud(const std::string& text) {
  const std::vector<int>& bauds = config::SettableBauds();
  const auto baud = ReadNumber<int>(text);
  if (baud && std::ranges::find(bauds, *baud) != bauds.end()) return "";
  return fmt::format("{} is no baud rate that can be set here; such as 9600, 115200 or 500000",
                     text);
}

void AddCommon(CLI::App& app, Options& options) {
  app.add_flag("--json", options.json, "Print JSON for machines");
  app.add_option("--config", options.bench.config, "Stand file; default $GYROBENCH_CONFIG")
      ->type_name("FILE")
      ->group("Which bench");
  app.add_option("--socket", options.bench.socket,
                 "The daemon's control socket, instead of the stand file's")
      ->type_name("PATH")
      ->group("Which bench");
  app.add_option("--records", options.bench.records,
                 "Folder of the records, instead of the stand file's")
      ->type_name("DIR")
      ->group("Which bench");
  app.add_option("--lcm", options.bench.lcm_url,
                 "LCM URL of live data, instead of the stand file's")
      ->type_name("URL")
      ->group("Which bench");
  app.add_option("--prefix", options.bench.channel_prefix,
                 "Prefix of the LCM channels, instead of the stand file's")
      ->type_name("NAME")
      ->group("Which bench");
}

class CommandLine {
 public:
  CommandLine()
      : app_("Client of the calibration bench gyrobench, and its offline analysis.", "gyrobench") {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", std::string("gyrobench ") + kVersion);
    app_.footer(
        "Exit status: 0 done, 1 the command failed, 2 usage, 3 the part failed its limits.\n"
        "Example:\n  gyrobench --config config/virtual.toml run scale -p turns=20");
    AddCommon(app_, options_);
    AddBenchCommands();
    AddRunCommands();
    AddDevicesCommand();
    AddRecordCommands();
    AddTraceCommand();
    AddEffectsCommand();
    AddHoldCommand();
    AddApplyCommand();
    AddReportCommand();
  }

  std::variant<Options, int> Parse(int argc, const char* const* argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return Report(error);
    }
    const CLI::App* command = app_.get_subcommands().front();
    options_.command = command->get_name();
    for (const std::string& text : parameter_texts_) {
      const std::size_t equals = text.find('=');
      if (equals == std::string::npos || equals == 0) {
        std::cerr << "gyrobench " << options_.command << ": -p " << text
                  << ": expected key=value, such as -p turns=20\n";
        return static_cast<int>(kUsage);
      }
      options_.parameters.emplace_back(text.substr(0, equals), text.substr(equals + 1));
    }
    options_.units = UnitNumbers(units_text_).value_or(std::vector<int>{});
    return options_;
  }

 private:
  CLI::App& Add(const std::string& name, const std::string& help, const std::string& example) {
    CLI::App& command = *app_.add_subcommand(name, help);
    command.footer(kExample + example);
    AddCommon(command, options_);
    return command;
  }
  void AddMeasurements(CLI::App& command) {
    command.add_option("input", options_.inputs, "Runs, folders of records, or measurement tables")
        ->type_name("RUN-or-TABLE")
        ->required();
  }

  void AddParameters(CLI::App& command) {
    command.add_option("procedure", options_.name, "Name of the procedure")->required();
    command.add_option("-p,--parameter", parameter_texts_, "Value of a parameter of the procedure")
        ->type_name("key=value")
        ->allow_extra_args(false);
  }

  void AddBenchCommands() {
    Add("procedures", "List the procedures with their parameters", "gyrobench procedures");
    AddParameters(Add("check", "Run a procedure dry: what it would do, and whether it may",
                      "gyrobench check scale -p turns=20 -p rate_deg_s=9"));
    CLI::App& run =
        Add("run",
            "Run a procedure and follow it to its results; Ctrl-C ends the run in order, as "
            "abort does",
            "gyrobench run scale -p turns=20 -p rate_deg_s=9");
    AddParameters(run);
    run.add_flag("--detach", options_.detach, "Return as soon as the run has started");
    Add("bus", "How busy the stand's lines are, and how fast and how well each device answers",
        "gyrobench bus\n  gyrobench bus --every 2")
        .add_option("--every", options_.every_s, "Show it again and again, until Ctrl-C")
        ->type_name("SECONDS")
        ->check(CheckSeconds);
    Add("status", "What the bench is doing, and how its devices are", "gyrobench status");
    CLI::App& watch = Add("watch", "Print live state and results as they come over LCM",
                          "gyrobench watch --until-stop");
    watch.add_option("--count", options_.count, "End after so many messages")
        ->type_name("N")
        ->check(CLI::Range(std::int64_t{1}, kMostMessages));
    watch.add_flag("--until-stop", options_.until_stop, "End when a run stops");
    watch.add_flag("--data", options_.data, "Samples of gyro, angle and axes too");
  }

  void AddRunCommands() {
    Add("pause", "Pause the run at its next safe point", "gyrobench pause");
    CLI::App& resume = Add(
        "resume",
        "Go on with a paused run, or take up one whose daemon was killed or lost its power",
        "gyrobench resume\n  gyrobench resume latest\n  gyrobench resume 20260312-091500-scale");
    resume.add_option("run", options_.name,
                      "A run that was interrupted (latest: the last of them): it goes on from its "
                      "last command that was over, in a new record");
    resume.add_flag("--detach", options_.detach, "Return as soon as the run has started");
    Add("abort", "End the run in order: motion stops gently, the record is closed",
        "gyrobench abort");
    CLI::App& answer = Add("answer", "Answer the question that a procedure asks the operator",
                           "gyrobench answer done");
    answer.add_option("text", options_.answer, "The answer, or one of the choices")->required();
    Add("stop", "Stop all motion now, in every state", "gyrobench stop");
    Add("reset", "Clear a latched fault once its cause is gone", "gyrobench reset");
  }

  void AddRecordCommands() {
    Add("runs", "List the recorded runs", "gyrobench runs --records records");
    CLI::App& show = Add("show", "Show one recorded run and its results",
                         "gyrobench show 20260312-091500-scale");
    show.add_option("run", options_.name, "Run, or the folder of its record")->required();
    CLI::App& analyze = Add("analyze", "Scale, bias, their errors and the defects of recorded data",
                            "gyrobench analyze turntable.csv.gz");
    AddMeasurements(analyze);
    CLI::App& write =
        Add("export", "Write a run as a measurement table, or a calibration for firmware",
            "gyrobench export 20260312-091500-scale -o scale.csv.gz\n"
            "  gyrobench export --format c mpu-17.json -o mpu_17.h");
    write.add_option("input", options_.name, "Run, folder of its record, or calibration")
        ->type_name("RUN-or-CALIBRATION")
        ->required();
    std::string formats = "Of a calibration:";
    for (const exporting::Format& format : exporting::Formats())
      formats += fmt::format(" {} ({})", format.name, format.what);
    write.add_option("--format", options_.format, formats)->type_name("FORMAT");
    write.add_option("-o,--output", options_.output, "File to write; of a run .csv or .csv.gz")
        ->type_name("FILE")
        ->required();
    write.add_flag("--overwrite", options_.overwrite, "Replace the file if it exists");
  }

  void AddTraceCommand() {
    CLI::App& trace =
        Add("trace", "Trace what the baseline leaves to the effects behind it; runs of one sensor",
            "gyrobench trace warm-up.csv.gz turns.csv.gz --calibration mpu-17.json --report "
            "mpu-17.html");
    AddMeasurements(trace);
    trace.add_option("--calibration", options_.calibration, "Calibration to write")
        ->type_name("OUT.json");
    trace.add_option("--report", options_.report, "Report to write")->type_name("OUT.html");
    AddTracing(trace);
    trace.add_flag("-q,--quiet", options_.quiet,
                   "Print nothing but errors and what --json asks for");
  }

  void AddEffectsCommand() {
    CLI::App& effects =
        Add("effects",
            "The effects that a trace may name: what each looks like, its cause, what shows it",
            "gyrobench effects bias.hysteresis");
    effects.add_option("effect", options_.name, "One of them; all in a list without")
        ->type_name("ID");
    effects.add_flag("--markdown", options_.markdown, "As a page in Markdown");
  }

  void AddHoldCommand() {
    CLI::App& hold = Add("hold",
                         "Calibrate without a stand: poses held still with turns by hand between "
                         "them, gravity as the reference",
                         "gyrobench hold poses.csv.gz --calibration mpu-17.json");
    AddMeasurements(hold);
    hold.add_option("--calibration", options_.calibration, "Calibration to write, for `apply`")
        ->type_name("OUT.json");
    hold.add_flag("--g-sensitivity", options_.g_sensitivity,
                  "Keep the g-sensitivity in the model even where it is not seen");
    hold.add_flag("-q,--quiet", options_.quiet,
                  "Print nothing but errors and what --json asks for");
  }

  void AddDevicesCommand() {
    CLI::App& devices = Add(
        "devices",
        "Ask every unit number on the stand's Modbus lines what it is, by reading alone, while no "
        "daemon runs; exit status 1 where the stand file says otherwise",
        "gyrobench devices --bus a\n  gyrobench devices --bus a --units 1-31 --baud 9600,115200\n  "
        "gyrobench devices --write");
    devices.add_option("--bus", options_.buses, "Lines to ask, by their names; default all")
        ->type_name("NAME");
    devices
        .add_option("--units", units_text_,
                    "Unit numbers to ask, as 1-31,40; default " + units_text_)
        ->type_name("LIST")
        ->check(CheckUnits);
    devices
        .add_option(
            "--baud", options_.baud_rates,
            "Baud rates to ask all of them at. Default: the stand file's, and for its devices "
            "that do not answer there all usual rates and formats")
        ->type_name("LIST")
        ->delimiter(',')
        ->check(CheckBaud);
    CLI::Option* write = devices.add_flag(
        "--write", options_.write,
        "Set the pulses per turn of drives that differ from the stand file, and save them there; "
        "shows them and asks first. Nothing moves");
    devices.add_flag("--yes", options_.yes, "Write without the question")->needs(write);
    devices.add_flag("-q,--quiet", options_.quiet, "Show no bar");
  }

  void AddApplyCommand() {
    CLI::App& apply =
        Add("apply", "Correct a table's rates by a calibration, without any reference",
            "gyrobench apply mpu-17.json flight.csv.gz -o flight-corrected.csv.gz");
    apply.add_option("calibration", options_.calibration, "Calibration, as `trace` writes it")
        ->type_name("CALIBRATION")
        ->required();
    apply.add_option("table", options_.name, "Measurement table, run, or folder of a record")
        ->type_name("TABLE")
        ->required();
    apply.add_option("-o,--output", options_.output, "Table to write, .csv or .csv.gz")
        ->type_name("OUT.csv")
        ->required();
    apply.add_flag("--overwrite", options_.overwrite, "Replace the file if it exists");
    apply.add_flag("--any-sensor", options_.any_sensor,
                   "Also where the serial number is that of another sensor");
    apply.add_flag("-q,--quiet", options_.quiet, "Print nothing but errors and warnings");
  }

  void AddReportCommand() {
    CLI::App& report = Add("report", "Trace a run again and write its report",
                           "gyrobench report 20260312-091500-scale");
    report.add_option("run", options_.name, "Run, folder of its record, or measurement table")
        ->required();
    report
        .add_option("-o,--output", options_.output,
                    "File to write; default report.html in the record")
        ->type_name("FILE.html");
    AddTracing(report);
  }

  void AddTracing(CLI::App& command) {
    command
        .add_option("--seed", options_.seed, "Of what is drawn at random; the same gives the same")
        ->type_name("N")
        ->check(IsWholeNumber);
  }

  // CLI11 validators return what is wrong.
  static std::string IsWholeNumber(const std::string& text) {
    if (ReadNumber<std::uint64_t>(text)) return "";
    return fmt::format("expected a whole number from 0 on, found '{}'; such as --seed 7", text);
  }

  int Report(const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app_.exit(error, std::cout, std::cerr);
    const std::vector<std::string> rest = app_.remaining();
    if (app_.get_subcommands().empty() && !rest.empty()) {
      if (rest.front() == "help") return app_.exit(CLI::CallForHelp(), std::cout, std::cerr);
      std::vector<std::string> known;
      for (const CLI::App* command : app_.get_subcommands({})) known.push_back(command->get_name());
      PrintError("",
                 fmt::format("no command '{}': {}", rest.front(), Suggestion(rest.front(), known)));
      std::cerr << "Try: gyrobench --help\n";
      return kUsage;
    }
    const std::string command =
        app_.get_subcommands().empty() ? "" : app_.get_subcommands().front()->get_name();
    PrintError(command, error.what());
    std::cerr << HintOnMissing(error) << HintOnParameter() << "Try: gyrobench"
              << (command.empty() ? "" : " ") << command << " --help\n";
    return kUsage;
  }

  // How all of it is given, where something was left out.
  std::string HintOnMissing(const CLI::ParseError& error) const {
    const std::vector<CLI::App*> commands = app_.get_subcommands();
    if (commands.empty() || dynamic_cast<const CLI::RequiredError*>(&error) == nullptr) return "";
    const std::string example = commands.front()->get_footer();
    return "Such as: " + example.substr(std::string_view(kExample).size()) + "\n";
  }

  // `run scale turns=20` or `--turns=20`, as many a program takes it.
  std::string HintOnParameter() const {
    const std::vector<CLI::App*> commands = app_.get_subcommands();
    if (commands.empty() || commands.front()->get_option_no_throw("--parameter") == nullptr)
      return "";
    for (const std::string& word : app_.remaining(true)) {
      const std::size_t equals = word.find('='), name = word.find_first_not_of('-');
      if (equals == std::string::npos || name >= equals || equals + 1 == word.size()) continue;
      return fmt::format("A parameter follows -p: -p {}\n", word.substr(name));
    }
    return "";
  }

  CLI::App app_;
  Options options_;
  std::vector<std::string> parameter_texts_;
  std::string units_text_ = fmt::format("{}-{}", config::kFirstUnit, config::kLastUnit);
};

}  // namespace

std::variant<Options, int> ParseOptions(int argc, const char* const* argv) {
  return CommandLine().Parse(argc, argv);
}

}  // namespace gyrobench::cli
