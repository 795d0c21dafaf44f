// Rehearsals, choices, and the procedure that lives by them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>

#include "tests/procedures/motion.h"
#include "tests/procedures/shipped.h"

namespace gyrobench::procedures {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr const char* kTwo =
    "bench.rehearse()\n"
    "bench.turn{ axis = 'inner', angle_deg = 90, rate_deg_s = 10 }\n"
    "bench.rest{ duration_s = 3 }\n"
    "assert(bench.rehearsed{ name = 'a turn' })\n"
    "bench.rehearse()\n"
    "bench.rest{ duration_s = 50 }\n"
    "assert(bench.axes().inner.angle_deg == 0)\n"
    "assert(bench.rehearsed{ name = 'a rest', warms_degC = -2 })\n";

TEST(Rehearsal, MovesNothingAndOffersWhatWasTried) {
  FakeBench bench;
  bench.choices = {{.open = "much", .best = 1, .because = "tells a from b", .nats = 2.5}};
  RunProcedure(Script(std::string(kTwo) + "local choice = bench.choose()\n"
                                          "assert(choice.index == 2 and choice.name == 'a rest')\n"
                                          "assert(choice.duration_s == 50 and not choice.settled)\n"
                                          "assert(choice.open == 'much' and choice.nats == 2.5)\n"
                                          "assert(choice.because == 'tells a from b')"),
               {}, bench);
  EXPECT_THAT(bench.turns, SizeIs(0));
  ASSERT_THAT(bench.offered, SizeIs(1));
  ASSERT_THAT(bench.offered[0], SizeIs(2));
  const Rehearsal& turn = bench.offered[0][0];
  ASSERT_THAT(turn.moves, SizeIs(1));
  EXPECT_EQ(turn.moves[0].to_deg, 90.0);
  EXPECT_NEAR(turn.duration_s, turn.moves[0].duration_s + 3.0, 1e-9);
  EXPECT_EQ(bench.offered[0][1].warms_degC, -2.0);
}

TEST(Rehearsal, OneThatTakesTooLongIsWeighedAndMarked) {
  FakeBench bench;
  RunProcedure(Script("bench.rehearse()\n"
                      "bench.rest{ duration_s = 50 }\n"
                      "assert(not bench.rehearsed{ name = 'a rest', at_most_s = 49 })\n" +
                      std::string(kTwo) + "bench.choose()"),
               {}, bench);
  ASSERT_THAT(bench.offered.at(0), SizeIs(3));
  EXPECT_FALSE(bench.offered[0][0].affordable);
  EXPECT_TRUE(bench.offered[0][1].affordable);
}

TEST(Rehearsal, ARunThatEndsWithinOneIsAnErrorAndNothingIsChosenWithinOne) {
  FakeBench bench;
  EXPECT_THAT(MessageOf<ScriptError>([&] { RunProcedure(Script("bench.rehearse()"), {}, bench); }),
              HasSubstr("bench.rehearsed is missing"));
  EXPECT_THAT(MessageOf<ScriptError>([&] {
                RunProcedure(Script(std::string(kTwo) + "bench.rehearse() bench.choose()"), {},
                             bench);
              }),
              HasSubstr("a rehearsal is on"));
}

TEST(Rehearsal, BeginsAtTheLimitWhereAnAxisReadsALittleBeyondIt) {
  FakeBench bench;
  bench.axes[2].angle_deg = bench.axes[2].min_deg - 0.003;
  EXPECT_NO_THROW(
      RunProcedure(Script("bench.rehearse()\n"
                          "local home_deg = bench.axes().inner.angle_deg\n"
                          "bench.move_to{ axis = 'inner', angle_deg = 0, rate_deg_s = 10 }\n"
                          "bench.move_to{ axis = 'inner', angle_deg = home_deg, rate_deg_s = 10 }\n"
                          "bench.rehearsed{ name = 'home' }"),
                   {}, bench));
}

TEST(Rehearsal, AMenuIsForOneChoice) {
  FakeBench bench;
  const std::string message = MessageOf<ScriptError>([&] {
    RunProcedure(Script(std::string(kTwo) + "bench.choose() bench.choose()"), {}, bench);
  });
  EXPECT_THAT(message, HasSubstr("nothing was rehearsed"));
}

TEST(Rehearsal, BeginAndEndBelongTogether) {
  for (const auto& [body, says] : {std::pair{"bench.rehearse() bench.rehearse()", "is on"},
                                   std::pair{"bench.rehearsed{ name = 'x' }", "no rehearsal"}}) {
    FakeBench bench;
    EXPECT_THAT(MessageOf<ScriptError>([&] { RunProcedure(Script(body), {}, bench); }),
                HasSubstr(says));
  }
}

TEST(Rehearsal, KeepsTheLimits) {
  FakeBench bench;
  EXPECT_THROW(
      RunProcedure(Script("bench.rehearse()\n"
                          "bench.turn{ axis = 'inner', angle_deg = 400, rate_deg_s = 10 }"),
                   {}, bench),
      LimitError);
  EXPECT_THAT(bench.turns, SizeIs(0));
}

TEST(CloseLoop, TakesItsBudgetAtWorstAndNotMore) {
  for (const double budget_min : {10.0, 30.0}) {
    const Plan plan = DryRun(Shipped("close_loop"), {{"budget_min", budget_min}},
                             Roomy({"outer", "middle", "inner"}));
    EXPECT_LE(plan.duration_s, 60.0 * budget_min);
    EXPECT_GE(plan.duration_s, 60.0 * budget_min - 180.0);
  }
}

TEST(CloseLoop, MakesWhatWasChosenAndEndsWhenTheVerdictOutlivesIt) {
  FakeBench bench;
  bench.axes = Roomy({"outer", "middle", "inner"});
  bench.verdicts = {{"z", "explained", "Explained by scale.g.", {{"scale.g", "gyro", {}, {}, ""}}}};
  bench.choices = {{.open = "scale.g or scale.cubic", .best = 2, .because = "tells one"},
                   {.settled = true, .open = "", .best = 0, .because = "would show all"},
                   {.settled = true, .open = "", .best = 0, .because = "would show all"}};
  RunProcedure(Shipped("close_loop"), {{"confirmations", 2.0}}, bench);
  EXPECT_THAT(bench.offered, SizeIs(3));
  const auto said = [&](const std::string& text) {
    return std::count_if(bench.calls.begin(), bench.calls.end(), [&](const std::string& call) {
      return call.find(text) != std::string::npos;
    });
  };
  EXPECT_EQ(said("manoeuvre 1: " + bench.offered[0][2].name), 1);
  EXPECT_EQ(said("scale.g or scale.cubic"), 1);
  EXPECT_EQ(said("settled"), 1);
}

using Effects = std::vector<TracedEffect>;

// A loop whose n-th trace finds the n-th of `found` about z, and whose every verdict is settled:
// how many choices it makes.
std::size_t ChoicesUntilSettled(const std::vector<Effects>& found,
                                const std::set<std::string>& small = {}) {
  class Bench : public FakeBench {
   public:
    explicit Bench(const std::vector<Effects>& found) : found_(found) {}
    std::vector<AxisVerdict> Trace() override {
      const std::size_t last = found_.size() - 1;
      return {{"z", "explained", "", found_[std::min(traces_++, last)]}};
    }

   private:
    const std::vector<Effects>& found_;
    std::size_t traces_ = 0;
  };
  Bench bench(found);
  bench.axes = Roomy({"outer", "middle", "inner"});
  Choice choice = {.settled = true, .open = "", .best = 0, .because = "would show all"};
  for (const std::string& id : small) choice.small.insert({"z", id});
  bench.choices.assign(20, choice);
  RunProcedure(Shipped("close_loop"), {{"confirmations", 2.0}}, bench);
  return bench.offered.size();
}

TracedEffect Named(const std::string& id, std::vector<std::string> rivals = {}) {
  TracedEffect effect;
  effect.id = id;
  const auto is_step = [](const std::string& one) { return one.ends_with(".step"); };
  effect.may_be_a_step = is_step(id) || std::ranges::any_of(rivals, is_step);
  effect.rivals = std::move(rivals);
  return effect;
}

TEST(CloseLoop, EachEffectMustBeNamedThroughSoManyManoeuvres) {
  const TracedEffect early = Named("scale.cubic"), late = Named("scale.g");
  EXPECT_EQ(ChoicesUntilSettled({{early}}), 3U);
  EXPECT_EQ(ChoicesUntilSettled({{early}, {early}, {early, late}}), 5U);
  // What is gone again leaves the others as they were.
  EXPECT_EQ(ChoicesUntilSettled({{early}, {early, late}, {early}}), 3U);
}

TEST(CloseLoop, WhatMayBeAStepMustBeNamedThroughTwiceAsMany) {
  EXPECT_EQ(ChoicesUntilSettled({{Named("bias.step")}}), 5U);
  EXPECT_EQ(ChoicesUntilSettled({{Named("bias.warm_up", {"bias.step"})}}), 5U);
}

TEST(CloseLoop, ARivalsNameIsNoOtherEffect) {
  const TracedEffect first = Named("scale.cubic", {"scale.g"});
  const TracedEffect second = Named("scale.g", {"scale.cubic"});
  EXPECT_EQ(ChoicesUntilSettled({{first}, {second}, {first}}), 3U);
  EXPECT_EQ(ChoicesUntilSettled({{first}, {Named("scale.g")}}), 3U);
  EXPECT_EQ(ChoicesUntilSettled({{first}, {Named("scale.asymmetry")}}), 4U);
  // That both might be a third is no reason.
  EXPECT_EQ(ChoicesUntilSettled({{first}, {Named("scale.asymmetry", {"scale.g"})}}), 4U);
}

TEST(CloseLoop, AnEffectGoesOnAsOneAndTheOtherBeginsAnew) {
  const TracedEffect either = Named("scale.cubic", {"scale.g"});
  const Effects both = {Named("scale.g"), Named("scale.cubic")};
  EXPECT_EQ(ChoicesUntilSettled({{either}, {either}, both}), 5U);
  const TracedEffect step = Named("angle.step");
  EXPECT_EQ(ChoicesUntilSettled({{step}, {step}, {step}, {step}, {step, step}}), 9U);
}

TEST(CloseLoop, ASmallEffectHoldsNothingUp) {
  const TracedEffect large = Named("scale.cubic"), small = Named("scale.g");
  const std::vector<Effects> late = {{large}, {large}, {large, small}};
  EXPECT_EQ(ChoicesUntilSettled(late), 5U);
  EXPECT_EQ(ChoicesUntilSettled(late, {"scale.g"}), 3U);
}

TEST(CloseLoop, SaysAtEveryEndWhatIsOpenOfSmallEffects) {
  for (const bool settled : {true, false}) {
    FakeBench bench;
    bench.axes = Roomy({"inner"});
    bench.verdicts = {{"z", "explained", "", {Named("scale.g")}}};
    bench.choices = {{.settled = settled, .open = "", .best = std::nullopt, .because = ""}};
    bench.choices[0].never = "x: a or b";
    bench.choices[0].small_pairs = "z: scale.g or scale.cubic";
    RunProcedure(Shipped("close_loop"), {{"confirmations", 0.0}}, bench);
    EXPECT_THAT(bench.LastSaid(), AllOf(HasSubstr("x: a or b"), HasSubstr("less than 30 %"),
                                        HasSubstr("z: scale.g or scale.cubic")));
  }
}

TEST(CloseLoop, PassesItsLimitOfWhatIsSmallOn) {
  FakeBench bench;
  bench.axes = Roomy({"outer", "middle", "inner"});
  bench.verdicts = {{"z", "none", "", {}}};
  RunProcedure(Shipped("close_loop"), {{"small_percent", 12.5}}, bench);
  ASSERT_THAT(bench.small_limits, SizeIs(1));
  EXPECT_EQ(bench.small_limits[0], 0.125);
}

TEST(CloseLoop, AOneAxisTableHasAShorterMenuAndAStandWithoutTurnsAboutZIsRefused) {
  FakeBench bench;
  bench.verdicts = {{"z", "none", "", {}}};
  bench.axes = Roomy({"inner"});
  RunProcedure(Shipped("close_loop"), {}, bench);
  FakeBench whole;
  whole.verdicts = bench.verdicts;
  whole.axes = Roomy({"outer", "middle", "inner"});
  RunProcedure(Shipped("close_loop"), {}, whole);
  EXPECT_LT(bench.offered.at(0).size(), whole.offered.at(0).size());
  EXPECT_THAT(RefusalOf("close_loop", {}, Roomy({"middle"})), HasSubstr("turns about z"));
}

// Each manoeuvre in a line, and what holds of all of them once.
TEST(CloseLoop, ADryRunDoesNotSayTheSameOfEveryManoeuvre) {
  const Plan plan = DryRun(Shipped("close_loop"), {}, Roomy({"outer", "middle", "inner"}));
  const auto saying = [&](const std::string& text) {
    return std::ranges::count_if(
        plan.notes, [&](const std::string& note) { return note.find(text) != std::string::npos; });
  };
  EXPECT_GT(saying("manoeuvre 12: "), 0);
  EXPECT_EQ(saying("stands for the one that is chosen"), 1);
  EXPECT_EQ(saying("after "), 0);
  EXPECT_EQ(saying("expected"), 0);
  for (const std::string& note : plan.notes) {
    if (note.starts_with("manoeuvre ")) {
      EXPECT_LT(note.size(), 80U) << note;
    }
  }
}

// What a manoeuvre is expected to tell is said in a unit that laboratories know.
TEST(CloseLoop, SaysWhatIsExpectedAsChiSquare) {
  FakeBench bench;
  bench.axes = Roomy({"outer", "middle", "inner"});
  bench.verdicts = {{"z", "explained", "Explained by scale.g.", {Named("scale.g")}}};
  bench.choices = {
      {.open = "scale.g or scale.cubic", .best = 2, .because = "tells one", .nats = 4.15},
      {.settled = true, .open = "", .best = std::nullopt, .because = ""}};
  RunProcedure(Shipped("close_loop"), {{"confirmations", 0.0}}, bench);
  EXPECT_TRUE(std::ranges::any_of(bench.calls, [](const std::string& call) {
    return call.find("it tells one (chi-square 8.3 expected); open: scale.g or") !=
           std::string::npos;
  }));
}

TEST(CloseLoop, WithoutAFanNobodyIsAsked) {
  const Plan plan = DryRun(Shipped("close_loop"), {{"fan", false}, {"budget_min", 120.0}},
                           Roomy({"outer", "middle", "inner"}));
  EXPECT_THAT(plan.questions, SizeIs(0));
}

}  // namespace
}  // namespace gyrobench::procedures
