// Measurements that cannot support what is asked of them: a message that says why, or a verdict for
// what can be said; never a crash, a NaN that claims to be a number, or an effect that is not
// there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "calibration/artefact/trace_json.h"
#include "calibration/signal/intake.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::HeldOut;
using calibration::ModelParameter;
using calibration::Recording;
using calibration::Trace;
using calibration::Traced;
using calibration::TraceResult;
using calibration::Verdict;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// All that is said in words, of the measurement and of its channels.
std::string Words(const TraceResult& result) {
  std::string words;
  for (const std::string& remark : result.remarks) words += remark + "\n";
  for (const ChannelTrace& channel : result.channels) {
    words += channel.summary + "\n";
    for (const std::string& remark : channel.remarks) words += remark + "\n";
    for (const auto& effect : channel.unidentifiable) {
      words += effect.id + ": " + effect.because + "; " + effect.settled_by + "\n";
    }
  }
  return words;
}

bool IsNumber(double value) { return std::isfinite(value); }

void ExpectNumbersOrRemark(const std::vector<ModelParameter>& parameters, bool remark) {
  for (const ModelParameter& parameter : parameters) {
    EXPECT_FALSE(parameter.name.empty());
    EXPECT_TRUE(remark || IsNumber(parameter.value)) << parameter.name;
    EXPECT_FALSE(std::isinf(parameter.value)) << parameter.name;
    EXPECT_TRUE(remark || IsNumber(parameter.std_error)) << parameter.name;
    EXPECT_FALSE(parameter.std_error < 0.0) << parameter.name;
  }
}

void ExpectNumbersOrRemark(const HeldOut& held_out, bool remark) {
  EXPECT_TRUE(remark || (IsNumber(held_out.before) && IsNumber(held_out.after)));
  EXPECT_FALSE(std::isinf(held_out.before) || std::isinf(held_out.after));
}

void ExpectLawful(const ChannelTrace& channel, bool said) {
  const bool remark = said || !channel.remarks.empty();
  EXPECT_FALSE(channel.summary.empty());
  ExpectNumbersOrRemark(channel.baseline.parameters, remark);
  EXPECT_TRUE(remark || IsNumber(channel.baseline.whitened_rms));
  ExpectNumbersOrRemark(channel.heldout_whitened_rms, remark);
  for (const auto& effect : channel.effects) {
    ExpectNumbersOrRemark(effect.parameters, false);
    EXPECT_TRUE(effect.p_value >= 0.0 && effect.p_value <= 1.0) << effect.id;
  }
  const bool named =
      channel.verdict == Verdict::kExplained || channel.verdict == Verdict::kPartlyExplained;
  EXPECT_EQ(named, !channel.effects.empty());
  for (const auto& effect : channel.unidentifiable) {
    EXPECT_FALSE(effect.because.empty()) << effect.id;
    EXPECT_FALSE(effect.settled_by.empty()) << effect.id;
  }
}

void ExpectLawful(const Traced& traced) {
  const TraceResult& result = traced.result;
  EXPECT_EQ(traced.models.size(), result.channels.size());
  for (const ChannelTrace& channel : result.channels) {
    ExpectLawful(channel, !result.remarks.empty());
  }
  if (result.channels.empty()) {
    EXPECT_FALSE(result.remarks.empty()) << "no channel and no word why";
  }
  const std::string text = calibration::ToJson(result).dump();
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_TRUE(json.is_object());
  EXPECT_EQ(json.at("channels").size(), result.channels.size());
}

void ExpectNothingInvented(const Traced& traced) {
  for (const ChannelTrace& channel : traced.result.channels) {
    for (const auto& effect : channel.effects) {
      ADD_FAILURE() << "invented: " << effect.id << " (" << channel.summary << ")";
    }
  }
}

std::optional<Traced> TraceOrMessage(const std::vector<const Recording*>& recordings) {
  try {
    calibration::TraceOptions options;
    Traced traced = Trace(recordings, options);
    ExpectLawful(traced);
    ExpectNothingInvented(traced);
    return traced;
  } catch (const DataError& error) {
    EXPECT_GT(std::string(error.what()).size(), 20u) << "a message says what and why";
    return std::nullopt;
  }
}

