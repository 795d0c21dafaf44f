#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/nearest_word.h"
#include "procedures/engine/procedure.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {
namespace {

// Beyond it a double holds no odd numbers.
constexpr double kMaxInteger = 9007199254740992.0;

std::string Range(const Parameter& parameter) {
  const std::string unit = parameter.unit.empty() ? "" : " " + parameter.unit;
  if (std::isinf(parameter.min) && std::isinf(parameter.max)) return unit;
  if (std::isinf(parameter.max)) return fmt::format(", {:.10g} or more{}", parameter.min, unit);
  if (std::isinf(parameter.min)) return fmt::format(", {:.10g} or less{}", parameter.max, unit);
  return fmt::format(", {:.10g} .. {:.10g}{}", parameter.min, parameter.max, unit);
}

std::string Expected(const Parameter& parameter) {
  switch (parameter.type) {
    case ParameterType::kNumber:
      return "a number" + Range(parameter);
    case ParameterType::kInteger:
      return "a whole number" + Range(parameter);
    case ParameterType::kNumbers:
      return "numbers with commas between them" +
             (Range(parameter).empty() ? "" : ", each" + Range(parameter).substr(1));
    case ParameterType::kChoice:
      return fmt::format("one of {}", fmt::join(parameter.choices, ", "));
    case ParameterType::kBoolean:
      return "true or false";
    case ParameterType::kText:
      break;
  }
  return "a text";
}

// The number that `value` is or says, nullopt where it is none or does not fit.
std::optional<double> FittingNumber(const Parameter& parameter, const Value& value) {
  std::optional<double> number;
  if (const auto* direct = std::get_if<double>(&value)) number = *direct;
  if (const auto* text = std::get_if<std::string>(&value)) number = ReadNumber(*text);
  if (!number || !std::isfinite(*number)) return std::nullopt;
  if (*number < parameter.min || *number > parameter.max) return std::nullopt;
  const bool whole = std::trunc(*number) == *number && std::abs(*number) <= kMaxInteger;
  if (parameter.type == ParameterType::kInteger && !whole) return std::nullopt;
  return number;
}

std::optional<std::string> FittingNumbers(const Parameter& parameter, const Value& value) {
  const auto* direct = std::get_if<double>(&value);
  const auto* given = std::get_if<std::string>(&value);
  if (direct == nullptr && given == nullptr) return std::nullopt;
  const std::string text = given != nullptr ? *given : fmt::format("{}", *direct);
  const auto numbers = ReadNumbers(text);
  if (!numbers) return std::nullopt;
  const bool fit = std::all_of(numbers->begin(), numbers->end(), [&](double number) {
    return number >= parameter.min && number <= parameter.max;
  });
  if (!fit) return std::nullopt;
  return text;
}

// How what was probably meant is written; empty where that cannot be told.
std::string Hint(const Parameter& parameter, const Value& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr || !IsText(*text)) return "";
  const bool list = parameter.type == ParameterType::kNumbers;
  if (!list && parameter.type != ParameterType::kNumber &&
      parameter.type != ParameterType::kInteger)
    return "";
  // A list of "0,5" reads as two numbers; of which one may be out of range.
  const auto point = WithDecimalPoint(*text);
  if (point && FittingNumber(parameter, *point))
    return fmt::format("{} {}", list ? "; is one number meant? Write" : "; write", *point);
  if (!list) return "";
  std::string commas;
  for (std::size_t at = 0; (at = text->find_first_not_of("; \t", at)) != std::string::npos;) {
    const std::size_t end = std::min(text->find_first_of("; \t", at), text->size());
    commas += (commas.empty() ? "" : ",") + text->substr(at, end - at);
    at = end;
  }
  return FittingNumbers(parameter, commas) ? "; write " + commas : "";
}

[[noreturn]] void Refuse(const std::string& procedure, const Parameter& parameter,
                         const Value& value) {
  const bool number = std::holds_alternative<double>(value) && !parameter.unit.empty();
  throw ParameterError(fmt::format("{}: parameter {} = {}{}: expected {}{}", procedure,
                                   parameter.name, Show(value), number ? " " + parameter.unit : "",
                                   Expected(parameter), Hint(parameter, value)));
}

std::optional<bool> FittingBoolean(const Value& value) {
  if (const auto* direct = std::get_if<bool>(&value)) return *direct;
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr || (*text != "true" && *text != "false")) return std::nullopt;
  return *text == "true";
}

std::optional<std::string> FittingText(const Value& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr || !IsText(*text)) return std::nullopt;
  return *text;
}

// A choice that reads as a number comes as one from a command line.
std::optional<std::string> FittingChoice(const Parameter& parameter, const Value& value) {
  const auto* number = std::get_if<double>(&value);
  const std::optional<std::string> text =
      number != nullptr ? fmt::format("{}", *number) : FittingText(value);
  if (!text || std::ranges::find(parameter.choices, *text) == parameter.choices.end())
    return std::nullopt;
  return text;
}

}  // namespace

const char* Name(ParameterType type) {
  switch (type) {
    case ParameterType::kNumber:
      return "number";
    case ParameterType::kInteger:
      return "integer";
    case ParameterType::kNumbers:
      return "numbers";
    case ParameterType::kChoice:
      return "choice";
    case ParameterType::kBoolean:
      return "boolean";
    case ParameterType::kText:
      break;
  }
  return "text";
}

std::string Show(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  const auto& text = std::get<std::string>(value);
  return IsText(text) ? "\"" + text + "\"" : "text that is not UTF-8";
}

Value CheckValue(const std::string& procedure, const Parameter& parameter, const Value& value) {
  switch (parameter.type) {
    case ParameterType::kNumber:
    case ParameterType::kInteger:
      if (const auto number = FittingNumber(parameter, value)) return *number;
      break;
    case ParameterType::kNumbers:
      if (const auto numbers = FittingNumbers(parameter, value)) return *numbers;
      break;
    case ParameterType::kBoolean:
      if (const auto flag = FittingBoolean(value)) return *flag;
      break;
    case ParameterType::kChoice:
      if (const auto choice = FittingChoice(parameter, value)) return *choice;
      break;
    case ParameterType::kText:
      if (const auto text = FittingText(value)) return *text;
      break;
  }
  Refuse(procedure, parameter, value);
}

Parameters CheckParameters(const ProcedureInfo& procedure, const Parameters& given) {
  Parameters checked;
  std::vector<std::string> names;
  for (const Parameter& parameter : procedure.parameters) {
    names.push_back(parameter.name);
    const auto found = given.find(parameter.name);
    checked[parameter.name] = found == given.end()
                                  ? parameter.default_value
                                  : CheckValue(procedure.name, parameter, found->second);
  }
  for (const auto& [name, value] : given) {
    if (checked.contains(name)) continue;
    throw ParameterError(
        fmt::format("{}: there is no parameter {}{}; parameters: {}", procedure.name,
                    Show(Value(name)), DidYouMean(name, names),
                    names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  }
  return checked;
}

}  // namespace gyrobench::procedures
