#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config/stand_config.h"
#include "config/toml_reader.h"
#include "tests/config/config_files.h"

namespace gyrobench::config {
namespace {

using nlohmann::json;

// Whether the record has the dotted key of a file.
bool Contains(const json& object, const std::string& dotted) {
  std::string pointer = "/" + dotted;
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return object.contains(json::json_pointer(pointer));
}

// A key that a stand file may have and the record forgot would show here. Of the simulation the
// record says only that there was one.
TEST(StandConfigJson, HoldsEveryRequiredOrDefaultedKeyOfAStandFile) {
  const auto file = ConfigFolder() / "relays.toml";
  const auto root = TomlTable::FromFile(file);
  const json record = ToJson(ReadStandConfig(root, file));
  for (const KnownKey& key : root.KnownKeys()) {
    if (key.fallback == "optional" || key.name.starts_with("virtual.")) continue;
    EXPECT_TRUE(Contains(record, key.name)) << key.name;
  }
}

template <typename Map>
void ExpectMapInRecord(Map (*read)(const TomlTable&), const char* file, const json& map) {
  const auto root = TomlTable::FromFile(ConfigFolder() / "devices" / file);
  read(root);
  for (const KnownKey& key : root.KnownKeys()) EXPECT_TRUE(map.contains(key.name)) << key.name;
}

TEST(StandConfigJson, HoldsEveryKeyOfTheDeviceMaps) {
  const json record = ToJson(LoadStandConfig(ConfigFolder() / "stand.toml"));
  const json& inner = record["axis"]["inner"];
  ExpectMapInRecord(ReadDriveMap, "leadshine-rs.toml", inner["drive"]["map"]);
  ExpectMapInRecord(ReadEncoderMap, "briter-encoder.toml", inner["encoder"]["map"]);
  ExpectMapInRecord(ReadGyroUnitMap, "gyro-unit.toml", record["gyro"]["map"]);
}

TEST(StandConfigJson, KeepsValuesUnderTheirOwnKeys) {
  StandConfig stand = LoadStandConfig(ConfigFolder() / "stand.toml");
  stand.site.latitude_deg = 12.5;
  stand.reference = {0.0001, 0.02, 0.3};
  stand.gyro.serial_number = 77;
  stand.axes[1].min_deg = -11;
  stand.axes[1].max_deg = 22;
  stand.buses[0].transport = BusConfig::Transport::kTcp;
  stand.buses[0].host = "drives";
  const json record = json::parse(ToJson(stand).dump());
  EXPECT_EQ(record["site"]["latitude_deg"], 12.5);
  EXPECT_EQ(record["reference"]["scale_uncertainty"], 0.0001);
  EXPECT_EQ(record["reference"]["eccentricity_deg"], 0.02);
  EXPECT_EQ(record["reference"]["alignment_deg"], 0.3);
  EXPECT_EQ(record["gyro"]["serial_number"], 77);
  EXPECT_EQ(record["axis"]["middle"]["min_deg"], -11);
  EXPECT_EQ(record["axis"]["middle"]["max_deg"], 22);
  EXPECT_EQ(record["axis"]["outer"]["drive"]["unit"], 1);
  EXPECT_EQ(record["axis"]["outer"]["encoder"]["unit"], 11);
  EXPECT_EQ(record["bus"]["a"]["host"], "drives");
  EXPECT_FALSE(record["bus"]["a"].contains("baud"));
  EXPECT_EQ(record["gyro"]["map"]["gyro_lsb_per_deg_s"], json({131.0, 65.5, 32.8, 16.4}));
}

// An analysis that could read the truth of a simulation would prove nothing.
TEST(StandConfigJson, TellsOfASimulationOnlyThatItIsOne) {
  StandConfig stand = LoadStandConfig(ConfigFolder() / "virtual.toml");
  ASSERT_TRUE(stand.virtual_stand);
  stand.virtual_stand->seed = 918273645;
  stand.virtual_stand->scenario = "secret-scenario.toml";
  stand.virtual_stand->answers = {{"cool", "secret-answer"}};
  const json record = ToJson(stand);
  EXPECT_EQ(record["virtual"], true);
  EXPECT_THAT(record.dump(), testing::Not(testing::HasSubstr("secret")));
  EXPECT_THAT(record.dump(), testing::Not(testing::HasSubstr("918273645")));
  EXPECT_EQ(ToJson(LoadStandConfig(ConfigFolder() / "stand.toml"))["virtual"], false);
}

}  // namespace
}  // namespace gyrobench::config
