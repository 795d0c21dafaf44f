#include "calibration/artefact/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "base/error.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;
using testing::HasSubstr;

ModelTerm TermOwned(const std::string& id, EffectOwner owner, std::vector<double> coefficients,
                    std::vector<double> nonlinear = {}) {
  ModelTerm term;
  term.id = id;
  term.owner = owner;
  term.coefficients = std::move(coefficients);
  term.nonlinear = std::move(nonlinear);
  return term;
}

ChannelModel FullModel() {
  ChannelModel model;
  model.axis = SensorAxis::kY;
  model.unit = "LSB";
  model.units_per_deg_s = 131.0;
  model.m_row = {0.011, 1.015, -0.007};
  model.m_row_std_error = {1e-5, 2.0 / 3.0 * 1e-5, kMissing};
  model.reference_degC = 31.25;
  model.bias_deg_s = {0.1, -1.0 / 3.0, 1e-5};
  model.terms.push_back(TermOwned("scale.temperature", EffectOwner::kGyro, {2.5e-4}));
  model.terms.back().reference_degC = 30.5;
  model.terms.back().chosen_on = ChosenOn::kTrainingPart;
  model.terms.push_back(TermOwned("bias.hysteresis", EffectOwner::kGyro, {0.02}, {2.25}));
  model.terms.back().chosen_on = ChosenOn::kAllData;
  model.terms.push_back(TermOwned("angle.eccentricity_1", EffectOwner::kReference, {0.01, 0.02}));
  model.terms.back().table_axis = 1;
  model.terms.push_back(TermOwned("bias.of(supply_v)", EffectOwner::kGyro, {0.7}));
  model.terms.back().covariate = "supply_v";
  model.terms.back().covariate_mean = 3.31;
  model.terms.push_back(TermOwned("composed(g_x*T)", EffectOwner::kGyro, {1e-3}));
  model.terms.back().origin = EffectOrigin::kComposed;
  model.terms.back().factors = {"g_x", "T"};
  model.terms.back().offsets = {0.0, 29.5};
  model.terms.push_back(TermOwned("empirical(T)", EffectOwner::kGyro, {0.1, 0.3, -0.2}));
  model.terms.back().origin = EffectOrigin::kEmpirical;
  model.terms.back().factors = {"T"};
  model.terms.back().knots = {20.0, 25.5, 40.0};
  model.parameter_names = {"M_yy", "b_0"};
  model.covariance = {1.0 / 7.0, 0.25, 0.25, kMissing};
  model.min_temperature_degC = 21.5;
  model.max_temperature_degC = 39.75;
  model.max_rate_deg_s = 41.5;
  return model;
}

Calibration FullCalibration() {
  return {"MPU-17",
          "2026-11-21T15:30:12Z",
          "0.1.0",
          {{"run.csv.gz", std::string(64, 'a'), 120000, 1200.125}},
          {{"seed", "7"}, {"false_discovery", "0.005"}},
          {{FullModel(),
            Verdict::kPartlyExplained,
            {3.5, 1.01, {0.6, 0.8}},
            {0.6, 0.1, {kMissing, 0.9}},
            {0.0035, 1.0 / 7000.0, kMissing}}}};
}

json Written() { return json::parse(ToJson(FullCalibration()).dump()); }

std::string ErrorOf(const json& value) {
  try {
    CalibrationFromJson(value, "cal.json");
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

void ExpectSame(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]))) << a[i] << " " << b[i];
  }
}

