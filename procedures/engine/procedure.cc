#include "procedures/engine/procedure.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <lua.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "procedures/engine/commands.h"
#include "procedures/engine/sandbox.h"
#include "procedures/engine/table_reader.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {
namespace {

// The results that a run can be asked for.
const std::vector<std::string>& KnownMeasures() {
  static const std::vector<std::string> known = {"bias", "scale"};
  return known;
}

ParameterType ReadType(const TableReader& table) {
  constexpr ParameterType kTypes[] = {ParameterType::kNumber,  ParameterType::kInteger,
                                      ParameterType::kNumbers, ParameterType::kChoice,
                                      ParameterType::kText,    ParameterType::kBoolean};
  const std::string name = table.RequiredText("type");
  for (const ParameterType type : kTypes) {
    if (name == Name(type)) return type;
  }
  table.Refuse(
      fmt::format("type = \"{}\": expected \"number\", \"integer\", \"numbers\", \"choice\", "
                  "\"text\" or \"boolean\"",
                  name));
}

std::string ReadParameterName(const TableReader& table) {
  std::string name = table.RequiredText("name");
  const bool fits = !name.empty() && name.size() <= 60 &&
                    std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
                    std::all_of(name.begin(), name.end(), [](unsigned char c) {
                      return c < 0x80 && (std::isalnum(c) != 0 || c == '_');
                    });
  if (!fits) table.Refuse(fmt::format("name = \"{}\": expected letters, digits and _", name));
  return name;
}

Value ReadValue(lua_State* state, int index, const std::string& what) {
  switch (lua_type(state, index)) {
    case LUA_TNUMBER:
      return lua_tonumber(state, index);
    case LUA_TBOOLEAN:
      return lua_toboolean(state, index) != 0;
    case LUA_TNIL:
      throw Error(what + " is missing: every parameter has a default");
    default:
      return ReadText(state, index, what);
  }
}

void CheckRange(const TableReader& table, const Parameter& parameter) {
  const bool number = parameter.type == ParameterType::kNumber ||
                      parameter.type == ParameterType::kInteger ||
                      parameter.type == ParameterType::kNumbers;
  if (!number && (table.Has("min") || table.Has("max"))) {
    table.Refuse(fmt::format("min and max belong to a number, integer or numbers, not to a {}",
                             Name(parameter.type)));
  }
  if (parameter.min > parameter.max) {
    table.Refuse(fmt::format("min = {:.10g} is above max = {:.10g}", parameter.min, parameter.max));
  }
  if ((parameter.type == ParameterType::kChoice) == parameter.choices.empty()) {
    table.Refuse("choices belong to a parameter of type \"choice\", which needs at least one");
  }
}

// Reads the parameter table on top of the stack.
Parameter ReadParameter(lua_State* state, const std::string& what) {
  const TableReader table(state, -1, what,
                          {"name", "type", "default", "unit", "min", "max", "choices", "help"});
  Parameter parameter;
  parameter.name = ReadParameterName(table);
  parameter.type = ReadType(table);
  parameter.unit = table.Text("unit").value_or("");
  parameter.min = table.Number("min").value_or(parameter.min);
  parameter.max = table.Number("max").value_or(parameter.max);
  parameter.choices = table.Texts("choices");
  parameter.help = table.RequiredText("help");
  CheckRange(table, parameter);
  lua_getfield(state, -1, "default");
  const Value value = ReadValue(state, -1, what + ".default");
  lua_pop(state, 1);
  const bool text = std::holds_alternative<std::string>(value);
  if (text &&
      (parameter.type == ParameterType::kNumber || parameter.type == ParameterType::kInteger ||
       parameter.type == ParameterType::kBoolean)) {
    table.Refuse(fmt::format("default = {}: expected a {}", Show(value), Name(parameter.type)));
  }
  parameter.default_value = CheckValue("default of " + what, parameter, value);
  return parameter;
}

// Reads the field `parameters` of the table on top of the stack.
std::vector<Parameter> ReadParameters(lua_State* state) {
  std::vector<Parameter> parameters;
  if (lua_getfield(state, -1, "parameters") == LUA_TNIL) {
    lua_pop(state, 1);
    return parameters;
  }
  if (!lua_istable(state, -1)) {
    throw Error("procedure.parameters = " + ShowValue(state, -1) +
                ": expected a list of tables, { { name = ..., ... }, ... }");
  }
  const auto count = static_cast<lua_Integer>(lua_rawlen(state, -1));
  for (lua_Integer i = 1; i <= count; ++i) {
    lua_rawgeti(state, -1, i);
    parameters.push_back(ReadParameter(state, fmt::format("procedure.parameters[{}]", i)));
    lua_pop(state, 1);
    const auto same = std::count_if(parameters.begin(), parameters.end(), [&](const auto& other) {
      return other.name == parameters.back().name;
    });
    if (same > 1) throw Error("procedure.parameters: two are named " + parameters.back().name);
  }
  lua_pop(state, 1);
  return parameters;
}

std::vector<std::string> ReadMeasures(const TableReader& table) {
  std::vector<std::string> measures = table.Texts("measures");
  for (const std::string& measure : measures) {
    const auto& known = KnownMeasures();
    if (std::find(known.begin(), known.end(), measure) != known.end()) continue;
    table.Refuse(fmt::format("measures: \"{}\" is not known{}; known: {}", measure,
                             DidYouMean(measure, known), fmt::join(known, ", ")));
  }
  return measures;
}

// Reads the global tables `procedure` and the function `run` of a script that was loaded into
// `state`. Throws Error that names the field; file and name are the caller's.
ProcedureInfo ReadDeclaration(lua_State* state) {
  ProcedureInfo info;
  if (lua_getglobal(state, "procedure") == LUA_TNIL) {
    throw Error("the global table `procedure = { summary = ..., parameters = ... }` is missing");
  }
  const TableReader table(
      state, -1, "procedure",
      {"summary", "description", "measures", "parameters", "resumable", "commissions"});
  info.summary = table.RequiredText("summary");
  info.description = table.Text("description").value_or("");
  info.measures = ReadMeasures(table);
  info.resumable = table.Has("resumable") && table.RequiredFlag("resumable");
  info.commissions = table.Has("commissions") && table.RequiredFlag("commissions");
  if (info.commissions && info.resumable)
    table.Refuse("a procedure that commissions a stand cannot be resumable");
  info.parameters = ReadParameters(state);
  lua_pop(state, 1);
  const bool runs = lua_getglobal(state, "run") == LUA_TFUNCTION;
  lua_pop(state, 1);
  if (!runs) throw Error("the global function `run(p)` is missing");
  return info;
}

namespace fs = std::filesystem;

constexpr std::size_t kMaxSource = std::size_t{1} << 20;

bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= 60 &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-');
         });
}

