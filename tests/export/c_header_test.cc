// Law: the function of the header, compiled by a C compiler, gives what `gyrobench apply` gives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "base/error.h"
#include "calibration/effects/effect.h"
#include "tests/cli/child_process.h"
#include "tests/export/export_sample.h"
#include "tests/temporary_folder.h"

namespace gyrobench::exporting {
namespace {

using calibration::Calibration;
using calibration::ModelTerm;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kProgram = R"(
#include <stdio.h>
#include "gyro.h"
int main(int argc, char **argv) {
  FILE *in = argc > 1 ? fopen(argv[1], "r") : NULL;
  double v[5];
  while (in && fscanf(in, "%lf %lf %lf %lf %lf", v, v + 1, v + 2, v + 3, v + 4) == 5) {
    static gyro_input sample;
    GYROBENCH_REAL rate[3];
    int flags, i;
    for (i = 0; i < 3; ++i) sample.xi[i] = (GYROBENCH_REAL)v[i];
    sample.temperature_degC = (GYROBENCH_REAL)v[3];
#ifdef GRAVITY
    sample.gravity_g[0] = GYROBENCH_C(0.6);
    sample.gravity_g[2] = GYROBENCH_C(0.8);
#endif
#ifdef TIME
    sample.since_power_on_s = (GYROBENCH_REAL)v[4];
#endif
    flags = gyro_correct(&sample, rate);
    printf("%d %.17g %.17g %.17g\n", flags, (double)rate[0], (double)rate[1], (double)rate[2]);
  }
  return 0;
}
)";

struct Output {
  int flags = -1;
  Vector3 rate_deg_s = {};
};

// A header compiled to a program.
class Firmware {
 public:
  // `defines`: of the program above and of the header.
  explicit Firmware(const std::string& header, std::vector<std::string> defines = {}) {
    folder_.Write("gyro.h", header);
    std::vector<std::string> command = {GYROBENCH_C_COMPILER,
                                        "-std=c99",
                                        "-pedantic",
                                        "-Wall",
                                        "-Wextra",
                                        "-Wdouble-promotion",
                                        "-Wconversion",
                                        "-Wshadow",
                                        "-Werror",
                                        folder_.Write("main.c", kProgram),
                                        "-o",
                                        folder_ / "main",
                                        "-lm"};
    if (header.find("gravity_g[3]") != std::string::npos) defines.emplace_back("GRAVITY");
    if (header.find("since_power_on_s;") != std::string::npos) defines.emplace_back("TIME");
    for (const std::string& define : defines) command.push_back("-D" + define);
    const cli::Finished built = cli::RunToEnd(command);
    EXPECT_EQ(built.status, 0) << built.err << header;
  }

  std::vector<Output> Run(const std::vector<State>& states) const {
    std::ostringstream in;
    in.precision(17);
    for (const State& state : states) {
      in << state.xi[0] << ' ' << state.xi[1] << ' ' << state.xi[2] << ' ' << state.temperature_degC
         << ' ' << state.t_s << '\n';
    }
    const std::string file = folder_.Write("in.txt", in.str());
    std::istringstream out(cli::RunToEnd({folder_ / "main", file}).out);
    std::vector<Output> outputs;
    std::string flags, x, y, z;  // a stream does not read nan
    while (out >> flags >> x >> y >> z)
      outputs.push_back({std::stoi(flags), {std::stod(x), std::stod(y), std::stod(z)}});
    return outputs;
  }

