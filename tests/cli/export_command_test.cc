// `gyrobench export` of a calibration; of records: record_commands_test.cc.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calibration/artefact/calibration_file.h"
#include "tests/cli/child_process.h"
#include "tests/cli/gyro_z.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class ExportCalibration : public testing::Test {
 protected:
  ExportCalibration() : calibration_(folder_.Write("cal.json", WithNoise().dump())) {}

  static json WithNoise() {
    calibration::Calibration calibration = GyroZ();
    calibration.channels[0].noise = {0.0035, 1e-4, 0.0};
    return ToJson(calibration);
  }
  Finished Run(const std::string& format, const std::string& output,
               std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"export",     "--format", format,
                                          calibration_, "-o",       folder_ / output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Gyrobench(arguments);
  }
  std::string TextOf(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(folder_ / name).rdbuf();
    return text.str();
  }

  TemporaryFolder folder_;
  std::filesystem::path calibration_;
};

TEST_F(ExportCalibration, WritesEveryFormatAndSaysWhatIsLeftOut) {
  for (const auto& [format, word] :
       std::vector<std::pair<std::string, std::string>>{{"c", "gyro_correct("},
                                                        {"px4", "TC_G0_X1_2"},
                                                        {"ardupilot", "INS_TCAL1_GYR1_Z"},
                                                        {"kalibr", "gyroscope_noise_density"},
                                                        {"json", "gyrobench.correction/1"}}) {
    const Finished finished = Run(format, "gyro." + format);
    EXPECT_EQ(finished.status, 0) << finished.err;
    EXPECT_THAT(finished.out, AllOf(HasSubstr("gyro." + format), HasSubstr("! gyro x")));
    EXPECT_THAT(TextOf("gyro." + format), AllOf(HasSubstr(word), HasSubstr("cal.json")));
  }
}

// Of whatever it is to be written: the formats that there are come first.
TEST_F(ExportCalibration, NamesTheFormatsThatThereAreWhereOneIsUnknown) {
  const auto table = folder_.Write("run.csv", "t_s,gyro_z_lsb\n0,1\n");
  for (const std::filesystem::path& input : {calibration_, table}) {
    const Finished finished =
        Gyrobench({"export", "--format", "ros", input, "-o", folder_ / "gyro.ros"});
    EXPECT_EQ(finished.status, 2);
    EXPECT_THAT(finished.err, AllOf(HasSubstr("--format ros: there is no such format"),
                                    HasSubstr("one of c, px4, ardupilot, kalibr, json")));
  }
}

// Gravity lay along z alone: the model holds the other two at 0, without an error.
TEST_F(ExportCalibration, WarnsInEveryFormatOfTermsThatAreZeroBecauseNothingShowsThem) {
  calibration::Calibration calibration = GyroZ();
  calibration.channels[0].noise = {0.0035, 1e-4, 0.0};
  calibration::ModelTerm gravity;
  gravity.id = "bias.g_linear";
  gravity.coefficients = {0.0, 0.0, 0.02};
  calibration.channels[0].model.terms = {gravity};
  calibration_ = folder_.Write("blind.json", ToJson(calibration).dump());
  const auto says = AllOf(HasSubstr("the data do not determine k_x, k_y of bias.g_linear"),
                          HasSubstr("nothing of that is taken off"));
  for (const char* format : {"c", "px4", "ardupilot", "kalibr", "json"}) {
    const Finished finished = Run(format, std::string("gravity.") + format);
    EXPECT_EQ(finished.status, 0) << finished.err;
    EXPECT_THAT(finished.err, says) << format;
    std::string text = TextOf(std::string("gravity.") + format);
    // Comments are broken to lines of their own mark.
    for (const std::string& mark : {std::string("\n *"), std::string("\n#")}) {
      for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos;)
        text.replace(at, mark.size(), "");
    }
    EXPECT_THAT(Flat(text), says) << format;
  }
  const json file = json::parse(TextOf("gravity.json"));
  EXPECT_EQ(file.at("axes").at(2).at("effects").at(0).at("not_determined"), (json{"k_x", "k_y"}));
}

// A coefficient that the data determined, and that came out as 0, is a number like any other.
TEST_F(ExportCalibration, DoesNotCallACoefficientOfZeroUndeterminedThatHasAnError) {
  calibration::Calibration calibration = GyroZ();
  calibration.channels[0].noise = {0.0035, 1e-4, 0.0};
  calibration::ChannelModel& model = calibration.channels[0].model;
  calibration::ModelTerm gravity;
  gravity.id = "bias.g_linear";
  gravity.coefficients = {0.0, 0.0, 0.02};
  model.terms = {gravity};
  model.parameter_names = {"bias.g_linear.k_x", "bias.g_linear.k_y", "bias.g_linear.k_z"};
  model.covariance = {1e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-6};
  calibration_ = folder_.Write("some.json", ToJson(calibration).dump());
  for (const char* format : {"c", "px4", "ardupilot", "kalibr", "json"}) {
    const Finished finished = Run(format, std::string("half.") + format);
    EXPECT_EQ(finished.status, 0) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr("the data do not determine k_y of bias.g_linear"));
  }
  const json file = json::parse(TextOf("half.json"));
  EXPECT_EQ(file.at("axes").at(2).at("effects").at(0).at("not_determined"), json{"k_y"});
}

TEST_F(ExportCalibration, TellsAMachineTheNotes) {
  const json out = json::parse(Run("px4", "gyro.params", {"--json"}).out);
  EXPECT_EQ(out.at("format"), "px4");
  EXPECT_GT(out.at("notes").size(), 2u);
}

TEST_F(ExportCalibration, RefusesAnUnknownFormatAndNamesTheKnownOnes) {
  const Finished unknown = Run("betaflight", "gyro.txt");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("betaflight"), HasSubstr("ardupilot")));
  const Finished none = Gyrobench({"export", calibration_, "-o", folder_ / "gyro.txt"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, AllOf(HasSubstr("cal.json is a calibration"), HasSubstr("kalibr")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "gyro.txt"));
}

TEST_F(ExportCalibration, ReplacesNeitherItsInputNorAFileUnasked) {
  const std::string before = TextOf("cal.json");
  EXPECT_THAT(Run("json", "cal.json", {"--overwrite"}).err, HasSubstr("file that is read"));
  EXPECT_EQ(TextOf("cal.json"), before);
  folder_.Write("gyro.h", "mine");
  EXPECT_THAT(Run("c", "gyro.h").err, HasSubstr("--overwrite"));
  EXPECT_EQ(TextOf("gyro.h"), "mine");
  EXPECT_EQ(Run("c", "gyro.h", {"--overwrite"}).status, 0);
}

TEST_F(ExportCalibration, TellsADamagedCalibrationFromARecordAndATable) {
  folder_.Write("cal.json", R"({"format": "gyrobench.trace/1"})");
  EXPECT_THAT(Run("c", "gyro.h").err, HasSubstr("no calibration"));
  folder_.Write("cal.json", "");
  EXPECT_THAT(Run("c", "gyro.h").err, HasSubstr("an empty file"));
  const auto table = folder_.Write("run.csv", "t_s,gyro_z_lsb\n0,1\n");
  const Finished finished = Gyrobench({"export", "--format", "c", table, "-o", folder_ / "gyro.h"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr("run.csv is none"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "gyro.h"));
}

}  // namespace
}  // namespace gyrobench::cli
