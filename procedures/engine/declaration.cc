#include "procedures/engine/declaration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <lua.hpp>
#include <optional>

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

}  // namespace

ProcedureInfo ReadDeclaration(lua_State* state) {
  ProcedureInfo info;
  if (lua_getglobal(state, "procedure") == LUA_TNIL) {
    throw Error("the global table `procedure = { summary = ..., parameters = ... }` is missing");
  }
  const TableReader table(state, -1, "procedure",
                          {"summary", "description", "measures", "parameters"});
  info.summary = table.RequiredText("summary");
  info.description = table.Text("description").value_or("");
  info.measures = ReadMeasures(table);
  info.parameters = ReadParameters(state);
  lua_pop(state, 1);
  const bool runs = lua_getglobal(state, "run") == LUA_TFUNCTION;
  lua_pop(state, 1);
  if (!runs) throw Error("the global function `run(p)` is missing");
  return info;
}

}  // namespace gyrobench::procedures
