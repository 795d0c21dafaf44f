// One table of a TOML file, over the layers of the files that this includes: where a key is found,
// what the program expects of it, and what is said of one that is wrong. Internal to config/.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/nearest_word.h"
#include "config/toml_document.h"
#include "config/toml_expected.h"
#include "config/toml_mistakes.h"
#include "config/toml_reader.h"

namespace gyrobench::config {

// Files that include each other in a circle would never end.
inline constexpr int kMaxIncludeDepth = 8;

inline std::optional<double> AsNumber(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return static_cast<double>(integer->get());
  if (const auto* real = node.as_floating_point()) return real->get();
  return std::nullopt;
}

struct TomlTable::Impl {
  // Where a key was found.
  struct Found {
    const Layer* layer = nullptr;
    const toml::node* node = nullptr;
    explicit operator bool() const { return node != nullptr; }
  };

  // What the program expects of a key (KnownKey).
  struct Asked {
    std::string expected;
    std::string fallback;
  };

  std::string name;
  std::vector<Layer> layers;  // those in front speak first; never empty
  std::map<std::string, Asked, std::less<>> known;
  std::map<std::string, std::shared_ptr<Impl>> children;  // by dotted name
  std::shared_ptr<Mistakes> mistakes;                     // of the whole file

  static std::shared_ptr<Impl> Root(std::string_view text, const std::filesystem::path& file) {
    auto impl = std::make_shared<Impl>();
    impl->mistakes = std::make_shared<Mistakes>();
    impl->AddFile(text, file);
    return impl;
  }

  void AddFile(std::string_view text, const std::filesystem::path& file) {
    auto document = Parse(text, file);
    layers.push_back({document, &document->root});
    const toml::node* include = document->root.get("include");
    if (include == nullptr) return;
    known["include"] = {std::string(kPathExpected), std::string(kOptional)};
    const Found found{&layers.back(), include};
    const auto* other = include->as_string();
    if (other == nullptr || other->get().empty())
      Throw("include", found, "expected the path of a TOML file");
    if (layers.size() > kMaxIncludeDepth) {
      Throw("include", found,
            fmt::format("more than {} files deep; do they include each other?", kMaxIncludeDepth));
    }
    const std::filesystem::path path = file.parent_path() / other->get();
    std::string included;
    try {
      included = ReadWholeFile(path);
    } catch (const ConfigError& error) {
      Throw("include", found, error.what());
    }
    AddFile(included, path);
  }

  std::string Dotted(std::string_view key) const {
    return name.empty() ? std::string(key) : fmt::format("{}.{}", name, key);
  }

  std::string TableExpected(std::string_view key) const {
    return fmt::format("a table [{}]", Dotted(key));
  }

  // Looks up a key and notes what is expected of it.
  Found Find(std::string_view key, std::string_view expected, std::string_view fallback) {
    known.insert_or_assign(std::string(key), Asked{std::string(expected), std::string(fallback)});
    return Look(key);
  }

  bool IsLeftOut(std::string_view key) const {
    return !mistakes->left_out.empty() && mistakes->left_out.contains(Dotted(key));
  }

  // For what depends on more than one key.
  void ThrowIfConsequence(const std::string& message) const {
    if (!mistakes->left_out.empty()) throw ConsequenceError(message);
  }

  Found Look(std::string_view key) const {
    if (IsLeftOut(key)) return {};
    for (const Layer& layer : layers) {
      if (const toml::node* node = layer.table->get(key)) return {&layer, node};
    }
    return {};
  }

  Found Require(std::string_view key, std::string_view expected) {
    const Found found = Find(key, expected, kRequired);
    if (!found) {
      const std::string message = fmt::format("{}: {} is missing: expected {}{}", TablePlace(),
                                              Dotted(key), expected, NearMiss(key));
      if (IsLeftOut(key)) throw ConsequenceError(message);
      throw ConfigError(message);
    }
    return found;
  }

  // A key of the file that may have been meant as the missing `key`.
  std::string NearMiss(std::string_view key) const {
    constexpr int kSlips = 2;
    for (const Layer& layer : layers) {
      for (const auto& [other, node] : *layer.table) {
        if (known.contains(other.str()) || EditDistance(key, other.str()) > kSlips) continue;
        return fmt::format(" (is \"{}\" in line {} meant?)", other.str(),
                           other.source().begin.line);
      }
    }
    return {};
  }

  std::string TablePlace() const {
    return config::Place(layers.front().document->file, layers.front().table->source());
  }

