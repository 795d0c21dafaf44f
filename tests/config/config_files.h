// Files for the tests of config/: a folder of their own each, and edits of shipped files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::config {

// Of the source tree.
std::filesystem::path ConfigFolder();

std::string ReadText(const std::filesystem::path& file);

// A folder that is removed at the end.
class TestFolder {
 public:
  TestFolder();
  ~TestFolder();
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path Write(const std::filesystem::path& name, std::string_view text) const;
  // The shipped stand files, maps and scenarios.
  void CopyConfig() const;

 private:
  std::filesystem::path path_;
};

std::vector<std::string> SplitLines(const std::string& text);
std::string JoinLines(const std::vector<std::string>& lines);
// `text` with the first `from` after the line `section` ("" = the beginning) replaced. Fails the
// test when there is none.
std::string Replace(std::string text, const std::string& section, const std::string& from,
                    const std::string& to);
// Number of the line of the first `what` after the line `section`; 1 is the first.
int LineOf(const std::string& text, const std::string& section, const std::string& what);

// The message of the ConfigError that `action` throws; "" when it throws none.
template <typename Action>
std::string ErrorOf(Action&& action);

}  // namespace gyrobench::config

#include "base/error.h"

template <typename Action>
std::string gyrobench::config::ErrorOf(Action&& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}
