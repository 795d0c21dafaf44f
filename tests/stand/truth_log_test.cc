#include "stand/truth_log.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/stand/test_stand.h"
#include "tests/temporary_folder.h"

namespace gyrobench::stand {
namespace {

struct Line {
  double t_s = 0.0;
  std::string what, device;
  double value = 0.0;
};

std::vector<Line> Lines(const std::filesystem::path& file, const std::string& what) {
  std::ifstream in(file);
  std::vector<Line> lines;
  std::string text;
  std::getline(in, text);
  EXPECT_EQ(text, "# power-on at utime " + std::to_string(kStart));
  std::getline(in, text);
  EXPECT_EQ(text, "t_s,what,device,value");
  while (std::getline(in, text)) {
    Line line;
    std::istringstream fields(text);
    std::string t_s, value;
    std::getline(fields, t_s, ',');
    std::getline(fields, line.what, ',');
    std::getline(fields, line.device, ',');
    std::getline(fields, value);
    line.t_s = std::stod(t_s);
    line.value = std::stod(value);
    if (line.what == what) lines.push_back(line);
  }
  return lines;
}

class TruthLogTest : public testing::Test {
 protected:
  TruthLogTest() {
    stand_.virtual_stand.emplace();
    stand_.virtual_stand->truth = file_;
  }
  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "truth.csv";
  config::StandConfig stand_ = TestStand();
};

// A campaign judges by this file whether an axis went too far: no excursion may be missed, however
// seldom anybody asks the stand.
TEST_F(TruthLogTest, HasWhereAnAxisWasHoweverSeldomAnyoneLooks) {
  {
    Physics physics(stand_, config::IdealScenario(), 1, kStart);
    physics.MoveBy(2, At(1), Pulses(30), TestMove(100));
    physics.AdvanceTo(At(8));
    physics.MoveBy(2, At(8), Pulses(-30), TestMove(100));
    physics.AdvanceTo(At(60));
  }
  double highest = 0.0;
  double before_deg = 0.0;
  for (const Line& line : Lines(file_, "angle")) {
    if (line.device != "inner") {
      EXPECT_EQ(line.value, 0.0);
      continue;
    }
    EXPECT_LT(std::abs(line.value - before_deg), 0.5);
    before_deg = line.value;
    highest = std::max(highest, line.value);
  }
  EXPECT_NEAR(highest, 30.0, 0.02);
  EXPECT_NEAR(before_deg, 0.0, 0.02);
}

TEST_F(TruthLogTest, HasWhatTheDrivesWereToldAndTheBeginOfEachFault) {
  config::Scenario scenario = config::IdealScenario();
  scenario.faults = {{.at_s = 2.0,
                      .device = "inner.drive",
                      .kind = config::FaultScenario::Kind::kRunaway,
                      .amount = 3}};
  {
    Physics physics(stand_, scenario, 1, kStart);
    physics.MoveBy(0, At(1), Pulses(9), TestMove(100));
    physics.QuickStop(2, At(4));
    physics.SetHeater(At(5), true);
    physics.AdvanceTo(At(9));
  }
  const auto moves = Lines(file_, "move");
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_EQ(moves[0].device, "outer");
  EXPECT_NEAR(moves[0].value, 9.0, 1e-6);
  const auto faults = Lines(file_, "fault");
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].device, "inner.drive");
  EXPECT_NEAR(faults[0].t_s, 2.0, 1e-6);
  EXPECT_NEAR(Lines(file_, "stop").at(0).t_s, 4.0, 1e-6);
  EXPECT_EQ(Lines(file_, "heater").at(0).value, 1.0);
  EXPECT_NEAR(Lines(file_, "angle").back().value, 6.0, 0.1);
}

TEST_F(TruthLogTest, AFileThatCannotBeMadeIsNamed) {
  stand_.virtual_stand->truth = folder_ / "nowhere/truth.csv";
  try {
    Physics physics(stand_, config::IdealScenario(), 1, kStart);
    FAIL() << "expected a ConfigError";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("nowhere/truth.csv"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobench::stand
