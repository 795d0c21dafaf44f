// Files of version 1 as an earlier program wrote them (tests/compatibility): they are read, and
// give the numbers that they gave.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "recording/run_directory.h"
#include "tests/cli/child_process.h"
#include "tests/temporary_folder.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;

std::filesystem::path Older(const std::string& name) {
  return std::filesystem::path(GYROBENCH_SOURCE_DIR) / "tests" / "compatibility" / name;
}

json ReadJson(const std::filesystem::path& file) {
  std::ifstream in(file);
  return json::parse(in);
}

// Rows of numbers below the header.
std::vector<std::vector<double>> NumbersOf(const std::filesystem::path& table) {
  std::vector<std::vector<double>> rows;
  std::ifstream in(table);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#') || line.starts_with("t_s")) continue;
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');)
      rows.back().push_back(std::stod(field));
  }
  return rows;
}

TEST(OlderFiles, ACalibrationCorrectsATableAsItDid) {
  const TemporaryFolder folder;
  const std::filesystem::path output = folder / "corrected.csv";
  const Finished finished =
      RunToEnd({GYROBENCH_PROGRAM, "apply", Older("calibration-1.json").string(),
                Older("input.csv").string(), "-o", output.string()});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const auto now = NumbersOf(output), then = NumbersOf(Older("corrected.csv"));
  ASSERT_EQ(now.size(), then.size());
  ASSERT_GT(now.size(), 30u);
  for (std::size_t i = 0; i < now.size(); ++i) {
    ASSERT_EQ(now[i].size(), then[i].size());
    for (std::size_t j = 0; j < now[i].size(); ++j)
      EXPECT_NEAR(now[i][j], then[i][j], 2e-7) << "row " << i << ", as many digits as are written";
  }
}

// But for what came to the format since, which is added.
TEST(OlderFiles, ACalibrationIsTheSameOnceItIsReadAndWritten) {
  const json before = ReadJson(Older("calibration-1.json"));
  const json now = ToJson(calibration::CalibrationFromJson(before, "calibration-1.json"));
  const json changes = json::diff(before, now);
  ASSERT_EQ(changes.size(), 1u) << changes;
  EXPECT_EQ(changes[0].at("op"), "add");
  EXPECT_EQ(changes[0].at("path"), "/vector/g_sensitivity/statistical_std_error");
  const json row = {nullptr, nullptr, nullptr};
  EXPECT_EQ(changes[0].at("value"), json({row, row, row}));
}

TEST(OlderFiles, ARunsMeasurementIsRead) {
  const json before = ReadJson(Older("measurement-1.json"));
  const json now = recording::ToJson(recording::MeasurementInfoFromJson(before));
  for (const auto& [key, value] : before.items()) EXPECT_EQ(now.at(key), value) << key;
}

}  // namespace
}  // namespace gyrobench::cli
