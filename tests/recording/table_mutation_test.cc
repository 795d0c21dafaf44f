// Random damage to valid tables: thousands of cases, the same in every run.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.h"
#include "recording/replay.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

std::string ValidTable() {
  std::string text =
      "# sensor = 7\n# site_latitude_deg = 55\n# segment = 0 1 rest first\n"
      "t_s,gyro_x_lsb,gyro_z_lsb,accel_x_g,ref_inner_deg,temp_degC,supply_v\n";
  for (int i = 0; i < 60; ++i) {
    text += std::to_string(i * 0.005) + "," + std::to_string(i * 37 % 999 - 500) + ",-12,0.5," +
            (i % 4 == 0 ? std::to_string(i * 0.225) : "") + ",21.5,\n";
  }
  return text;
}

void Mutate(std::string& text, std::mt19937& random) {
  constexpr const char* kPieces[] = {",",
                                     "\n",
                                     "\r\n",
                                     "#",
                                     "\"",
                                     "nan",
                                     "-",
                                     "1e400",
                                     ".",
                                     "e",
                                     "\0x",
                                     "\xEF\xBB\xBF",
                                     "99999999999999999999",
                                     "t_s",
                                     "inf",
                                     " "};
  const std::size_t at = random() % text.size();
  switch (random() % 5) {
    case 0:
      text[at] = static_cast<char>(random());
      break;
    case 1:
      text.erase(at, random() % 40 + 1);
      break;
    case 2:
      text.insert(at, kPieces[random() % std::size(kPieces)]);
      break;
    case 3:
      text.insert(at, text.substr(random() % text.size(), random() % 80));
      break;
    default:
      text.resize(at);
      break;
  }
}

// Whatever the bytes: rows in order of time, values that are numbers or missing, or an error that
// names the file.
TEST(TableMutations, ThousandsOfThemNeverCrashNorBreakTheOrder) {
  const TemporaryFolder folder;
  const std::string valid = ValidTable();
  std::mt19937 random(424242);
  int errors = 0;
  for (int round = 0; round < 6000; ++round) {
    std::string text = valid;
    for (int i = static_cast<int>(random() % 3); i >= 0 && !text.empty(); --i) Mutate(text, random);
    WriteFile(folder / "mutant.csv", text);
    KeepingSink sink;
    try {
      Replay(folder / "mutant.csv", sink);
    } catch (const DataError& error) {
      ++errors;
      EXPECT_NE(std::string(error.what()).find("mutant.csv"), std::string::npos) << error.what();
    }
    for (std::size_t i = 0; i < sink.gyro.size(); ++i) {
      for (const double xi : sink.gyro[i].xi) ASSERT_FALSE(std::isinf(xi));
      if (i > 0) {
        ASSERT_GT(sink.gyro[i].t_s, sink.gyro[i - 1].t_s) << "round " << round;
      }
    }
  }
  EXPECT_GT(errors, 100);
  EXPECT_LT(errors, 5000) << "most damage must leave the rest readable";
}

}  // namespace
}  // namespace gyrobench::recording
