#include "tests/config/config_files.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace gyrobench::config {
namespace fs = std::filesystem;

fs::path ConfigFolder() { return fs::path(GYROBENCH_SOURCE_DIR) / "config"; }

std::string ReadText(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot open " + file.string());
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TestFolder::TestFolder() {
  std::string name = (fs::temp_directory_path() / "gyrobench-config-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

TestFolder::~TestFolder() { fs::remove_all(path_); }

fs::path TestFolder::Write(const fs::path& name, std::string_view text) const {
  const fs::path file = path_ / name;
  fs::create_directories(file.parent_path());
  fs::remove(
      file);  // some file systems flush to the disk when a file is truncated, and that is slow
  std::ofstream(file) << text;
  return file;
}

void TestFolder::CopyConfig() const {
  for (const auto& entry : fs::recursive_directory_iterator(ConfigFolder())) {
    if (entry.path().extension() != ".toml") continue;
    Write(fs::relative(entry.path(), ConfigFolder()), ReadText(entry.path()));
  }
}

std::vector<std::string> SplitLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string JoinLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

namespace {

std::size_t Find(const std::string& text, const std::string& section, const std::string& what) {
  const std::size_t begin = section.empty() ? 0 : text.find(section);
  const std::size_t at = begin == std::string::npos ? begin : text.find(what, begin);
  if (at == std::string::npos) throw std::runtime_error("no " + what + " after " + section);
  return at;
}

}  // namespace

std::string Replace(std::string text, const std::string& section, const std::string& from,
                    const std::string& to) {
  return text.replace(Find(text, section, from), from.size(), to);
}

int LineOf(const std::string& text, const std::string& section, const std::string& what) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(Find(text, section, what));
  return 1 + static_cast<int>(std::count(text.begin(), end, '\n'));
}

}  // namespace gyrobench::config
