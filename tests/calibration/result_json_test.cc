#include "calibration/estimators/result_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace gyrobench::calibration {
namespace {

TEST(ResultJson, WritesMissingNumbersAsNullAndTheRestToTheLastBit) {
  AnalysisResult result;
  ScaleResult scale;
  scale.alpha = 0.1 + 0.2;
  scale.axis = SensorAxis::kY;
  scale.noise.angle_random_walk_deg_sqrt_s = 1.0 / 3.0;
  result.scale.push_back(scale);
  result.defects.push_back({"gap", 3, kMissing, "gyro"});
  const nlohmann::json json = nlohmann::json::parse(ToJson(result).dump());
  EXPECT_EQ(json["scale"][0]["alpha"].get<double>(), 0.1 + 0.2);
  EXPECT_EQ(json["scale"][0]["noise"]["angle_random_walk_deg_sqrt_s"].get<double>(), 1.0 / 3.0);
  EXPECT_TRUE(json["scale"][0]["bias"].is_null());
  EXPECT_TRUE(json["defects"][0]["first_t_s"].is_null());
  EXPECT_EQ(json["scale"][0]["axis"], "y");
  EXPECT_TRUE(json["info"]["site_latitude_deg"].is_null());
}

// Every value different, so that a swap shows.
TEST(ResultJson, NamesEveryFieldOfABiasByItsOwnName) {
  BiasResult bias;
  bias.unit = "LSB";
  bias.reference_temperature_degC = 1;
  bias.min_temperature_degC = 2;
  bias.max_temperature_degC = 3;
  bias.duration_s = 4;
  bias.coefficients = {5, 6};
  bias.std_errors = {7, 8};
  bias.covariance = {{9, 10}, {11, 12}};
  bias.rms_error = 13;
  bias.residual_rms = 14;
  bias.paper_coefficients = {15};
  bias.paper_rms_error = 16;
  bias.offset_scatter = 17;
  bias.offset_groups = 18;
  AnalysisResult result;
  result.bias.push_back(bias);
  const nlohmann::json json = ToJson(result)["bias"][0];
  EXPECT_EQ(json["reference_temperature_degC"], 1);
  EXPECT_EQ(json["min_temperature_degC"], 2);
  EXPECT_EQ(json["max_temperature_degC"], 3);
  EXPECT_EQ(json["duration_s"], 4);
  EXPECT_EQ(json["coefficients"][1], 6);
  EXPECT_EQ(json["std_errors"][0], 7);
  EXPECT_EQ(json["covariance"][1][0], 11);
  EXPECT_EQ(json["rms_error"], 13);
  EXPECT_EQ(json["residual_rms"], 14);
  EXPECT_EQ(json["paper_coefficients"][0], 15);
  EXPECT_EQ(json["paper_rms_error"], 16);
  EXPECT_EQ(json["offset_scatter"], 17);
  EXPECT_EQ(json["offset_groups"], 18);
}

}  // namespace
}  // namespace gyrobench::calibration