// A pipe or a device of that name may never answer: nothing but a file is waited for.
std::string ReadSource(const fs::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  const auto refuse = [&](const std::string& why) {
    if (fd >= 0) close(fd);
    throw DataError(fmt::format("{}: cannot be read: {}", file.string(), why));
  };
  if (fd < 0) refuse(std::strerror(errno));
  struct stat status {};
  if (fstat(fd, &status) != 0) refuse(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) refuse("expected a file, found something else of that name");
  std::string source(kMaxSource + 1, '\0');
  std::size_t size = 0;
  while (size < source.size()) {
    const ssize_t got = read(fd, source.data() + size, source.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  close(fd);
  source.resize(size);
  return source;
}

}  // namespace

Procedure::Procedure(ProcedureInfo info, std::string source)
    : info_(std::move(info)), source_(std::move(source)) {}

Procedure Procedure::FromSource(const std::string& name, const fs::path& file, std::string source,
                                const SandboxLimits& limits) {
  const std::string shown = file.filename().string();
  if (!IsName(name)) {
    throw ScriptError(shown, 0, "a procedure's name consists of letters, digits, _ and -");
  }
  if (source.size() > kMaxSource || !IsText(source)) {
    throw ScriptError(shown, 0, "expected Lua source of at most 1 MB in UTF-8");
  }
  Sandbox sandbox(shown, limits);
  InstallCommands(sandbox.thread());
  sandbox.Load(source);
  ProcedureInfo info;
  try {
    info = ReadDeclaration(sandbox.thread());
  } catch (const Error& error) {
    throw ScriptError(shown, 0, error.what());
  }
  info.name = name;
  info.file = file;
  return {std::move(info), std::move(source)};
}

Procedure Procedure::Load(const fs::path& file, const SandboxLimits& limits) {
  return FromSource(file.stem().string(), file, ReadSource(file), limits);
}

ProcedureLibrary::ProcedureLibrary(std::vector<fs::path> directories, SandboxLimits limits)
    : directories_(std::move(directories)), limits_(std::move(limits)) {}

std::map<std::string, fs::path> ProcedureLibrary::Files() const {
  std::map<std::string, fs::path> files;
  for (const fs::path& directory : directories_) {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(directory, missing)) {
      if (entry.path().extension() == ".lua") files.emplace(entry.path().stem(), entry.path());
    }
  }
  return files;
}

std::vector<ProcedureInfo> ProcedureLibrary::List() const {
  std::vector<ProcedureInfo> list;
  for (const auto& [name, file] : Files()) {
    try {
      list.push_back(Procedure::Load(file, limits_).info());
    } catch (const Aborted&) {
      throw;
    } catch (const Error& error) {
      ProcedureInfo info;
      info.name = name;
      info.file = file;
      info.problem = error.what();
      list.push_back(std::move(info));
    }
  }
  return list;
}

Procedure ProcedureLibrary::Find(const std::string& name) const {
  const auto files = Files();
  if (const auto found = files.find(name); found != files.end()) {
    return Procedure::Load(found->second, limits_);
  }
  std::vector<std::string> names;
  for (const auto& [known, file] : files) names.push_back(known);
  std::vector<std::string> searched;
  for (const fs::path& directory : directories_) searched.push_back(directory.string());
  throw UnknownProcedure(fmt::format(
      "there is no procedure {}{}; known: {} (looked for NAME.lua in {})", Show(Value(name)),
      DidYouMean(name, names), names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")),
      searched.empty() ? "no directory" : fmt::format("{}", fmt::join(searched, ", "))));
}

}  // namespace gyrobench::procedures
