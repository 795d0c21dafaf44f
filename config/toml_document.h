// A TOML file as toml++ parsed it. Internal to config/: toml++ is heavy to compile.
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace gyrobench::config {

// One parsed file.
struct Document {
  std::filesystem::path file;
  toml::table root;
};

// A table as one file has it.
struct Layer {
  std::shared_ptr<const Document> document;
  const toml::table* table = nullptr;
};

// "file:line".
std::string Place(const std::filesystem::path& file, const toml::source_region& region);
// Throws ConfigError that says why the file cannot be read.
std::string ReadWholeFile(const std::filesystem::path& file);
// Throws ConfigError with line and column of bad syntax.
std::shared_ptr<const Document> Parse(std::string_view text, const std::filesystem::path& file);
// A value as a message shows it: on one line, cut when long.
std::string ShowValue(const toml::node& node);

}  // namespace gyrobench::config
