#include "cli/request_parameters.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>

#include "cli/exit_status.h"

namespace gyrobench::cli {
namespace {

template <typename Number>
bool ReadsAs(const std::string& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

nlohmann::json ParameterValue(const std::string& text) {
  std::int64_t integer = 0;
  double number = 0.0;
  if (ReadsAs(text, integer)) return integer;
  // JSON has no infinity: such a text is sent as it is, and refused with its name.
  if (ReadsAs(text, number) && std::isfinite(number)) return number;
  if (text == "true") return true;
  if (text == "false") return false;
  return text;
}

nlohmann::json RunRequest(const Options& options) {
  nlohmann::json parameters = nlohmann::json::object();
  for (const auto& [key, value] : options.parameters) {
    if (parameters.contains(key)) {
      throw UsageError(fmt::format("parameter '{}' is given twice: give it once", key));
    }
    parameters[key] = ParameterValue(value);
  }
  return {{"procedure", options.name}, {"parameters", parameters}};
}

}  // namespace gyrobench::cli
