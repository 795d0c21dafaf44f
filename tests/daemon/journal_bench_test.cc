// A script that is run again on what its commands gave comes to where it was, and nothing moves.
#include "daemon/journal_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "base/error.h"
#include "procedures/engine/dry_bench.h"
#include "procedures/engine/engine.h"

namespace gyrobench::daemon {
namespace {

constexpr const char* kScript = R"(
procedure = { summary = "x", description = "x", measures = {}, parameters = {}, resumable = true }
function run(p)
  bench.rest{ duration_s = 10 }
  for _ = 1, 3 do
    local before_deg = bench.axes().inner.angle_deg
    local turn = bench.turn{ axis = "inner", angle_deg = 10 + before_deg / 7, rate_deg_s = 5 }
    bench.say(string.format("%.17g of %.17g at %.17g", turn.moved_deg, before_deg, bench.elapsed()))
    bench.ask{ id = "go", text = "Go on?", choices = { "yes" } }
  end
end
)";

// The first run leaves its journal behind; a later one is cut after some of it.
class JournalTest : public testing::Test {
 protected:
  // Runs the script on `past`; what was said and planned on the live bench stays in live_.
  void RunOn(std::vector<FinishedCommand> past, const std::string& script = kScript) {
    journal_ = past;
    taken_up_ = 0;
    const procedures::AxisFacts inner{"inner", 40.0, 0.0, -400.0, 400.0, 100.0, 400.0};
    live_ = std::make_unique<procedures::DryBench>(std::vector{inner});
    JournalBench bench(
        {*live_, [this](const FinishedCommand& command) { journal_.push_back(command); },
         [this] { taken_up_ += 1; }},
        std::move(past));
    procedures::RunProcedure(procedures::Procedure::FromSource("x", "x.lua", script), {}, bench);
  }
  std::vector<FinishedCommand> Beginning(std::size_t count) const {
    return {journal_.begin(), journal_.begin() + static_cast<std::ptrdiff_t>(count)};
  }

  std::unique_ptr<procedures::DryBench> live_;
  std::vector<FinishedCommand> journal_;
  int taken_up_ = 0;
};

TEST_F(JournalTest, WhatWasOverMovesNothingAndTheRestIsDoneOnce) {
  RunOn({});
  EXPECT_EQ(taken_up_, 0);
  ASSERT_EQ(journal_.size(), 8u);  // begin, the rest, three turns and questions
  const std::vector<FinishedCommand> whole = journal_;
  for (std::size_t over = 1; over <= whole.size(); ++over) {
    journal_ = whole;
    RunOn(Beginning(over));
    EXPECT_EQ(taken_up_, over < whole.size() ? 1 : 0) << over;
    EXPECT_EQ(journal_.size(), whole.size()) << over;
    std::size_t segments = 0;
    for (std::size_t i = over; i < whole.size(); ++i) {
      const std::string& command = whole[i].command;
      if (command.starts_with("rest") || command.starts_with("turn")) ++segments;
    }
    EXPECT_EQ(live_->plan().segments.size(), segments) << over;
  }
}

TEST_F(JournalTest, AScriptIsToldTheSameAsBeforeToTheLastBit) {
  RunOn({});
  const std::vector<std::string> said = live_->plan().notes;
  RunOn(Beginning(journal_.size()));
  EXPECT_EQ(live_->plan().notes, said);
}

TEST_F(JournalTest, AScriptThatAsksForSomethingElseIsEndedBeforeAnythingMoves) {
  RunOn({});
  std::string other = kScript;
  other.replace(other.find("duration_s = 10"), 15, "duration_s = 11");
  try {
    RunOn(Beginning(3), other);
    FAIL() << "it went on";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("asks for 'rest 11 s' where it had asked for 'rest 10 s'"));
  }
  EXPECT_EQ(taken_up_, 0);
  EXPECT_TRUE(live_->plan().segments.empty());
}

}  // namespace
}  // namespace gyrobench::daemon