 private:
  TemporaryFolder folder_;
};

void ExpectAsCorrected(const Calibration& calibration, const Firmware& firmware,
                       double tolerance_deg_s) {
  for (const double temperature : {15.0, 20.0, 23.5, 26.0, 30.0, 33.0}) {
    const std::vector<State> states = StatesAt(temperature);
    const std::vector<Vector3> expected = Corrected(calibration, states);
    const std::vector<Output> outputs = firmware.Run(states);
    ASSERT_EQ(outputs.size(), expected.size());
    for (std::size_t i = 0; i < outputs.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(outputs[i].rate_deg_s[c], expected[i][c], tolerance_deg_s)
            << "axis " << c << ", sample " << i << " at " << temperature << " degC";
  }
}

TEST(CHeader, UndoesBiasScaleAndMisalignmentInBothPrecisions) {
  const Calibration calibration = ThreeAxes();
  const std::string header = Write(calibration, "c").text;
  ExpectAsCorrected(calibration, Firmware(header, {"GYROBENCH_DOUBLE"}), 1e-10);
  // Some roundings of 70 deg/s in a float.
  ExpectAsCorrected(calibration, Firmware(header), 5e-5);
  EXPECT_THAT(header, Not(HasSubstr("math.h")));
}

// A trace of tables without a thermometer leaves the term's temperature open.
TEST(CHeader, HoldsAnEffectThatDoesNotAskForATemperatureWithoutOne) {
  Calibration calibration = ThreeAxes();
  ModelTerm term = CatalogueTerm("bias.g_linear", {0.1, 0.2, -0.3});
  term.reference_degC = kMissing;
  for (calibration::ChannelCalibration& channel : calibration.channels)
    channel.model.terms = {term};
  const Exported exported = Write(calibration, "c");
  EXPECT_TRUE(exported.notes.empty());
  ExpectAsCorrected(calibration, Firmware(exported.text, {"GYROBENCH_DOUBLE"}), 1e-8);
}

struct HeldEffect {
  const char* name;
  ModelTerm term;
};
class HeldEffects : public testing::TestWithParam<HeldEffect> {};

TEST_P(HeldEffects, AreUndoneAsByTheCorrector) {
  Calibration calibration = ThreeAxes();
  for (calibration::ChannelCalibration& channel : calibration.channels)
    channel.model.terms = {GetParam().term};
  const Exported exported = Write(calibration, "c");
  EXPECT_TRUE(exported.notes.empty()) << exported.notes[0];
  ExpectAsCorrected(calibration, Firmware(exported.text, {"GYROBENCH_DOUBLE"}), 1e-8);
  ExpectAsCorrected(calibration, Firmware(exported.text), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(
    All, HeldEffects,
    testing::Values(HeldEffect{"g_linear", CatalogueTerm("bias.g_linear", {0.1, 0.2, -0.3})},
                    HeldEffect{"g_squared", CatalogueTerm("bias.g_squared", {0.1, 0.2})},
                    HeldEffect{"scale_g", CatalogueTerm("scale.g", {1e-3, 2e-3, -3e-3})},
                    HeldEffect{"scale_temperature", CatalogueTerm("scale.temperature", {1e-3})},
                    HeldEffect{"quadratic_odd", CatalogueTerm("scale.quadratic_odd", {1e-4})},
                    HeldEffect{"cubic", CatalogueTerm("scale.cubic", {2e-6})},
                    HeldEffect{"quadratic_even", CatalogueTerm("scale.quadratic_even", {1e-4})},
                    HeldEffect{"asymmetry", CatalogueTerm("scale.asymmetry", {0.01})},
                    HeldEffect{"temperature_rate", CatalogueTerm("bias.temperature_rate", {2.0})},
                    HeldEffect{"warm_up", CatalogueTerm("bias.warm_up", {0.3}, {2.0})},
                    HeldEffect{"product_straight_in_the_rate",
                               ComposedTerm({"w_z", "g_x", "T"}, 1e-4)},
                    HeldEffect{"product_bent_in_the_rate", ComposedTerm({"w", "abs_w"}, 1e-4)},
                    HeldEffect{"curve_of_the_temperature",
                               CurveTerm("T", {22.0, 24.0, 29.0}, {0.1, 0.3, -0.1})},
                    HeldEffect{"curve_of_the_rate", CurveTerm("w", {-10.0, 10.0}, {-0.1, 0.1})},
                    HeldEffect{"curve_of_one_knot", CurveTerm("g_z", {0.0}, {0.2})}),
    [](const auto& tested) { return std::string(tested.param.name); });

// What an effect's own file gives as its correction in C can be written, whatever the numbers.
TEST(CHeader, HoldsEveryEffectThatHasAnExpression) {
  std::size_t held = 0;
  for (const calibration::Effect& effect : calibration::EffectCatalogue()) {
    if (effect.c_expression.empty()) continue;
    ++held;
    Calibration calibration = ThreeAxes();
    calibration.channels[0].model.terms = {
        CatalogueTerm(effect.id, std::vector<double>(effect.terms.size(), 1e-7),
                      std::vector<double>(effect.nonlinear.size(), 50.0))};
    const Exported exported = Write(calibration, "c");
    EXPECT_TRUE(exported.notes.empty()) << effect.id;
    for (const calibration::EffectTerm& term : effect.terms) {
      EXPECT_LT(&term - effect.terms.data(), 3) << effect.id << ": as many as {c0} to {c2}";
    }
  }
  EXPECT_EQ(held, 10u) << "add what is new to HeldEffects, which compares it with the corrector";
}

TEST(CHeader, SaysWhatItDoesNotHoldInTheFileAndInItsNotes) {
  Calibration calibration = ThreeAxes();
  ModelTerm supply = CatalogueTerm("bias.of(supply_v)", {0.7});
  supply.covariate = "supply_v";
  calibration.channels[1].model.terms = {CatalogueTerm("bias.hysteresis", {0.02}, {2.0}), supply,
                                         CatalogueTerm("bias.tone", {0.1, 0.1}, {0.2})};
  const Exported exported = Write(calibration, "c");
  EXPECT_EQ(exported.notes.size(), 3u);
  for (const char* word : {"gyro y: bias.hysteresis", "memory", "column supply_v", "bias.tone"})
    EXPECT_THAT(Flat(exported.text), HasSubstr(word));
  for (const std::string& note : exported.notes) EXPECT_THAT(Flat(exported.text), HasSubstr(note));
  // What is left is as if they were not there.
  ExpectAsCorrected(ThreeAxes(), Firmware(exported.text, {"GYROBENCH_DOUBLE"}), 1e-10);
}

// Firmware reads the converter, whose counts nobody has centred.
TEST(CHeader, SaysWhatIsToBeTakenOffCountsOfAnUnsignedConverter) {
  Calibration calibration = ThreeAxes();
  EXPECT_THAT(Flat(Write(calibration, "c").text), Not(HasSubstr("count of zero")));
  calibration.gyro_lsb_zero = 32768.0;
  EXPECT_THAT(Flat(Write(calibration, "c").text),
              HasSubstr("xi: output of the gyro [LSB], less 32768: the converter's count of zero"));
}

TEST(CHeader, ItsWorkedExampleIsRight) {
  const std::string header = Write(ThreeAxes(), "c").text;
  const std::vector<double> xi = NumbersAfter(header, "Worked example: xi =");
  const std::vector<double> temperature = NumbersAfter(header, "LSB, T =");
  const std::vector<double> w = NumbersAfter(header, "gives w =");
  ASSERT_EQ(xi.size(), 3u);
  ASSERT_EQ(w.size(), 3u);
  ASSERT_EQ(temperature.size(), 1u);
  const State state{{xi[0], xi[1], xi[2]}, temperature[0], 0.0};
  const Output output = Firmware(header).Run({state}).at(0);
  EXPECT_EQ(output.flags, 0);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(output.rate_deg_s[c], w[c], 2e-5);
}

TEST(CHeader, FlagsWhatIsBeyondTheCalibrationAndWhatIsNoNumber) {
  const Firmware firmware(Write(ThreeAxes(), "c").text);
  const std::vector<Output> outputs = firmware.Run({{{0.0, 0.0, 0.0}, 25.0, 0.0},
                                                    {{0.0, 0.0, 0.0}, 31.0, 0.0},
                                                    {{0.0, 0.0, 60.0 * kUnits}, 25.0, 0.0},
                                                    {{0.0, 0.0, 60.0 * kUnits}, 10.0, 0.0},
                                                    {{0.0, NAN, 0.0}, 25.0, 0.0},
                                                    {{0.0, 0.0, 0.0}, NAN, 0.0}});
  ASSERT_EQ(outputs.size(), 6u);
  EXPECT_EQ(outputs[0].flags, 0);
  EXPECT_EQ(outputs[1].flags, 1);
  EXPECT_EQ(outputs[2].flags, 2);
  EXPECT_EQ(outputs[3].flags, 3);
  EXPECT_EQ(outputs[4].flags, 2);
  EXPECT_TRUE(std::isnan(outputs[4].rate_deg_s[1]));
  EXPECT_EQ(outputs[5].flags, 3);
  EXPECT_TRUE(std::isnan(outputs[5].rate_deg_s[0]));
}

// An effect that is not small beside the rate: the corrector leaves such rows empty.
TEST(CHeader, FlagsRatesThatTheEffectsDoNotPermit) {
  Calibration calibration = ThreeAxes();
  calibration.channels[2].model.terms = {CatalogueTerm("scale.temperature", {-0.5})};
  const Firmware firmware(Write(calibration, "c").text);
  const State state{{0.0, 0.0, 10.0 * kUnits}, 20.0, 0.0};
  EXPECT_NE(firmware.Run({state}).at(0).flags & 4, 0);
}

TEST(CHeader, OfOneAxisWithoutTemperatureLeavesTheOthersNominal) {
  Calibration calibration = ThreeAxes();
  calibration.channels.erase(calibration.channels.begin(), calibration.channels.begin() + 2);
  calibration::ChannelModel& z = calibration.channels[0].model;
  z.bias_deg_s = {0.4};
  z.reference_degC = z.min_temperature_degC = z.max_temperature_degC = kMissing;
  const Exported exported = Write(calibration, "c");
  EXPECT_EQ(exported.notes.size(), 2u);
  EXPECT_THAT(exported.notes[0], HasSubstr("gyro x: not in the calibration"));
  ExpectAsCorrected(calibration, Firmware(exported.text, {"GYROBENCH_DOUBLE"}), 1e-10);
}

// The texts of a calibration come from a file: none may end a comment.
TEST(CHeader, CompilesWhateverTheSensorIsCalled) {
  Calibration calibration = ThreeAxes();
  calibration.sensor = "a*/ #error\n#error /* b ?\?/\n\\";
  const Firmware firmware(Write(calibration, "c").text);
  EXPECT_EQ(firmware.Run({State{}}).size(), 1u);
}

TEST(CHeader, OfTwoSensorsFitIntoOneProgram) {
  const Calibration calibration = ThreeAxes();
  const auto header = [&](const char* target) { return Write(calibration, "c", target).text; };
  const Firmware firmware(header("gyro.h") + header("2nd Gyro.h"));
  EXPECT_EQ(firmware.Run({State{}}).size(), 1u);
  EXPECT_THAT(header("2nd Gyro.h"), HasSubstr("gyro_2nd_gyro_correct("));
}

TEST(CHeader, RefusesWhatAFloatCannotHold) {
  Calibration calibration = ThreeAxes();
  calibration.channels[0].model.bias_deg_s[0] = 1e300;
  EXPECT_THROW(Write(calibration, "c"), DataError);
}

}  // namespace
}  // namespace gyrobench::exporting
