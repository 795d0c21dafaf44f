// The checked reader that all TOML files of gyrobench go through. Every getter checks type and
// range; every error is a ConfigError that names file, line, dotted key, value and what was
// expected:
//   stand.toml:12: axis.inner.max_rate_deg_s = -5: expected a number in 0.001 .. 1000 deg/s
// NaN and infinity are refused. A key that nobody asked for is an error (Finish). ReadWhole names
// several mistakes of a file at once.
//
// A file may start with `include = "other.toml"` (a path relative to it): what it says then stands
// in front of what the other says, key by key through all tables; arrays are replaced as a whole.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace gyrobench::config {

// Inclusive. The unit is for messages.
struct NumberRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
  std::string_view unit = "";
};

struct IntegerRange {
  std::int64_t min = std::numeric_limits<std::int64_t>::min();
  std::int64_t max = std::numeric_limits<std::int64_t>::max();
  std::string_view unit = "";
};

// Inclusive bounds of an array's length.
struct LengthRange {
  std::size_t min = 0;
  std::size_t max = std::numeric_limits<std::size_t>::max();
};

// What is known of a key that was asked for; documentation is checked against it.
struct KnownKey {
  std::string name;  // dotted, from the root
  std::string
      expected;  // "a number in 0.001 .. 1000 deg/s"; empty where the key was only looked for
  // "required", "optional", or what holds without it.
  std::string fallback;
};

// One table of a file. A handle: copies speak of the same table and share what has been asked for.
class TomlTable {
 public:
  // Reads a file and the files it includes. The result is the root table.
  static TomlTable FromFile(const std::filesystem::path& file);
  // The same from text; `file` is for messages and relative paths.
  static TomlTable FromText(std::string_view text, const std::filesystem::path& file);

  // Of each getter: without `fallback` the key is required. A whole number passes as a number.
  double Number(std::string_view key, const NumberRange& range) const;
  double Number(std::string_view key, const NumberRange& range, double fallback) const;
  std::optional<double> OptionalNumber(std::string_view key, const NumberRange& range) const;

  std::int64_t Integer(std::string_view key, const IntegerRange& range) const;
  std::int64_t Integer(std::string_view key, const IntegerRange& range,
                       std::int64_t fallback) const;
  std::optional<std::int64_t> OptionalInteger(std::string_view key,
                                              const IntegerRange& range) const;

  bool Bool(std::string_view key) const;
  bool Bool(std::string_view key, bool fallback) const;

  // Of a file: 0o660. A mode written in decimal (660) is mostly out of range, and then refused.
  unsigned Permissions(std::string_view key, unsigned fallback) const;

  // Never empty when it comes from the file.
  std::string String(std::string_view key) const;
  std::string String(std::string_view key, std::string_view fallback) const;
  std::optional<std::string> OptionalString(std::string_view key) const;

  // One of a list of words, each with what it means.
  template <typename T>
  using Choices = std::initializer_list<std::pair<std::string_view, T>>;
  template <typename T>
  T Choice(std::string_view key, Choices<T> choices) const {
    return (choices.begin() + ChoiceIndex(key, Words(choices)))->second;
  }
  template <typename T>
  T Choice(std::string_view key, Choices<T> choices, T fallback) const {
    const auto is_fallback = [&](const auto& choice) { return choice.second == fallback; };
    const auto named = std::find_if(choices.begin(), choices.end(), is_fallback);
    const auto index = OptionalChoiceIndex(
        key, Words(choices), named == choices.end() ? std::string_view() : named->first);
    return index ? (choices.begin() + *index)->second : fallback;
  }

  template <typename T>
  std::optional<T> OptionalChoice(std::string_view key, Choices<T> choices) const {
    const auto index = OptionalChoiceIndex(key, Words(choices), {});
    return index ? std::optional<T>((choices.begin() + *index)->second) : std::nullopt;
  }

  // Relative paths, a fallback's too, are taken from the folder of the file that the key stands in.
  // Whether the path exists is not checked.
  std::filesystem::path Path(std::string_view key) const;
  std::filesystem::path Path(std::string_view key, const std::filesystem::path& fallback) const;
  std::optional<std::filesystem::path> OptionalPath(std::string_view key) const;
  std::vector<std::filesystem::path> Paths(std::string_view key, const LengthRange& length) const;

  std::vector<double> Numbers(std::string_view key, const NumberRange& range,
                              const LengthRange& length = {}) const;
  std::vector<std::string> Strings(std::string_view key, const LengthRange& length = {}) const;
  std::optional<std::vector<std::string>> OptionalStrings(std::string_view key,
                                                          const LengthRange& length = {}) const;

  TomlTable Table(std::string_view key) const;
  std::optional<TomlTable> OptionalTable(std::string_view key) const;
  // [[key]]; empty when absent.
  std::vector<TomlTable> Tables(std::string_view key) const;

  // Whether the file has the key. Counts as asking for it.
  bool Has(std::string_view key) const;
  // All keys of this table in alphabetical order, for tables whose keys are names ([axis.NAME]).
  // Counts as asking for none of them.
  std::vector<std::string> Keys() const;
  // Dotted name from the root: "axis.inner", empty for the root.
  const std::string& name() const;
  // "file:line" of a key, or of the table where the key is absent.
  std::string Place(std::string_view key) const;
  // The folder that relative paths of this table's file are taken from.
  std::filesystem::path Folder() const;

  // Throws for a rule that the getters do not know: "<place>: <key> = <value>: <problem>".
  [[noreturn]] void Fail(std::string_view key, std::string_view problem) const;
  // Throws with the place of the table: "<place>: [<name>]: <problem>".
  [[noreturn]] void FailTable(std::string_view problem) const;

  // What `read` makes of this root, all of it (Finish). Where single keys are wrong, `read` is
  // called again without them, for further mistakes: up to 20 are named in one error, a line each.
  // Rules between keys, and what is missing, are judged once single keys are right.
  template <typename Read>
  auto ReadWhole(const Read& read) const {
    for (;;) {
      try {
        auto result = read(*this);
        Finish();
        if (!HasMistakes()) return result;
        break;
      } catch (const ConfigError& error) {
        if (!GoOnAfter(error)) break;
      }
    }
    ThrowMistakes();
  }
  // To be called on the root when all has been read: throws for the first key, in this table or in
  // one opened from it, that nobody asked for, with the nearest that somebody did.
  void Finish() const;
  // All keys asked for so far, here and in the tables opened from here.
  std::vector<KnownKey> KnownKeys() const;

 private:
  struct Impl;
  bool HasMistakes() const;
  // Notes the mistake; whether another reading, without its key, can show more.
  bool GoOnAfter(const ConfigError& error) const;
  [[noreturn]] void ThrowMistakes() const;
  explicit TomlTable(std::shared_ptr<Impl> impl);

  template <typename T>
  static std::vector<std::string_view> Words(Choices<T> choices) {
    std::vector<std::string_view> words;
    for (const auto& choice : choices) words.push_back(choice.first);
    return words;
  }
  using Index = std::ptrdiff_t;
  Index ChoiceIndex(std::string_view key, const std::vector<std::string_view>& words) const;
  std::optional<Index> OptionalChoiceIndex(std::string_view key,
                                           const std::vector<std::string_view>& words,
                                           std::string_view fallback) const;

  std::shared_ptr<Impl> impl_;
};

}  // namespace gyrobench::config
