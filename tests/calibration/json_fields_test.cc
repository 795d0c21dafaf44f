// Laws of all JSON that is written and read from a list of fields.
#include "base/json_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "calibration/artefact/calibration_fields.h"
#include "calibration/artefact/trace_fields.h"
#include "calibration/estimators/result_fields.h"
#include "calibration/hold/hold_fields.h"
#include "tests/calibration/distinct_fields.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;
using testing::HasSubstr;

template <typename T>
T Distinct() {
  T value;
  DistinctFields().Fill(value);
  return value;
}

// The fields of a calibration have to fit together.
template <>
Calibration Distinct<Calibration>() {
  Calibration calibration;
  DistinctFields().Fill(calibration);
  calibration.channels[0].model.axis = SensorAxis::kX;
  calibration.channels[1].model.axis = SensorAxis::kZ;
  for (ChannelCalibration& channel : calibration.channels) {
    ModelTerm &step = channel.model.terms[0], &composed = channel.model.terms[1];
    step.id = "bias.step";
    step.origin = EffectOrigin::kCatalogue;
    step.coefficients.resize(1);
    step.nonlinear.resize(1);
    composed.origin = EffectOrigin::kComposed;
    composed.coefficients.resize(1);
  }
  return calibration;
}

// Where something is missing, nothing else is known.
template <>
HoldResult Distinct<HoldResult>() {
  HoldResult result;
  DistinctFields().Fill(result);
  result.missing.clear();
  return result;
}

// Of what a value is where nothing is known.
template <typename T>
T Nothing() {
  return {};
}
template <>
HoldResult Nothing<HoldResult>() {
  HoldResult result;
  result.missing = {"too few poses"};
  return result;
}
template <>
Calibration Nothing<Calibration>() {
  Calibration calibration;
  calibration.channels.emplace_back();
  return calibration;
}

template <typename T>
std::string ErrorOf(const json& value) {
  const std::string file = "a.json";
  try {
    ReadFields<T>(Place(value, file));
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

template <typename T>
json ReadAndWritten(const json& value) {
  const std::string file = "a.json";
  return WriteFields(ReadFields<T>(Place(value, file)));
}

// "/channels/0/terms" as messages have it: "channels[0].terms".
std::string PathOf(const json::json_pointer& pointer) {
  if (pointer.empty()) return "";
  const std::string before = PathOf(pointer.parent_pointer());
  const std::string& last = pointer.back();
  if (last.find_first_not_of("0123456789") == std::string::npos) return before + "[" + last + "]";
  return before + (before.empty() ? "" : ".") + last;
}

// All places within a value, itself first.
std::vector<json::json_pointer> PlacesIn(const json& value,
                                         const json::json_pointer& here = json::json_pointer()) {
  std::vector<json::json_pointer> places = {here};
  const auto add = [&places](const std::vector<json::json_pointer>& more) {
    places.insert(places.end(), more.begin(), more.end());
  };
  if (value.is_object()) {
    for (const auto& [key, one] : value.items()) add(PlacesIn(one, here / key));
  } else if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) add(PlacesIn(value[i], here / i));
  }
  return places;
}

template <typename T>
class JsonOf : public testing::Test {
 protected:
  const json written_ = json::parse(WriteFields(Distinct<T>()).dump());
};

using Formats =
    testing::Types<AnalysisResult, TraceResult, VectorCalibration, HoldResult, Calibration>;
TYPED_TEST_SUITE(JsonOf, Formats);

TYPED_TEST(JsonOf, GivesEveryFieldBackToTheLastBit) {
  EXPECT_EQ(ReadAndWritten<TypeParam>(this->written_), this->written_);
}

TYPED_TEST(JsonOf, HasNoNumberUnderTwoKeysAndNothingThatIsEmpty) {
  std::set<double> numbers;
  for (const json::json_pointer& place : PlacesIn(this->written_)) {
    const json& value = this->written_[place];
    EXPECT_FALSE(value.is_null()) << place;
    const bool empty = value.is_structured() && value.empty();
    EXPECT_TRUE(!empty || place.to_string() == "/missing") << place;
    if (!value.is_number()) continue;
    EXPECT_TRUE(numbers.insert(value.get<double>()).second) << place;
  }
  EXPECT_GT(numbers.size(), 20U);
}

TYPED_TEST(JsonOf, WritesWhatIsNotKnownAsNullAndReadsItAsNotKnown) {
  const json nothing = WriteFields(Nothing<TypeParam>());
  EXPECT_EQ(ReadAndWritten<TypeParam>(nothing), nothing);
}

TYPED_TEST(JsonOf, IsRefusedWithAValueOfAnotherKindAtItsPlace) {
  for (const json::json_pointer& place : PlacesIn(this->written_)) {
    json damaged = this->written_;
    damaged[place] = damaged[place].is_object() ? json("text") : json({{"no", "such"}});
    const std::string error = ErrorOf<TypeParam>(damaged);
    // What the model's equation says is for people.
    if (place.to_string() == "/model") continue;
    EXPECT_THAT(error, testing::StartsWith("a.json: " + PathOf(place)));
  }
}

TYPED_TEST(JsonOf, IsRefusedWithAKeyThatNobodyKnows) {
  for (const json::json_pointer& place : PlacesIn(this->written_)) {
    json damaged = this->written_;
    const std::string name = place.empty() ? "" : place.back();
    if (!damaged[place].is_object() || name == "configuration" || name == "notes") continue;
    damaged[place]["magic"] = 1;
    EXPECT_THAT(ErrorOf<TypeParam>(damaged), HasSubstr("unknown key \"magic\"; expected "));
  }
}

// Those that came later than the format (docs/calibration.md), or that not all of a kind have.
TYPED_TEST(JsonOf, IsRefusedWithoutAKeyUnlessThatCameLater) {
  const std::set<std::string> later = {"because",
                                       "chosen_on",
                                       "noise",
                                       "vector",
                                       "gyro_lsb_zero",
                                       "offset_groups",
                                       "offset_scatter",
                                       "noise_of_rests",
                                       "m_statistical_std_error",
                                       "a_statistical_std_error"};
  for (const json::json_pointer& place : PlacesIn(this->written_)) {
    if (place.empty() || !this->written_[place.parent_pointer()].is_object()) continue;
    const std::string& key = place.back();
    json damaged = this->written_;
    damaged[place.parent_pointer()].erase(key);
    const std::string error = ErrorOf<TypeParam>(damaged);
    if (error.empty()) {
      const bool came_later = later.contains(key) ||
                              place.to_string().ends_with("/g_sensitivity/statistical_std_error");
      EXPECT_TRUE(came_later || key == "key") << place;
    } else {
      EXPECT_THAT(error, HasSubstr("the key \"" + key + "\" is missing"));
    }
  }
}

}  // namespace
}  // namespace gyrobench::calibration
