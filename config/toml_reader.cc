#include "config/toml_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "base/nearest_word.h"
#include "config/toml_document.h"
#include "config/toml_expected.h"
#include "config/toml_mistakes.h"

namespace gyrobench::config {
namespace fs = std::filesystem;
namespace {

// Files that include each other in a circle would never end.
constexpr int kMaxIncludeDepth = 8;

std::optional<double> AsNumber(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return static_cast<double>(integer->get());
  if (const auto* real = node.as_floating_point()) return real->get();
  return std::nullopt;
}

}  // namespace

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

  static std::shared_ptr<Impl> Root(std::string_view text, const fs::path& file) {
    auto impl = std::make_shared<Impl>();
    impl->mistakes = std::make_shared<Mistakes>();
    impl->AddFile(text, file);
    return impl;
  }

  void AddFile(std::string_view text, const fs::path& file) {
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
    const fs::path path = file.parent_path() / other->get();
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

  fs::path Path(std::string_view key, const Found& found) const {
    const fs::path path = String(key, found, kPathExpected);
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

TomlTable::TomlTable(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

TomlTable TomlTable::FromFile(const fs::path& file) {
  return TomlTable(Impl::Root(ReadWholeFile(file), file));
}

TomlTable TomlTable::FromText(std::string_view text, const fs::path& file) {
  return TomlTable(Impl::Root(text, file));
}

double TomlTable::Number(std::string_view key, const NumberRange& range) const {
  return impl_->Number(key, impl_->Require(key, WithUnit("a number", range)), range);
}

double TomlTable::Number(std::string_view key, const NumberRange& range, double fallback) const {
  const auto found = impl_->Find(key, WithUnit("a number", range), fmt::format("{}", fallback));
  return found ? impl_->Number(key, found, range) : fallback;
}

std::optional<double> TomlTable::OptionalNumber(std::string_view key,
                                                const NumberRange& range) const {
  const auto found = impl_->Find(key, WithUnit("a number", range), kOptional);
  return found ? std::optional(impl_->Number(key, found, range)) : std::nullopt;
}

std::int64_t TomlTable::Integer(std::string_view key, const IntegerRange& range) const {
  return impl_->Integer(key, impl_->Require(key, WithUnit("a whole number", range)), range);
}

std::int64_t TomlTable::Integer(std::string_view key, const IntegerRange& range,
                                std::int64_t fallback) const {
  const auto found =
      impl_->Find(key, WithUnit("a whole number", range), fmt::format("{}", fallback));
  return found ? impl_->Integer(key, found, range) : fallback;
}

std::optional<std::int64_t> TomlTable::OptionalInteger(std::string_view key,
                                                       const IntegerRange& range) const {
  const auto found = impl_->Find(key, WithUnit("a whole number", range), kOptional);
  return found ? std::optional(impl_->Integer(key, found, range)) : std::nullopt;
}

bool TomlTable::Bool(std::string_view key) const {
  return impl_->Bool(key, impl_->Require(key, kBoolExpected));
}

bool TomlTable::Bool(std::string_view key, bool fallback) const {
  const auto found = impl_->Find(key, kBoolExpected, fallback ? "true" : "false");
  return found ? impl_->Bool(key, found) : fallback;
}

unsigned TomlTable::Permissions(std::string_view key, unsigned fallback) const {
  constexpr unsigned kAllBits = 0777;
  constexpr std::string_view kExpected = "permissions in octal, 0o000 .. 0o777";
  const auto found = impl_->Find(key, kExpected, fmt::format("0o{:03o}", fallback));
  if (!found) return fallback;
  const auto* value = found.node->as_integer();
  if (value == nullptr || value->get() < 0 || value->get() > kAllBits) {
    impl_->ThrowExpected(key, found, kExpected);
  }
  return static_cast<unsigned>(value->get());
}

std::string TomlTable::String(std::string_view key) const {
  return impl_->String(key, impl_->Require(key, kTextExpected), kTextExpected);
}

std::string TomlTable::String(std::string_view key, std::string_view fallback) const {
  const auto found = impl_->Find(key, kTextExpected, fmt::format("\"{}\"", fallback));
  return found ? impl_->String(key, found, kTextExpected) : std::string(fallback);
}

std::optional<std::string> TomlTable::OptionalString(std::string_view key) const {
  const auto found = impl_->Find(key, kTextExpected, kOptional);
  return found ? std::optional(impl_->String(key, found, kTextExpected)) : std::nullopt;
}

TomlTable::Index TomlTable::ChoiceIndex(std::string_view key,
                                        const std::vector<std::string_view>& words) const {
  return impl_->Choice(key, impl_->Require(key, OneOf(words)), words);
}

std::optional<TomlTable::Index> TomlTable::OptionalChoiceIndex(
    std::string_view key, const std::vector<std::string_view>& words,
    std::string_view fallback) const {
  const auto found = impl_->Find(key, OneOf(words), fmt::format("\"{}\"", fallback));
  return found ? std::optional(impl_->Choice(key, found, words)) : std::nullopt;
}

fs::path TomlTable::Path(std::string_view key) const {
  return impl_->Path(key, impl_->Require(key, kPathExpected));
}

fs::path TomlTable::Path(std::string_view key, const fs::path& fallback) const {
  const auto found = impl_->Find(key, kPathExpected, fmt::format("\"{}\"", fallback.string()));
  return found ? impl_->Path(key, found) : (Folder() / fallback).lexically_normal();
}

std::optional<fs::path> TomlTable::OptionalPath(std::string_view key) const {
  const auto found = impl_->Find(key, kPathExpected, kOptional);
  return found ? std::optional(impl_->Path(key, found)) : std::nullopt;
}

std::vector<fs::path> TomlTable::Paths(std::string_view key, const LengthRange& length) const {
  const auto found = impl_->Require(key, WithLength("paths", length));
  std::vector<fs::path> paths;
  for (const toml::node& node : impl_->Array(key, found, WithLength("paths", length), length)) {
    paths.push_back(impl_->Path(key, {found.layer, &node}));
  }
  return paths;
}

std::vector<double> TomlTable::Numbers(std::string_view key, const NumberRange& range,
                                       const LengthRange& length) const {
  const std::string expected = WithUnit(WithLength("numbers", length), range);
  const auto found = impl_->Require(key, expected);
  std::vector<double> numbers;
  for (const toml::node& node : impl_->Array(key, found, expected, length)) {
    numbers.push_back(
        impl_->Number(fmt::format("{}[{}]", key, numbers.size()), {found.layer, &node}, range));
  }
  return numbers;
}

std::vector<std::string> TomlTable::Strings(std::string_view key, const LengthRange& length) const {
  const std::string expected = WithLength("texts", length);
  const auto found = impl_->Require(key, expected);
  std::vector<std::string> strings;
  for (const toml::node& node : impl_->Array(key, found, expected, length)) {
    strings.push_back(impl_->String(fmt::format("{}[{}]", key, strings.size()),
                                    {found.layer, &node}, kTextExpected));
  }
  return strings;
}

TomlTable TomlTable::Table(std::string_view key) const {
  impl_->Require(key, impl_->TableExpected(key));
  return TomlTable(impl_->Child(key));
}

std::optional<TomlTable> TomlTable::OptionalTable(std::string_view key) const {
  return impl_->Find(key, impl_->TableExpected(key), kOptional)
             ? std::optional(TomlTable(impl_->Child(key)))
             : std::nullopt;
}

std::vector<TomlTable> TomlTable::Tables(std::string_view key) const {
  const std::string expected = fmt::format("tables [[{}]]", impl_->Dotted(key));
  const auto found = impl_->Find(key, expected, kOptional);
  if (!found) return {};
  std::vector<TomlTable> tables;
  for (const toml::node& node : impl_->Array(key, found, expected, {})) {
    if (!node.is_table()) impl_->ThrowExpected(key, {found.layer, &node}, expected);
    const Layer layer{found.layer->document, node.as_table()};
    tables.push_back(TomlTable(impl_->Element(key, tables.size(), layer)));
  }
  return tables;
}

bool TomlTable::Has(std::string_view key) const {
  impl_->known.try_emplace(std::string(key));
  return static_cast<bool>(impl_->Look(key));
}

std::vector<std::string> TomlTable::Keys() const {
  std::set<std::string> keys;
  for (const Layer& layer : impl_->layers) {
    for (const auto& [key, node] : *layer.table) {
      if (!impl_->IsLeftOut(key.str())) keys.emplace(key.str());
    }
  }
  return {keys.begin(), keys.end()};
}

const std::string& TomlTable::name() const { return impl_->name; }

std::string TomlTable::Place(std::string_view key) const {
  const auto found = impl_->Look(key);
  return found ? impl_->PlaceOf(found) : impl_->TablePlace();
}

fs::path TomlTable::Folder() const { return impl_->layers.front().document->file.parent_path(); }

void TomlTable::Fail(std::string_view key, std::string_view problem) const {
  impl_->ThrowIfConsequence(std::string(problem));
  const auto found = impl_->Look(key);
  if (found) impl_->Throw(key, found, problem);
  throw ConfigError(
      fmt::format("{}: {} (not given): {}", impl_->TablePlace(), impl_->Dotted(key), problem));
}

void TomlTable::FailTable(std::string_view problem) const {
  impl_->ThrowIfConsequence(std::string(problem));
  throw ConfigError(fmt::format("{}: [{}]: {}", impl_->TablePlace(), impl_->name, problem));
}

void TomlTable::Finish() const { impl_->Finish(); }

bool TomlTable::HasMistakes() const { return !impl_->mistakes->messages.empty(); }

bool TomlTable::GoOnAfter(const ConfigError& error) const {
  if (dynamic_cast<const ConsequenceError*>(&error) != nullptr) return false;
  Mistakes& mistakes = *impl_->mistakes;
  mistakes.messages.emplace_back(error.what());
  const auto* wrong = dynamic_cast<const KeyError*>(&error);
  return wrong != nullptr && wrong->file() == &mistakes &&
         mistakes.messages.size() < kMostMistakes && mistakes.left_out.insert(wrong->key()).second;
}

void TomlTable::ThrowMistakes() const {
  const std::vector<std::string>& messages = impl_->mistakes->messages;
  if (messages.size() == 1) throw ConfigError(messages.front());
  throw ConfigError(fmt::format("{}{} mistakes:\n  {}",
                                messages.size() == kMostMistakes ? "the first " : "",
                                messages.size(), fmt::join(messages, "\n  ")));
}

std::vector<KnownKey> TomlTable::KnownKeys() const {
  std::vector<KnownKey> keys;
  for (const auto& [key, asked] : impl_->known) {
    keys.push_back({impl_->Dotted(key), asked.expected, asked.fallback});
  }
  for (const auto& [_, child] : impl_->children) {
    if (child == nullptr) continue;
    const auto more = TomlTable(child).KnownKeys();
    keys.insert(keys.end(), more.begin(), more.end());
  }
  return keys;
}

}  // namespace gyrobench::config