std::optional<Traced> TraceOrMessage(const Story& story) {
  const Recording recording = story.Collect();
  return TraceOrMessage({&recording});
}

std::string MessageOf(const Story& story) {
  const Recording recording = story.Collect();
  const Recording* const list[] = {&recording};
  try {
    Trace(list);
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

void ExpectSays(const std::optional<Traced>& traced, const std::string& word) {
  ASSERT_TRUE(traced);
  EXPECT_THAT(Words(traced->result), HasSubstr(word));
}

// The story by itself, so that the tests below show what their damage does.
TEST(TraceOfASoundStory, FindsNothingAndNumbersEverything) {
  const auto traced = TraceOrMessage(Story());
  ASSERT_TRUE(traced);
  EXPECT_EQ(traced->result.channels.size(), 3u);
}

TEST(TraceOfNothing, IsAnErrorThatNamesTheFile) {
  Story story;
  story.duration_s = 0.0;
  EXPECT_THAT(MessageOf(story), HasSubstr("story.csv"));
  EXPECT_FALSE(TraceOrMessage(std::vector<const Recording*>{}));
}

TEST(TraceOfNothing, ButNotANumberIsAnErrorThatNamesTheFile) {
  Story story;
  story.spoil_gyro = [](GyroSample* sample) {
    sample->xi = {kMissing, kMissing, kMissing};
    return true;
  };
  EXPECT_THAT(MessageOf(story), HasSubstr("story.csv"));
}

TEST(TraceOfTooLittle, GivesAMessageOrAVerdictButNoEffect) {
  for (const int samples : {1, 2, 3, 5, 10, 30, 100, 400}) {
    SCOPED_TRACE(samples);
    Story story;
    story.duration_s = samples / story.gyro_hz + 1e-9;
    TraceOrMessage(story);
  }
}

TEST(TraceOfARest, SaysThatNothingMoved) {
  Story story;
  story.rate_deg_s = story.angle_deg = [](double) { return 0.0; };
  ExpectSays(TraceOrMessage(story), "scale");
}

TEST(TraceOfAStoryWithoutReference, TakesTheRestsAndNamesNoEffect) {
  Story story;
  story.info.reference = ReferenceKind::kNone;
  TraceOrMessage(story);
  story.rate_deg_s = story.angle_deg = [](double) { return 0.0; };
  TraceOrMessage(story);
}

// Who has no angle sensor is told what does without one.
TEST(TraceOfAStoryWithoutReference, PointsAtHeldPosesAndSaysWhatTheyTake) {
  Story story;
  story.info.reference = ReferenceKind::kNone;
  story.info.accel_present = {true, true, true};
  ExpectSays(TraceOrMessage(story), "there is no reference angle");
  ExpectSays(TraceOrMessage(story), "are calibrated by gyrobench hold");
  story.info.accel_present = {true, true, false};
  ExpectSays(TraceOrMessage(story), "where the table has all three axes of gyro and accelerometer");
  const auto with_reference = TraceOrMessage(Story());
  ASSERT_TRUE(with_reference);
  EXPECT_THAT(Words(with_reference->result), Not(HasSubstr("there is no reference angle")));
}

// The gyro turns, the reference says that it does not: nothing in the gyro explains that. A name by
// chance is one in a hundred: more than two of 40 come up once in 200 times.
TEST(TraceOfADeadReference, NamesNoEffectOfTheGyro) {
  int named = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Story story;
    story.seed = seed;
    story.spoil_angle = [](AngleSample* sample) {
      sample->angle_deg = 12.0;
      return true;
    };
    for (const bool of_sensor : {false, true}) {
      if (of_sensor) story.UseSensorAngle();
      const calibration::Recording recording = story.Collect();
      const calibration::Recording* const list[] = {&recording};
      calibration::TraceOptions options;
      options.curves = false;
      const TraceResult result = calibration::Trace(list, options).result;
      for (const ChannelTrace& channel : result.channels) named += !channel.effects.empty();
    }
  }
  EXPECT_LE(named, 2);
}

TEST(TraceOfALostReference, UsesWhatIsThere) {
  Story story;
  story.spoil_angle = [](AngleSample* sample) { return sample->t_s < 60 || sample->t_s > 120; };
  EXPECT_TRUE(TraceOrMessage(story));
  story.spoil_angle = [](AngleSample*) { return false; };
  TraceOrMessage(story);
}

TEST(TraceAtConstantTemperature, ListsEffectsOfTemperatureAsUnseen) {
  Story story;
  story.temperature_degC = [](double) { return 25.0; };
  ExpectSays(TraceOrMessage(story), "temperature");
}

TEST(TraceWithoutThermometer, GoesOnWithoutIt) {
  Story announced;
  announced.temperature_degC = [](double) { return kMissing; };
  EXPECT_TRUE(TraceOrMessage(announced));
  Story absent = announced;
  absent.info.temperature_present = false;
  EXPECT_TRUE(TraceOrMessage(absent));
  absent.info.accel_present = {false, false, false};
  EXPECT_TRUE(TraceOrMessage(absent));
}

TEST(TraceOfMissingAxes, TracesTheOthers) {
  Story story;
  story.info.gyro_present = {false, false, true};
  const auto one = TraceOrMessage(story);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->result.channels.size(), 1u);
  Story never;
  never.spoil_gyro = [](GyroSample* sample) {
    sample->xi[0] = kMissing;
    return true;
  };
  const auto traced = TraceOrMessage(never);
  ASSERT_TRUE(traced);
  EXPECT_THAT(Words(traced->result), HasSubstr("gyro x"));
}