// The artefact is what firmware is made from: not one bit may be lost on the way.
TEST(CalibrationFile, GivesEveryFieldBackToTheLastBit) {
  const Calibration before = FullCalibration();
  const Calibration after = CalibrationFromJson(Written(), "cal.json");
  EXPECT_EQ(after.sensor, before.sensor);
  EXPECT_EQ(after.created, before.created);
  EXPECT_EQ(after.version, before.version);
  EXPECT_EQ(after.configuration, before.configuration);
  ASSERT_EQ(after.inputs.size(), 1u);
  EXPECT_EQ(after.inputs[0].file, "run.csv.gz");
  EXPECT_EQ(after.inputs[0].sha256, before.inputs[0].sha256);
  EXPECT_EQ(after.inputs[0].samples, 120000);
  EXPECT_EQ(after.inputs[0].duration_s, 1200.125);
  ASSERT_EQ(after.channels.size(), 1u);
  EXPECT_EQ(after.channels[0].verdict, Verdict::kPartlyExplained);
  EXPECT_EQ(after.channels[0].heldout_whitened_rms.after, 1.01);
  EXPECT_TRUE(std::isnan(after.channels[0].heldout_angle_rms_deg.reduction_ci95[0]));
  EXPECT_EQ(after.channels[0].noise.angle_random_walk_deg_sqrt_s, 0.0035);
  EXPECT_EQ(after.channels[0].noise.bias_random_walk_deg_s_sqrt_s, 1.0 / 7000.0);
  const ChannelModel &a = after.channels[0].model, &b = before.channels[0].model;
  EXPECT_EQ(a.axis, b.axis);
  EXPECT_EQ(a.unit, b.unit);
  ExpectSame({a.units_per_deg_s, a.reference_degC, a.min_temperature_degC, a.max_temperature_degC,
              a.max_rate_deg_s},
             {b.units_per_deg_s, b.reference_degC, b.min_temperature_degC, b.max_temperature_degC,
              b.max_rate_deg_s});
  ExpectSame({a.m_row.begin(), a.m_row.end()}, {b.m_row.begin(), b.m_row.end()});
  ExpectSame({a.m_row_std_error.begin(), a.m_row_std_error.end()},
             {b.m_row_std_error.begin(), b.m_row_std_error.end()});
  ExpectSame(a.bias_deg_s, b.bias_deg_s);
  EXPECT_EQ(a.parameter_names, b.parameter_names);
  ExpectSame(a.covariance, b.covariance);
}

// Nobody who goes by an effect should have to find the trace again to know what it rests on.
TEST(CalibrationFile, SaysWhatAnEffectWasChosenOnWhereThatIsKnown) {
  json written = Written();
  const auto read = [&](std::size_t term) {
    return CalibrationFromJson(written, "cal.json").channels[0].model.terms[term].chosen_on;
  };
  json& terms = written["channels"][0]["terms"];
  EXPECT_EQ(terms[0]["chosen_on"], "training_part");
  EXPECT_EQ(terms[1]["chosen_on"], "all_data");
  EXPECT_TRUE(terms[2]["chosen_on"].is_null());
  EXPECT_EQ(read(0), ChosenOn::kTrainingPart);
  EXPECT_EQ(read(1), ChosenOn::kAllData);
  EXPECT_FALSE(read(2).has_value());
  terms[0].erase("chosen_on");
  EXPECT_FALSE(read(0).has_value()) << "an older file";
  terms[0]["chosen_on"] = "some";
  EXPECT_THAT(ErrorOf(written), HasSubstr("terms[0].chosen_on"));
}

// Who corrects raw counts by the file has to know what to take off first.
TEST(CalibrationFile, SaysWhichCountStandsForZeroWhereThatIsKnown) {
  Calibration before = FullCalibration();
  EXPECT_TRUE(ToJson(before)["gyro_lsb_zero"].is_null());
  before.gyro_lsb_zero = 32768.0;
  json written = json::parse(ToJson(before).dump());
  EXPECT_EQ(CalibrationFromJson(written, "cal.json").gyro_lsb_zero, 32768.0);
  written["gyro_lsb_zero"] = "half";
  EXPECT_THAT(ErrorOf(written), HasSubstr("gyro_lsb_zero: expected a number"));
  written.erase("gyro_lsb_zero");
  EXPECT_FALSE(CalibrationFromJson(written, "cal.json").gyro_lsb_zero.has_value());
}

