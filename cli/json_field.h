// Fields of JSON that another program wrote: a missing or null field reads as "not there", never as
// an exception.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace gyrobench::cli {

// Object `key` of `json`, null when there is none.
const nlohmann::json& Field(const nlohmann::json& json, const std::string& key);
// NaN when it is no number.
double Number(const nlohmann::json& json, const std::string& key);
// Empty when it is no text.
std::string Text(const nlohmann::json& json, const std::string& key);
std::int64_t Integer(const nlohmann::json& json, const std::string& key);
// A value as a person reads it: text without quotes.
std::string Plain(const nlohmann::json& value);

}  // namespace gyrobench::cli