TEST(TraceOfAnUnknownSensitivity, SaysSoOrFindsIt) {
  Story story;
  story.info.gyro_units_per_deg_s.reset();
  TraceOrMessage(story);
}

TEST(TraceOfAWrongSensitivity, DoesNotTakeItForAnEffect) {
  for (const double units : {1e-6, 0.131, 13.1, 1310.0, 131e6, -131.0}) {
    SCOPED_TRACE(units);
    Story story;
    story.info.gyro_units_per_deg_s = units;
    TraceOrMessage(story);
  }
}

TEST(TraceOfAWrongGearRatio, DoesNotTakeItForAnEffect) {
  for (const double ratio : {1e-9, 0.001, 1.0, 7.3, 1e9}) {
    SCOPED_TRACE(ratio);
    Story story;
    story.info.gear_ratio = ratio;
    TraceOrMessage(story);
  }
}

TEST(TraceOfAnUnknownGearRatio, SaysThatTheWormCannotBeSeen) {
  Story story;
  story.info.gear_ratio.reset();
  const std::optional<Traced> traced = TraceOrMessage(story);
  ASSERT_TRUE(traced);
  EXPECT_THAT(Words(traced->result), HasSubstr("gear between shaft and table"));
}

TEST(TraceOfIdenticalValues, IsNoMeasurement) {
  for (const double value : {0.0, 7.0, 32767.0}) {
    SCOPED_TRACE(value);
    Story story;
    story.spoil_gyro = [value](GyroSample* sample) {
      sample->xi = {value, value, value};
      sample->accel_g = {0.0, 0.0, 1.0};
      return true;
    };
    TraceOrMessage(story);
  }
}

// Whitening divides by the noise; there is none.
TEST(TraceOfPerfectData, NamesNoEffect) {
  Story story;
  story.white_deg_s = story.reading_deg = 0.0;
  TraceOrMessage(story);
  story.info.gyro_unit = RateUnit::kRadPerSecond;
  story.info.gyro_units_per_deg_s = 0.017453292519943295;
  TraceOrMessage(story);
}

TEST(TraceOfTimeThatJumps, GoesOnAfterTheJump) {
  for (const double jump_s : {10.0, 1e4, 1e9}) {
    SCOPED_TRACE(jump_s);
    Story story;
    const auto later = [jump_s](double* t_s) { *t_s += *t_s > 90.0 ? jump_s : 0.0; };
    story.spoil_gyro = [&](GyroSample* sample) {
      later(&sample->t_s);
      return true;
    };
    story.spoil_angle = [&](AngleSample* sample) {
      later(&sample->t_s);
      return true;
    };
    EXPECT_TRUE(TraceOrMessage(story));
  }
}