// Older files have no such key, and stay readable.
TEST(CalibrationFile, GivesTheThreeAxesBackWhereTheyAreThere) {
  EXPECT_FALSE(CalibrationFromJson(Written(), "cal.json").vector);
  Calibration before = FullCalibration();
  before.vector.emplace().missing = {"gyro x was not traced"};
  before.vector->matrix.emplace().m[1] = {1.0 / 3.0, kMissing, 1.0};
  before.vector->matrix->m_covariance.assign(81, 1.0 / 7.0);
  before.vector->matrix->a_covariance.assign(81, kMissing);
  const json written = json::parse(ToJson(before).dump());
  EXPECT_EQ(ToJson(CalibrationFromJson(written, "cal.json")), written);
  json damaged = written;
  damaged["vector"]["matrix"].erase("a");
  EXPECT_THAT(ErrorOf(damaged), HasSubstr("vector.matrix: the key \"a\" is missing"));
}

TEST(CalibrationFile, GivesEveryTermBackToTheLastBit) {
  const Calibration before = FullCalibration();
  const Calibration after = CalibrationFromJson(Written(), "cal.json");
  const auto &a = after.channels[0].model.terms, &b = before.channels[0].model.terms;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].origin, b[i].origin);
    EXPECT_EQ(a[i].owner, b[i].owner);
    EXPECT_EQ(a[i].table_axis, b[i].table_axis);
    EXPECT_EQ(a[i].covariate, b[i].covariate);
    EXPECT_EQ(a[i].factors, b[i].factors);
    ExpectSame(a[i].coefficients, b[i].coefficients);
    ExpectSame(a[i].nonlinear, b[i].nonlinear);
    ExpectSame(a[i].offsets, b[i].offsets);
    ExpectSame(a[i].knots, b[i].knots);
    ExpectSame({a[i].reference_degC, a[i].covariate_mean},
               {b[i].reference_degC, b[i].covariate_mean});
  }
}

TEST(CalibrationFile, ListsTheEffectsOfReferenceAndBenchAndSaysWhyTheyAreNotApplied) {
  const json written = Written();
  const json& terms = written["channels"][0]["terms"];
  EXPECT_EQ(terms[0]["applied"], true);
  EXPECT_EQ(terms[0]["because"], "");
  EXPECT_EQ(terms[2]["owner"], "reference");
  EXPECT_EQ(terms[2]["applied"], false);
  EXPECT_THAT(terms[2]["because"].get<std::string>(), HasSubstr("reference"));
}

TEST(CalibrationFile, EventsOfOneRunAndLagsAreNoPartOfACorrection) {
  using enum EffectOwner;
  EXPECT_NE(WhyNotApplied(TermOwned("bias.step", kGyro, {0.1}, {30.0})), "");
  EXPECT_NE(WhyNotApplied(TermOwned("bias.tone", kGyro, {0.1, 0.1}, {0.2})), "");
  EXPECT_NE(WhyNotApplied(TermOwned("bandwidth.first_order", kGyro, {0.01}, {})), "");
  EXPECT_NE(WhyNotApplied(TermOwned("bias.earth_rate", kGyro, {0.0, 0.0, 0.0})), "");
  EXPECT_NE(WhyNotApplied(TermOwned("angle.latency", kBench, {0.01})), "");
  EXPECT_EQ(WhyNotApplied(TermOwned("bias.g_linear", kGyro, {0.0, 0.0, 0.0})), "");
}

struct Damage {
  const char* name;
  const char* pointer;  // what is replaced
  json value;           // removed where it is discarded
  std::vector<std::string> says;
};

class DamagedCalibration : public testing::TestWithParam<Damage> {};

TEST_P(DamagedCalibration, IsRefusedWithFileKeyAndWhatWasExpected) {
  json value = Written();
  const json::json_pointer pointer(GetParam().pointer);
  if (GetParam().value.is_discarded()) {
    value[pointer.parent_pointer()].erase(pointer.back());
  } else {
    value[pointer] = GetParam().value;
  }
  const std::string error = ErrorOf(value);
  EXPECT_THAT(error, HasSubstr("cal.json: "));
  for (const std::string& word : GetParam().says) EXPECT_THAT(error, HasSubstr(word));
}

const json kRemoved = json(json::value_t::discarded);

