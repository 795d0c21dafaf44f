#include "cli/json_field.h"

#include "base/json_text.h"
#include "presentation/markup.h"
#include "presentation/number.h"

namespace gyrobench::cli {

const nlohmann::json& Field(const nlohmann::json& json, const std::string& key) {
  static const nlohmann::json kNull;
  if (!json.is_object()) return kNull;
  const auto found = json.find(key);
  return found == json.end() ? kNull : *found;
}

double Number(const nlohmann::json& json, const std::string& key) {
  const nlohmann::json& value = Field(json, key);
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string Text(const nlohmann::json& json, const std::string& key) {
  const nlohmann::json& value = Field(json, key);
  return value.is_string() ? presentation::CleanLines(value.get<std::string>()) : "";
}

std::int64_t Integer(const nlohmann::json& json, const std::string& key) {
  const nlohmann::json& value = Field(json, key);
  return value.is_number() ? value.get<std::int64_t>() : 0;
}

std::string Plain(const nlohmann::json& value) {
  if (value.is_null()) return "";
  if (value.is_string()) return presentation::CleanLines(value.get<std::string>());
  if (value.is_number_float()) return presentation::FormatNumber(value.get<double>(), 10);
  return JsonText(value);
}

}  // namespace gyrobench::cli
