#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <variant>

#include "cli/commands.h"
#include "cli/control_client.h"
#include "cli/exit_status.h"
#include "cli/options.h"
#include "presentation/text_layout.h"

namespace {

using namespace gyrobench::cli;

struct Command {
  std::string_view name;
  int (*run)(const Options&);
};

constexpr std::array<Command, 20> kCommands = {{{"procedures", Procedures},
                                                {"check", Check},
                                                {"run", Run},
                                                {"status", Status},
                                                {"watch", Watch},
                                                {"pause", Pause},
                                                {"resume", Resume},
                                                {"abort", Abort},
                                                {"answer", Answer},
                                                {"stop", Stop},
                                                {"reset", Reset},
                                                {"runs", Runs},
                                                {"show", Show},
                                                {"analyze", Analyze},
                                                {"export", Export},
                                                {"trace", Trace},
                                                {"effects", Effects},
                                                {"hold", Hold},
                                                {"apply", Apply},
                                                {"report", Report}}};

int Dispatch(const Options& options) {
  for (const Command& command : kCommands) {
    if (command.name == options.command) return command.run(options);
  }
  throw UsageError(fmt::format("no command '{}'", options.command));
}

// The daemon knows procedures and their parameters; what it refuses of them is mistyped.
bool IsUsage(const RefusedError& error) {
  return error.code() == "no_such_procedure" || error.code() == "bad_parameter";
}

void PrintError(const std::string& command, const std::exception& error) {
  const gyrobench::presentation::Terminal terminal =
      gyrobench::presentation::DescribeTerminal(fileno(stderr));
  const std::string text = fmt::format("gyrobench{}: {}", command, error.what());
  fmt::print(
      stderr, "{}\n",
      terminal.is_terminal ? gyrobench::presentation::Wrap(text, terminal.columns, 2) : text);
}

}  // namespace

int main(int argc, char** argv) {
  std::string command;
  try {
    const auto parsed = ParseOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    const auto& options = std::get<Options>(parsed);
    command = " " + options.command;
    return Dispatch(options);
  } catch (const UsageError& error) {
    PrintError(command, error);
    return kUsage;
  } catch (const RefusedError& error) {
    PrintError(command, error);
    return IsUsage(error) ? kUsage : kFailed;
  } catch (const std::exception& error) {
    PrintError(command, error);
    return kFailed;
  }
}
