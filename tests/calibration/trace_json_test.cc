#include "calibration/artefact/trace_json.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

TraceResult FullTrace() {
  TraceResult result;
  result.inputs = {{"run.csv", 1200, 12.5, {{"repeated_time", 3, 1.5, "line 7"}}}};
  ChannelTrace channel;
  channel.axis = SensorAxis::kX;
  channel.verdict = Verdict::kPartlyExplained;
  channel.baseline.parameters = {{"M_xx", 1.01, "1", 1e-4, 0.9e-4}};
  channel.baseline.whitened_rms = 4.0;
  channel.baseline.angle_rms_deg = 0.5;
  TracedEffect effect;
  effect.id = "angle.latency";
  effect.owner = EffectOwner::kBench;
  effect.equation = "-tau w";
  effect.parameters = {{"tau", 0.003, "s", 1e-5, 1e-5}};
  effect.p_value = 1e-9;
  effect.rivals = {"angle.clock_drift"};
  effect.settled_by = "repeat a motion after 30 min";
  effect.heldout_whitened_rms = {4.0, 1.0, {0.7, 0.8}};
  effect.heldout_angle_rms_deg = {0.5, 0.1, {0.6, 0.9}};
  channel.effects = {effect};
  channel.unidentifiable = {{"scale.g", "one pose only", "turn upside down"}};
  channel.remaining = {false, {{"covariate", "temp_degC", 1e-4, "a jump at 30 degC"}}};
  channel.noise = {0.0035, 1e-4, 0.005};
  result.channels = {channel};
  return result;
}

void ExpectKeys(const json& object, std::initializer_list<const char*> keys) {
  for (const char* key : keys) EXPECT_TRUE(object.contains(key)) << key << " in " << object.dump();
}

// Every key of `before` is in `now` as well; of lists the first entries are compared.
void ExpectAllKeysOf(const json& before, const json& now, const std::string& path) {
  if (before.is_array() && now.is_array() && !before.empty() && !now.empty())
    return ExpectAllKeysOf(before[0], now[0], path + "[0]");
  if (!before.is_object() || !now.is_object()) return;
  for (const auto& [key, value] : before.items()) {
    if (now.contains(key)) {
      ExpectAllKeysOf(value, now[key], path + "." + key);
    } else {
      ADD_FAILURE() << path << "." << key << " was in trace.json of version 1";
    }
  }
}

TEST(TraceJson, HoldsEveryKeyThatAnEarlierProgramWrote) {
  std::ifstream file(std::string(GYROBENCH_SOURCE_DIR) + "/tests/compatibility/trace-1.json");
  const json before = json::parse(file);
  ASSERT_FALSE(before["channels"][0]["effects"].empty());
  ExpectAllKeysOf(before, ToJson(FullTrace()), "trace");
}

// The format that other programs read; fields may be added to it, none may go.
TEST(TraceJson, HoldsEveryKeyOfTheFormat) {
  const json trace = ToJson(FullTrace());
  EXPECT_EQ(trace["format"], "gyrobench.trace/1");
  ExpectKeys(trace["vector"], {"missing", "unit", "matrix", "split", "g_sensitivity", "shared",
                               "accelerometer", "remarks"});
  ExpectKeys(trace["inputs"][0], {"file", "samples", "duration_s", "defects"});
  ExpectKeys(trace["inputs"][0]["defects"][0], {"kind", "count", "first_t_s"});
  const json& channel = trace["channels"][0];
  ExpectKeys(channel,
             {"gyro", "verdict", "baseline", "effects", "unidentifiable", "remaining", "noise"});
  ExpectKeys(channel["baseline"],
             {"parameters", "reference_degC", "whitened_rms", "angle_rms_deg"});
  ExpectKeys(channel["baseline"]["parameters"][0], {"name", "value", "unit", "std_error"});
  ExpectKeys(channel["effects"][0],
             {"id", "origin", "equation", "parameters", "p_value", "rivals", "settled_by",
              "heldout_whitened_rms", "heldout_angle_rms_deg"});
  ExpectKeys(channel["effects"][0]["heldout_whitened_rms"], {"before", "after"});
  ExpectKeys(channel["effects"][0]["heldout_angle_rms_deg"], {"before", "after", "reduction_ci95"});
  ExpectKeys(channel["unidentifiable"][0], {"id", "because"});
  ExpectKeys(channel["remaining"], {"white", "findings"});
  ExpectKeys(channel["remaining"]["findings"][0], {"test", "covariate", "p_value", "says"});
  ExpectKeys(channel["noise"],
             {"angle_random_walk_deg_sqrt_s", "bias_random_walk_deg_s_sqrt_s", "reference_deg"});
}

TEST(TraceJson, PutsEveryValueWhereItBelongs) {
  const json channel = ToJson(FullTrace())["channels"][0];
  EXPECT_EQ(channel["gyro"], "x");
  EXPECT_EQ(channel["verdict"], "partly_explained");
  EXPECT_EQ(channel["effects"][0]["origin"], "catalogue");
  EXPECT_EQ(channel["effects"][0]["owner"], "bench");
  EXPECT_EQ(channel["effects"][0]["rivals"], json({"angle.clock_drift"}));
  EXPECT_EQ(channel["effects"][0]["heldout_angle_rms_deg"]["reduction_ci95"], json({0.6, 0.9}));
  EXPECT_EQ(channel["remaining"]["white"], false);
}

TEST(TraceJson, WritesWhatIsNotANumberAsNull) {
  TraceResult result;
  result.inputs = {{"empty.csv", 0, kMissing, {}}};
  result.channels.resize(1);
  const json trace = json::parse(ToJson(result).dump());
  EXPECT_TRUE(trace["inputs"][0]["duration_s"].is_null());
  EXPECT_TRUE(trace["channels"][0]["baseline"]["whitened_rms"].is_null());
  EXPECT_TRUE(trace["channels"][0]["noise"]["reference_deg"].is_null());
  EXPECT_TRUE(trace["channels"][0]["effects"].is_array());
}

}  // namespace
}  // namespace gyrobench::calibration