INSTANTIATE_TEST_SUITE_P(
    All, DamagedCalibration,
    testing::Values(
        Damage{"of_another_version",
               "/format",
               "gyrobench.calibration/2",
               {"another version", "gyrobench.calibration/1"}},
        Damage{"of_another_kind",
               "/format",
               "gyrobench.trace/1",
               {"no calibration", "gyrobench.trace/1"}},
        Damage{"without_format", "/format", kRemoved, {"no calibration", "no such key"}},
        Damage{"without_channels", "/channels", json::array(), {"channels", "at least one"}},
        Damage{"with_a_missing_key",
               "/channels/0/m_row",
               kRemoved,
               {"channels[0]", "\"m_row\" is missing"}},
        Damage{"with_an_unknown_key", "/channels/0/magic", 1, {"channels[0]", "magic"}},
        Damage{"with_text_for_a_number",
               "/channels/0/m_row/1",
               "one",
               {"channels[0].m_row[1]", "a number", "\"one\""}},
        Damage{"with_null_where_a_number_is_needed",
               "/channels/0/bias/coefficients_deg_s/0",
               nullptr,
               {"channels[0].bias.coefficients_deg_s[0]", "null"}},
        Damage{"with_a_short_row", "/channels/0/m_row", {1.0}, {"m_row", "3 numbers"}},
        Damage{"with_no_sensitivity", "/channels/0/units_per_deg_s", 0, {"above 0"}},
        Damage{"with_an_unknown_axis", "/channels/0/gyro", "w", {"gyro", "x, y, z"}},
        Damage{"with_an_unknown_effect",
               "/channels/0/terms/0/id",
               "scale.magic",
               {"terms[0].id", "scale.magic", "catalogue"}},
        Damage{"with_too_few_coefficients",
               "/channels/0/terms/2/coefficients",
               {0.1},
               {"terms[2].coefficients", "2 numbers"}},
        Damage{"with_an_effect_passed_off_as_applied",
               "/channels/0/terms/2/applied",
               true,
               {"terms[2].applied", "reference"}},
        Damage{"with_knots_that_do_not_grow",
               "/channels/0/terms/5/knots",
               {20.0, 20.0, 40.0},
               {"terms[5].knots", "grow"}},
        Damage{"with_a_covariance_of_another_size",
               "/channels/0/covariance",
               {{1.0}},
               {"covariance", "2 rows"}},
        Damage{"with_a_bias_without_its_temperature",
               "/channels/0/bias/reference_degC",
               nullptr,
               {"reference_degC", "temperature"}},
        Damage{"with_a_negative_count", "/inputs/0/samples", -1, {"inputs[0].samples", "count"}}),
    [](const auto& tested) { return std::string(tested.param.name); });

// Calibrations outlive versions: the noise came later than the format.
TEST(CalibrationFile, WithoutTheNoiseIsReadWithANoiseThatIsNotKnown) {
  json value = Written();
  value["channels"][0].erase("noise");
  const Calibration calibration = CalibrationFromJson(value, "cal.json");
  EXPECT_TRUE(std::isnan(calibration.channels[0].noise.angle_random_walk_deg_sqrt_s));
  value["channels"][0]["noise"] = {{"angle_random_walk_deg_sqrt_s", 1.0}};
  EXPECT_THAT(ErrorOf(value), HasSubstr("channels[0].noise: the key"));
}

TEST(CalibrationFile, IsNoListAndHoldsNoAxisTwice) {
  EXPECT_THAT(ErrorOf(json::array()), HasSubstr("no calibration"));
  json value = Written();
  value["channels"].push_back(value["channels"][0]);
  EXPECT_THAT(ErrorOf(value), HasSubstr("twice"));
}

// What is read from a disk may be anything; it is refused, or it is what it says.
TEST(CalibrationFile, WithAnyBytesChangedIsReadOrRefusedAndNothingElse) {
  const std::string whole = ToJson(FullCalibration()).dump();
  std::mt19937_64 random(3);
  int read = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = whole;
    for (int changes = 0; changes < 1 + i % 3; ++changes)
      text[random() % text.size()] = "0123456789.,:-[]{}\"enul"[random() % 24];
    const json value = json::parse(text, nullptr, false);
    if (value.is_discarded()) continue;
    ++(ErrorOf(value).empty() ? read : refused);
  }
  EXPECT_GT(read, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace gyrobench::calibration
