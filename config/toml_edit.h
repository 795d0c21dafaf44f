// Changes of single values in a TOML file that somebody wrote: everything else, comments among it,
// stays as it is.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::config {

struct TomlEdit {
  std::string key;      // dotted, from the root: axis.inner.encoder.sign
  std::string value;    // as TOML writes it
  std::string comment;  // stands above the line
};

// A key that the text does not have comes first in its table, a table that it has not at its end:
// so that a file which includes another one says what differs from that. Throws ConfigError where
// the text, or what becomes of it, is not TOML, `file` being for messages.
std::string Edited(std::string_view text, const std::filesystem::path& file,
                   const std::vector<TomlEdit>& edits);
// The same of a file, which stays as it is.
std::string EditedFile(const std::filesystem::path& file, const std::vector<TomlEdit>& edits);

}  // namespace gyrobench::config
