// docs/configuration.md says of every key what the reader says.
#include <gmock/gmock.h>

#include <map>
#include <regex>
#include <sstream>
#include <tuple>

#include "config/stand_config.h"
#include "config/toml_reader.h"
#include "tests/config/config_files.h"

namespace gyrobench::config {
namespace {

struct Row {
  std::string expected;
  std::string fallback;
  std::string meaning;
};

std::string Strip(const std::string& cell) {
  const auto begin = cell.find_first_not_of(" `");
  const auto end = cell.find_last_not_of(" `");
  return begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1);
}

// Rows `| key | expected | without it | meaning |` of the page, by section.
std::map<std::string, Row> Page(const std::string& section) {
  const auto lines = SplitLines(ReadText(ConfigFolder().parent_path() / "docs/configuration.md"));
  std::map<std::string, Row> rows;
  std::string now;
  for (const std::string& line : lines) {
    if (line.starts_with("# ") || line.starts_with("## ")) now = line;
    if (!line.starts_with("| `") || now != "## " + section) continue;
    std::vector<std::string> cells;
    std::istringstream in(line.substr(1));
    for (std::string cell; std::getline(in, cell, '|');) cells.push_back(Strip(cell));
    cells.resize(4);
    rows[cells[0]] = {cells[1], cells[2], cells[3]};
  }
  return rows;
}

// One row stands for all axes, all buses and all answers.
std::string Generic(std::string text) {
  text = std::regex_replace(text, std::regex("axis\\.(outer|middle|inner)"), "axis.NAME");
  return std::regex_replace(text, std::regex("bus\\.\\w+"), "bus.NAME");
}

void ExpectDocumented(const std::vector<KnownKey>& keys, const std::string& section) {
  const auto rows = Page(section);
  std::map<std::string, bool> known;
  for (const KnownKey& key : keys) {
    const std::string name = Generic(key.name);
    known[name] = true;
    const auto row = rows.find(name);
    ASSERT_NE(row, rows.end()) << "docs/configuration.md, " << section << ": no row for " << name
                               << " | " << Generic(key.expected) << " | " << key.fallback;
    EXPECT_EQ(row->second.expected, Generic(key.expected)) << name;
    EXPECT_EQ(row->second.fallback, key.fallback) << name;
    EXPECT_GT(row->second.meaning.size(), 4u) << name;
  }
  for (const auto& [name, row] : rows) EXPECT_TRUE(known.contains(name)) << name << " is no key";
}

TEST(Documentation, HasARowForEveryKeyOfAStandFile) {
  const TestFolder folder;
  folder.CopyConfig();
  std::vector<KnownKey> keys;
  for (const char* text :
       {"include = \"relays.toml\"\n",
        "include = \"one-axis.toml\"\n[bus.c]\ntransport = \"tcp\"\nhost = \"h\"\n"}) {
    const auto file = folder.Write("all.toml", text);
    const auto root = TomlTable::FromFile(file);
    ReadStandConfig(root, file);
    for (const KnownKey& key : root.KnownKeys()) {
      // The names that a user gives are no keys of the reader.
      const bool given = key.name.starts_with("virtual.answers.");
      const bool table = key.expected.starts_with("a table");
      if (!given && !table) keys.push_back(key);
    }
  }
  ExpectDocumented(keys, "Stand file");
}

std::string OneLine(const std::string& text) {
  return std::regex_replace(text, std::regex("\\s+"), " ");
}

// The page shows what a user will see.
TEST(Documentation, ShowsErrorsAsTheyAre) {
  const auto page = OneLine(ReadText(ConfigFolder().parent_path() / "docs/configuration.md"));
  const auto stand = ReadText(ConfigFolder() / "stand.toml");
  const TestFolder folder;
  folder.CopyConfig();
  for (const auto& [section, from, to] :
       {std::tuple{"[axis.outer]", "max_rate_deg_s = 60", "max_rate_deg_s = -5"},
        std::tuple{"[axis.outer]", "max_rate_deg_s = 60", "max_rate = 60"},
        std::tuple{"[axis.outer.drive]", "unit = 1\n", "\n"},
        std::tuple{"[bus.a]", "baud = 115200", "baud = 9600"}}) {
    const auto file = folder.Write("stand.toml", Replace(stand, section, from, to));
    const std::string error = ErrorOf([&] { LoadStandConfig(file); });
    ASSERT_THAT(error, testing::StartsWith(folder.path().string()));
    const std::string shown = error.substr(folder.path().string().size() + 1);
    EXPECT_THAT(page, testing::HasSubstr(OneLine(shown)));
  }
}

template <typename Map>
std::vector<KnownKey> KeysOfMap(Map (*read)(const TomlTable&), const char* file) {
  const auto root = TomlTable::FromFile(ConfigFolder() / "devices" / file);
  read(root);
  return root.KnownKeys();
}

TEST(Documentation, HasARowForEveryKeyOfADeviceMap) {
  ExpectDocumented(KeysOfMap(ReadDriveMap, "leadshine-rs.toml"), "Drive map");
  ExpectDocumented(KeysOfMap(ReadEncoderMap, "briter-encoder.toml"), "Encoder map");
  ExpectDocumented(KeysOfMap(ReadGyroUnitMap, "gyro-unit.toml"), "Gyro unit map");
  ExpectDocumented(KeysOfMap(ReadRelayMap, "relay-unit.toml"), "Relay map");
}

}  // namespace
}  // namespace gyrobench::config
