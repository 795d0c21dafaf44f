#include "config/toml_reader.h"

#include <set>

#include "config/toml_layers.h"

namespace gyrobench::config {
namespace fs = std::filesystem;

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
  const auto found = impl_->Find(key, OneOf(words),
                                 fallback.empty() ? "optional" : fmt::format("\"{}\"", fallback));
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
  impl_->Require(key, WithLength("texts", length));
  return *OptionalStrings(key, length);
}

std::optional<std::vector<std::string>> TomlTable::OptionalStrings(
    std::string_view key, const LengthRange& length) const {
  const std::string expected = WithLength("texts", length);
  const auto found = impl_->Find(key, expected, kOptional);
  if (!found) return std::nullopt;
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
