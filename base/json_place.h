// Strict reading of JSON: nothing is guessed, nothing is passed over.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/measurement.h"

namespace gyrobench {

// A value of a JSON file and the way to it, for messages: "cal.json: channels[0].m_row".
class Place {
 public:
  Place(const nlohmann::json& value, const std::string& file, std::string path = "")
      : value_(value), file_(file), path_(std::move(path)) {}

  const nlohmann::json& value() const { return value_; }
  [[noreturn]] void Fail(const std::string& what) const {
    throw DataError(fmt::format("{}: {}{}{}", file_, path_, path_.empty() ? "" : ": ", what));
  }
  [[noreturn]] void Expected(const std::string& what) const {
    std::string found = value_.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    if (found.size() > 60) found.replace(60, std::string::npos, "...");
    Fail(fmt::format("expected {}, found {}", what, found));
  }

  // An object with exactly these keys; `optional` ones may be missing.
  const Place& Keys(const std::vector<const char*>& keys,
                    const std::vector<const char*>& optional = {}) const {
    if (!value_.is_object()) Expected("an object {...}");
    for (const char* key : keys) {
      if (!value_.contains(key)) Fail(fmt::format("the key \"{}\" is missing", key));
    }
    for (const auto& item : value_.items()) {
      const bool known = std::find(keys.begin(), keys.end(), item.key()) != keys.end() ||
                         std::find(optional.begin(), optional.end(), item.key()) != optional.end();
      if (!known) {
        Fail(fmt::format("unknown key \"{}\"; expected {}", item.key(), fmt::join(keys, ", ")));
      }
    }
    return *this;
  }
  bool Has(const char* key) const { return value_.contains(key); }
  Place operator[](const char* key) const {
    return {value_.at(key), file_, path_ + (path_.empty() ? "" : ".") + key};
  }
  std::vector<Place> List() const {
    if (!value_.is_array()) Expected("a list [...]");
    std::vector<Place> places;
    for (std::size_t i = 0; i < value_.size(); ++i) {
      places.emplace_back(value_[i], file_, fmt::format("{}[{}]", path_, i));
    }
    return places;
  }

  std::string Text() const {
    if (!value_.is_string()) Expected("a text");
    return value_.get<std::string>();
  }
  double Number() const {
    if (!value_.is_number()) Expected("a number");
    return value_.get<double>();
  }
  double NumberOrNull() const { return value_.is_null() ? kMissing : Number(); }
  double Positive() const {
    if (!value_.is_number() || !(Number() > 0.0)) Expected("a number above 0");
    return Number();
  }
  std::int64_t Count() const {
    if (!value_.is_number_integer() || value_.get<std::int64_t>() < 0) Expected("a count");
    return value_.get<std::int64_t>();
  }
  bool Flag() const {
    if (!value_.is_boolean()) Expected("true or false");
    return value_.get<bool>();
  }
  std::vector<double> Numbers() const {
    std::vector<double> values;
    for (const Place& place : List()) values.push_back(place.Number());
    return values;
  }
  // The one of `choices`, in whose order they are numbered.
  std::size_t Choice(std::span<const char* const> choices) const {
    const auto found = std::find(choices.begin(), choices.end(), Text());
    if (found == choices.end()) Expected(fmt::format("one of {}", fmt::join(choices, ", ")));
    return static_cast<std::size_t>(found - choices.begin());
  }

 private:
  const nlohmann::json& value_;
  const std::string& file_;
  std::string path_;
};

}  // namespace gyrobench
