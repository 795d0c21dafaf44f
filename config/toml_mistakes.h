// What TomlTable::ReadWhole collects. Internal to config/.
#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace gyrobench::config {

inline constexpr std::size_t kMostMistakes = 20;

// Of one file and what it includes, while it is read again and again (ReadWhole).
struct Mistakes {
  std::vector<std::string> messages;
  std::set<std::string, std::less<>> left_out;  // dotted keys that are wrong
};

// A key that is wrong by itself.
class KeyError : public ConfigError {
 public:
  KeyError(const std::string& message, std::string key, const Mistakes* file)
      : ConfigError(message), key_(std::move(key)), file_(file) {}
  const std::string& key() const { return key_; }
  const Mistakes* file() const { return file_; }

 private:
  std::string key_;
  const Mistakes* file_;
};

// Wrong perhaps only because another key is.
class ConsequenceError : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

}  // namespace gyrobench::config