TEST(TraceOfWildSamples, CountsThemAndNamesNoEffect) {
  Story story;
  int number = 0;
  story.spoil_gyro = [&](GyroSample* sample) {
    if (++number % 997 == 0) sample->xi[2] = 30000.0;
    return true;
  };
  const auto traced = TraceOrMessage(story);
  ASSERT_TRUE(traced);
  std::int64_t outliers = 0;
  for (const Defect& defect : traced->result.inputs.at(0).defects) {
    if (defect.kind == "gyro_outlier") outliers += defect.count;
  }
  EXPECT_EQ(outliers, number / 997);
}

TEST(TraceOfWildReadings, NamesNoEffect) {
  for (const double reading : {kMissing, 1e6, 1e30, -1e30}) {
    SCOPED_TRACE(reading);
    Story story;
    int number = 0;
    story.spoil_angle = [&](AngleSample* sample) {
      if (++number % 499 == 0) sample->angle_deg = reading;
      return true;
    };
    TraceOrMessage(story);
  }
}

class NoQuaternion final : public PassedOn {
 public:
  using PassedOn::PassedOn;
  void OnOrientation(const OrientationSample& sample) override {
    PassedOn::OnOrientation({sample.t_s, {0.0, 0.0, 0.0, 0.0}});
  }
};

TEST(TraceOfQuaternions, ThatAreAllZeroIsLikeALostReference) {
  Story story;
  story.UseOrientation();
  EXPECT_TRUE(TraceOrMessage(story)) << "sound ones";
  calibration::Collector collector;
  NoQuaternion zero(collector);
  story.Tell(zero);
  const Recording recording = collector.Take();
  TraceOrMessage({&recording});
}

// Columns that say nothing, say the same as another, or are never there.
TEST(TraceOfUselessColumns, NamesNoneOfThem) {
  Story story;
  story.info.covariates = {"constant", "never", "time", "copy_of_t", "huge", "once"};
  story.covariates = {[](double) { return 5.0; },
                      [](double) { return kMissing; },
                      [](double t_s) { return t_s; },
                      story.temperature_degC,
                      [](double t_s) { return 1e29 * std::sin(t_s); },
                      [](double t_s) { return t_s == 60.0 ? 1.0 : kMissing; }};
  EXPECT_TRUE(TraceOrMessage(story));
}

TEST(TraceOfManyRuns, NamesTheOneThatIsEmpty) {
  Story story;
  const Recording sound = story.Collect();
  story.seed = 2;
  const Recording other = story.Collect();
  story.duration_s = 0.0;
  story.info.source = "empty.csv";
  const Recording empty = story.Collect();
  const Recording* const list[] = {&sound, &empty, &other};
  try {
    Trace(list);
    ADD_FAILURE() << "expected an error: a file without a sample was given by mistake";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("empty.csv"));
  }
  TraceOrMessage({&sound, &sound});
}

TEST(TraceOfManyRuns, OfDifferentKindsGivesAMessageOrAVerdict) {
  Story story;
  const Recording counts = story.Collect();
  story.info.gyro_unit = RateUnit::kDegPerSecond;
  story.info.gyro_units_per_deg_s = 1.0;
  const Recording degrees = story.Collect();
  TraceOrMessage({&counts, &degrees});
  Story one_axis;
  one_axis.info.gyro_present = {true, false, false};
  const Recording x_only = one_axis.Collect();
  TraceOrMessage({&counts, &x_only});
  Story turned;
  turned.UseOrientation();
  const Recording orientation = turned.Collect();
  TraceOrMessage({&counts, &orientation});
}

TEST(ATemperature, ThatNoSensorHasIsSaid) {
  const auto remarks = [](double degC) {
    Story story;
    story.temperature_degC = [degC](double t_s) { return degC + 0.01 * t_s; };
    return calibration::IntakeRemarks(story.Collect());
  };
  EXPECT_THAT(remarks(298.15), Contains(HasSubstr("subtract 273.15")));
  EXPECT_THAT(remarks(900.0), Contains(HasSubstr("another quantity")));
  EXPECT_THAT(remarks(-100.0), Contains(HasSubstr("another quantity")));
  for (const double degC : {-55.0, 25.0, 150.0}) EXPECT_THAT(remarks(degC), IsEmpty()) << degC;
}

}  // namespace
}  // namespace gyrobench::testing
