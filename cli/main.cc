#include <fmt/format.h>

#include <array>
#include <exception>
#include <string>
#include <string_view>
#include <variant>

#include "cli/commands.h"
#include "cli/control_client.h"
#include "cli/exit_status.h"
#include "cli/options.h"
#include "cli/terminal_text.h"

namespace {

using namespace gyrobench::cli;

struct Command {
  std::string_view name;
  int (*run)(const Options&);
};

constexpr std::array<Command, 22> kCommands = {{{"procedures", Procedures},
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
                                                {"devices", Devices},
                                                {"bus", Bus},
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

}  // namespace

int main(int argc, char** argv) {
  std::string command;
  try {
    const auto parsed = ParseOptions(argc, argv);
    if (const int* status = std::get_if<int>(&parsed)) return *status;
    const auto& options = std::get<Options>(parsed);
    command = options.command;
    return Dispatch(options);
  } catch (const UsageError& error) {
    PrintError(command, error.what());
    return kUsage;
  } catch (const RefusedError& error) {
    PrintError(command, error.what());
    return IsUsage(error) ? kUsage : kFailed;
  } catch (const std::exception& error) {
    PrintError(command, error.what());
    return kFailed;
  }
}