  std::string PlaceOf(const Found& found) const {
    return config::Place(found.layer->document->file, found.node->source());
  }

  [[noreturn]] void Throw(std::string_view key, const Found& found,
                          std::string_view problem) const {
    const std::string name_in_table(key.substr(0, key.find('[')));  // of an element: its array
    throw KeyError(fmt::format("{}: {} = {}: {}", PlaceOf(found), Dotted(key),
                               ShowValue(*found.node), problem),
                   Dotted(name_in_table), mistakes.get());
  }

  [[noreturn]] void ThrowExpected(std::string_view key, const Found& found,
                                  std::string_view expected) const {
    Throw(key, found, fmt::format("expected {}", expected));
  }

  double Number(std::string_view key, const Found& found, const NumberRange& range) const {
    const auto value = AsNumber(*found.node);
    if (!value || !std::isfinite(*value) || *value < range.min || *value > range.max) {
      ThrowExpected(key, found, WithUnit("a number", range));
    }
    return *value;
  }

  std::int64_t Integer(std::string_view key, const Found& found, const IntegerRange& range) const {
    const auto* value = found.node->as_integer();
    if (value == nullptr || value->get() < range.min || value->get() > range.max) {
      ThrowExpected(key, found, WithUnit("a whole number", range));
    }
    return value->get();
  }

  bool Bool(std::string_view key, const Found& found) const {
    const auto* value = found.node->as_boolean();
    if (value == nullptr) ThrowExpected(key, found, kBoolExpected);
    return value->get();
  }

  std::string String(std::string_view key, const Found& found, std::string_view expected) const {
    const auto* value = found.node->as_string();
    if (value == nullptr || value->get().empty() || value->get().find('\0') != std::string::npos) {
      ThrowExpected(key, found, expected);
    }
    return value->get();
  }

  std::ptrdiff_t Choice(std::string_view key, const Found& found,
                        const std::vector<std::string_view>& words) const {
    const auto at = std::ranges::find(words, String(key, found, OneOf(words)));
    if (at == words.end()) ThrowExpected(key, found, OneOf(words));
    return at - words.begin();
  }

  std::filesystem::path Path(std::string_view key, const Found& found) const {
    const std::filesystem::path path = String(key, found, kPathExpected);
    return (found.layer->document->file.parent_path() / path).lexically_normal();
  }

  const toml::array& Array(std::string_view key, const Found& found, std::string_view expected,
                           const LengthRange& length) const {
    const auto* array = found.node->as_array();
    if (array == nullptr || array->size() < length.min || array->size() > length.max) {
      ThrowExpected(key, found, expected);
    }
    return *array;
  }

  // The table `key`, merged over the layers that have it.
  std::shared_ptr<Impl> Child(std::string_view key) {
    std::shared_ptr<Impl>& child = children[Dotted(key)];
    if (child != nullptr) return child;
    auto made = std::make_shared<Impl>();
    made->name = Dotted(key);
    made->mistakes = mistakes;
    for (const Layer& layer : layers) {
      const toml::node* node = layer.table->get(key);
      if (node == nullptr) continue;
      if (!node->is_table()) {
        ThrowExpected(key, {&layer, node}, TableExpected(key));
      }
      made->layers.push_back({layer.document, node->as_table()});
    }
    child = made;
    return child;
  }

  // One element of the array of tables `key`.
  std::shared_ptr<Impl> Element(std::string_view key, std::size_t index, const Layer& layer) {
    const std::string element_name = fmt::format("{}[{}]", Dotted(key), index);
    std::shared_ptr<Impl>& child = children[element_name];
    if (child != nullptr) return child;
    child = std::make_shared<Impl>();
    child->name = element_name;
    child->mistakes = mistakes;
    child->layers.push_back(layer);
    return child;
  }

  void Finish() const {
    for (const Layer& layer : layers) {
      for (const auto& [key, node] : *layer.table) {
        if (!known.contains(key.str()) && !IsLeftOut(key.str())) ThrowUnknown(key, {&layer, &node});
      }
    }
    for (const auto& [_, child] : children) {
      if (child != nullptr) child->Finish();
    }
  }

  [[noreturn]] void ThrowUnknown(const toml::key& key, const Found& found) const {
    std::vector<std::string> words;
    for (const auto& [word, asked] : known) words.push_back(word);
    throw KeyError(fmt::format("{}: unknown key {}; {}",
                               config::Place(found.layer->document->file, key.source()),
                               Dotted(key.str()), Suggestion(key.str(), words)),
                   Dotted(key.str()), mistakes.get());
  }
};

}  // namespace gyrobench::config
