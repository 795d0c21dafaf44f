#include "config/scenario.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "base/error.h"

namespace gyrobench::config {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = GYROBENCH_SOURCE_DIR;

class ScenarioFile : public testing::Test {
 protected:
  ScenarioFile()
      : dir_(fs::temp_directory_path() / ("gyrobench-scenario-" + std::to_string(::getpid()))) {
    fs::create_directories(dir_);
  }
  ~ScenarioFile() override { fs::remove_all(dir_); }
  Scenario Load(const std::string& text) const {
    std::ofstream(dir_ / "test.toml") << text;
    return LoadScenario(dir_ / "test.toml");
  }
  // The error's message.
  std::string Refuse(const std::string& text) const {
    try {
      Load(text);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }

 private:
  fs::path dir_;
};

TEST_F(ScenarioFile, AnEmptyFileIsTheDefaults) {
  const Scenario scenario = Load("");
  EXPECT_EQ(scenario.gyro.angle_random_walk_deg_sqrt_s,
            Scenario{}.gyro.angle_random_walk_deg_sqrt_s);
  EXPECT_EQ(scenario.drawn.gyro_scale_rel, Scenario{}.drawn.gyro_scale_rel);
  EXPECT_EQ(scenario.name, "test");
}

TEST_F(ScenarioFile, OnTopOfAnIdealStandOneEffectIsTheOnlyOne) {
  const Scenario scenario = Load("based_on = \"ideal\"\n[gyro]\nasymmetry_rel = [0, 0, 1e-3]\n");
  EXPECT_EQ(scenario.gyro.asymmetry_rel[2], 1e-3);
  EXPECT_EQ(scenario.drawn.gyro_scale_rel, 0.0);
  EXPECT_EQ(scenario.encoder[2].noise_deg, 0.0);
}

TEST_F(ScenarioFile, AnAxisMayDifferFromWhatIsSaidOfAll) {
  const Scenario scenario =
      Load("[encoder]\nnoise_deg = 0.01\n[encoder.inner]\nnoise_deg = 0.02\nside = \"shaft\"\n");
  EXPECT_EQ(scenario.encoder[0].noise_deg, 0.01);
  EXPECT_EQ(scenario.encoder[2].noise_deg, 0.02);
  EXPECT_EQ(scenario.encoder[0].side, EncoderScenario::Side::kTable);
  EXPECT_EQ(scenario.encoder[2].side, EncoderScenario::Side::kShaft);
}

TEST_F(ScenarioFile, ListsOfEventsAreRead) {
  const Scenario scenario = Load(R"(
[[fault]]
at_s = 3
device = "inner.drive"
kind = "lost_steps"
amount = 50
[[room.fan]]
at_s = 100
duration_s = 60
[[gyro.tone]]
frequency_hz = 0.5
deg_s = [0, 0, 0.1]
[[thermal.chill]]
at_s = 500
to_degC = -20
)");
  ASSERT_EQ(scenario.faults.size(), 1U);
  EXPECT_EQ(scenario.faults[0].kind, FaultScenario::Kind::kLostSteps);
  EXPECT_TRUE(std::isinf(scenario.faults[0].duration_s));
  EXPECT_EQ(scenario.room.fans.at(0).duration_s, 60);
  EXPECT_EQ(scenario.gyro.tones.at(0).deg_s[2], 0.1);
  EXPECT_EQ(scenario.thermal.chills.at(0).to_degC, -20);
}

TEST_F(ScenarioFile, AnErrorNamesFileLineKeyValueAndRange) {
  const std::string range = Refuse("[gyro]\n\nscale_rel = [0, 0.9, 0]\n");
  for (const char* part : {"test.toml:3", "gyro.scale_rel", "0.9", "0.2"}) {
    EXPECT_NE(range.find(part), std::string::npos) << range;
  }
  EXPECT_NE(Refuse("[gyro]\nscale_rle = 0\n").find("scale_rel"), std::string::npos);
  EXPECT_NE(Refuse("[gyro]\nscale_rel = [0, 0]\n").find("3"), std::string::npos);
  EXPECT_NE(Refuse("[room]\ntemperature_degC = nan\n"), "");
}

TEST_F(ScenarioFile, AFaultOfADeviceThatNoStandHasIsRefused) {
  EXPECT_NE(Refuse("[[fault]]\nat_s = 1\ndevice = \"inner.gear\"\nkind = \"silent\"\n")
                .find("inner.encoder"),
            std::string::npos);
}

TEST_F(ScenarioFile, AFaultThatItsDeviceCannotHaveIsRefusedWithThoseThatCan) {
  const std::string message =
      Refuse("[[fault]]\ndevice = \"gyro\"\n[[fault]]\ndevice = \"gyro\"\nkind = \"jammed\"\n");
  for (const char* part : {"test.toml:5", "kind", "gyro", "drive"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
}

TEST_F(ScenarioFile, AFaultMayWaitForAMoveOrARequestAndBeLeftToChance) {
  const Scenario scenario = Load(R"(
[[fault]]
device = "gyro"
kind = "exception"
on = "move"
axis = "outer"
count = 3
probability = 0.25
)");
  const FaultScenario& fault = scenario.faults.at(0);
  EXPECT_EQ(fault.on, FaultScenario::On::kMove);
  EXPECT_EQ(fault.axis, FaultScenario::Mover::kOuter);
  EXPECT_EQ(fault.count, 3);
  EXPECT_EQ(fault.probability, 0.25);
  EXPECT_NE(Refuse("[[fault]]\ndevice = \"gyro\"\non = \"noon\"\n").find("request"),
            std::string::npos);
}

TEST_F(ScenarioFile, AScaleErrorOnTheCrossAxisDiagonalIsRefused) {
  EXPECT_NE(Refuse("[gyro]\ncross_axis_rel = [0.01, 0, 0, 0, 0, 0, 0, 0, 0]\n").find("scale_rel"),
            std::string::npos);
}

TEST(Scenarios, ThoseThatAreShippedLoad) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kSource / "config/scenarios")) {
    EXPECT_NO_THROW(LoadScenario(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 3);
  EXPECT_LT(LoadScenario(kSource / "config/scenarios/cold-start.toml").thermal.start_degC, -5.0);
}

// A new key that nobody documented is a key that nobody finds.
TEST(ScenarioKeysTest, TheReadmeOfTheStandHasEveryKeyWithUnitDefaultAndRange) {
  std::ifstream file(kSource / "stand/README.md");
  std::stringstream text;
  text << file.rdbuf();
  const std::string readme = text.str();
  for (const ScenarioKey& key : ScenarioKeys()) {
    const std::string row =
        "| `" + key.key + "` | " + key.unit + " | " + key.default_value + " | " + key.range + " |";
    EXPECT_NE(readme.find(row), std::string::npos)
        << "stand/README.md lacks: " << row << "  (gyrobench-stand --list-keys prints the table)";
  }
}

TEST(ScenarioKeysTest, EachKeyIsThereOnceAndSaysWhatItIs) {
  std::set<std::string> seen;
  for (const ScenarioKey& key : ScenarioKeys()) {
    EXPECT_TRUE(seen.insert(key.key).second) << key.key;
    EXPECT_FALSE(key.help.empty()) << key.key;
  }
  EXPECT_GT(seen.size(), 100U);
}

}  // namespace
}  // namespace gyrobench::config
