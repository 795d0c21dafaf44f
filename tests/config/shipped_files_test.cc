// The files that come with gyrobench: all load, and no damage to them does worse than a
// ConfigError.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

#include "config/scenario.h"
#include "config/stand_config.h"
#include "config/toml_reader.h"
#include "tests/config/config_files.h"

namespace gyrobench::config {
namespace {

namespace fs = std::filesystem;

struct Shipped {
  fs::path name;  // below config/
  std::function<void(const fs::path&)> load;
};

std::function<void(const fs::path&)> LoaderOf(const fs::path& name) {
  if (name.parent_path() == "scenarios") return LoadScenario;
  if (name.parent_path() != "devices") return LoadStandConfig;
  const auto kind = TomlTable::FromFile(ConfigFolder() / name).String("kind");
  if (kind == "drive") return LoadDriveMap;
  if (kind == "encoder") return LoadEncoderMap;
  if (kind == "relays") return LoadRelayMap;
  return LoadGyroUnitMap;
}

std::vector<Shipped> ShippedFiles() {
  std::vector<Shipped> files;
  for (const auto& entry : fs::recursive_directory_iterator(ConfigFolder())) {
    if (entry.path().extension() != ".toml") continue;
    const fs::path name = fs::relative(entry.path(), ConfigFolder());
    files.push_back({name, LoaderOf(name)});
  }
  return files;
}

TEST(ShippedFiles, AreThereAndLoad) {
  const auto files = ShippedFiles();
  EXPECT_GE(files.size(), 8u);
  for (const Shipped& file : files) {
    EXPECT_NO_THROW(file.load(ConfigFolder() / file.name)) << file.name;
  }
}

TEST(ShippedFiles, HaveNoSimulationInTheFileForHardware) {
  EXPECT_FALSE(LoadStandConfig(ConfigFolder() / "stand.toml").virtual_stand);
  EXPECT_TRUE(LoadStandConfig(ConfigFolder() / "virtual.toml").virtual_stand);
  EXPECT_TRUE(LoadStandConfig(ConfigFolder() / "one-axis.toml").virtual_stand);
}

// The simulation stands in for the hardware only if nothing of the bench differs between the two.
TEST(ShippedFiles, GiveTheVirtualStandTheDevicesOfTheStandOfRecord) {
  const StandConfig real = LoadStandConfig(ConfigFolder() / "stand.toml");
  const StandConfig simulated = LoadStandConfig(ConfigFolder() / "virtual.toml");
  ASSERT_EQ(real.axes.size(), 3u);
  ASSERT_EQ(simulated.axes.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const int unit = static_cast<int>(i) + 1;
    for (const StandConfig* stand : {&real, &simulated}) {
      EXPECT_EQ(stand->axes[i].drive.unit, unit);
      EXPECT_EQ(stand->axes[i].encoder.unit, unit + 10);
      EXPECT_EQ(stand->axes[i].drive.bus, "a");
      EXPECT_EQ(stand->axes[i].encoder.bus, "a");
      EXPECT_EQ(stand->axes[i].gear_ratio, 40);
    }
  }
  EXPECT_EQ(real.gyro.unit, 21);
  EXPECT_EQ(simulated.gyro.unit, 21);
  EXPECT_EQ(simulated.gyro.bus, "b");
}

// Loads, or says what is wrong with the file; nothing else, and it names the file.
void ExpectLoadsOrConfigError(const Shipped& file, const TestFolder& folder,
                              const std::string& text, const std::string& damage) {
  const fs::path path = folder.Write(file.name, text);
  try {
    const std::string error = ErrorOf([&] { file.load(path); });
    if (error.empty()) return;
    EXPECT_THAT(error, testing::HasSubstr(".toml")) << file.name << ": " << damage;
  } catch (const std::exception& error) {
    FAIL() << file.name << ": " << damage << ": " << error.what();
  }
}

// Ways in which a line gets damaged.
std::vector<std::string> Damages(const std::string& line) {
  const std::string key = line.substr(0, line.find('='));
  std::vector<std::string> damages = {line.substr(0, line.size() / 2),
                                      line + "]",
                                      "\"" + line,
                                      "[" + line,
                                      line + "\n" + line,
                                      std::string(line.rbegin(), line.rend()),
                                      "\xff\xfe" + line};
  for (const char* value : {"nan", "-inf", "0", "-1", "1e308", "9223372036854775807", "\"\"",
                            "\"../..\"", "[]", "[[]]", "{}", "true", "1979-05-27"}) {
    damages.push_back(key + "= " + value);
  }
  return damages;
}

TEST(ShippedFiles, LoadOrNameTheErrorWithAnyLineDeleted) {
  const TestFolder folder;
  folder.CopyConfig();
  for (const Shipped& file : ShippedFiles()) {
    const std::string text = ReadText(ConfigFolder() / file.name);
    const auto lines = SplitLines(text);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      auto damaged = lines;
      damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(i));
      ExpectLoadsOrConfigError(file, folder, JoinLines(damaged), fmt::format("no line {}", i + 1));
    }
    folder.Write(file.name, text);
  }
}

TEST(ShippedFiles, LoadOrNameTheErrorWithAnyLineDamaged) {
  const TestFolder folder;
  folder.CopyConfig();
  for (const Shipped& file : ShippedFiles()) {
    const std::string text = ReadText(ConfigFolder() / file.name);
    const auto lines = SplitLines(text);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].empty() || lines[i][0] == '#') continue;
      for (const std::string& damage : Damages(lines[i])) {
        auto damaged = lines;
        damaged[i] = damage;
        ExpectLoadsOrConfigError(file, folder, JoinLines(damaged),
                                 fmt::format("line {} = {}", i + 1, damage));
      }
    }
    folder.Write(file.name, text);
  }
}

TEST(ShippedFiles, LoadOrNameTheErrorWhenCutOffAnywhere) {
  const TestFolder folder;
  folder.CopyConfig();
  for (const Shipped& file : ShippedFiles()) {
    const std::string text = ReadText(ConfigFolder() / file.name);
    for (std::size_t size = 0; size < text.size(); size += 7) {
      ExpectLoadsOrConfigError(file, folder, text.substr(0, size), fmt::format("{} bytes", size));
    }
    folder.Write(file.name, text);
  }
}

}  // namespace
}  // namespace gyrobench::config
