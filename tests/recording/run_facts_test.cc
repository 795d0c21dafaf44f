// What people read of a run, from files that may be damaged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "recording/measurement_files.h"
#include "recording/run_directory.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

json WholeRun() {
  return {{"run_id", "20261121-153012-scale"},
          {"procedure", "scale"},
          {"version", "0.3.0"},
          {"start_utime", 1'795'275'012'000'000},
          {"end_utime", 1'795'277'274'000'000},
          {"stand", {{"name", "laboratory"}}},
          {"measurement", {{"sensor", "0417"}, {"power_on_utime", 1'795'275'000'000'000}}},
          {"parameters", {{"axes", "z"}, {"rate_deg_s", 0.1}, {"turns", 3}, {"whole", 100.0}}},
          {"said", {{{"t_s", 144.5}, {"text", "manoeuvre 1"}}}}};
}

TEST(RunFacts, AreWhatRunJsonSays) {
  const RunFacts facts = RunFactsFromJson(WholeRun());
  EXPECT_EQ(facts.run_id, "20261121-153012-scale");
  EXPECT_EQ(facts.procedure, "scale");
  EXPECT_EQ(facts.version, "0.3.0");
  EXPECT_EQ(facts.started_utime, 1'795'275'012'000'000);
  EXPECT_EQ(facts.ended_utime, 1'795'277'274'000'000);
  EXPECT_EQ(facts.configuration, "laboratory");
  EXPECT_EQ(facts.sensor, "0417");
  EXPECT_EQ(facts.power_on_utime, 1'795'275'000'000'000);
  EXPECT_THAT(facts.parameters, ElementsAre(Pair("axes", "z"), Pair("rate_deg_s", "0.1"),
                                            Pair("turns", "3"), Pair("whole", "100")));
  ASSERT_EQ(facts.said.size(), 1u);
  EXPECT_EQ(facts.said[0].t_s, 144.5);
  EXPECT_EQ(facts.said[0].text, "manoeuvre 1");
  EXPECT_THAT(facts.damage, IsEmpty());
}

// A run that is under way has no end, and a procedure may have no parameters.
TEST(RunFacts, CallNothingDamagedThatIsOnlyNotThere) {
  json run = WholeRun();
  for (const char* key : {"end_utime", "parameters", "said", "version"}) run.erase(key);
  run["measurement"]["power_on_utime"] = nullptr;
  const RunFacts facts = RunFactsFromJson(run);
  EXPECT_EQ(facts.ended_utime, 0);
  EXPECT_EQ(facts.power_on_utime, 0);
  EXPECT_THAT(facts.damage, IsEmpty());
  EXPECT_THAT(RunFactsFromJson(json::object()).damage, IsEmpty());
}

// One damaged field costs that field; each is named with its place, and no value stands in for it.
TEST(RunFacts, NameEachDamagedFieldAndInventNone) {
  json run = WholeRun();
  run["procedure"] = 5;
  run["start_utime"] = "yesterday";
  run["end_utime"] = 1e300;
  run["stand"] = "laboratory";
  run["measurement"]["power_on_utime"] = std::numeric_limits<std::uint64_t>::max();
  run["parameters"] = 7;
  run["said"] = {{{"t_s", "late"}, {"text", "manoeuvre 1"}}, 8};
  const RunFacts facts = RunFactsFromJson(run);
  EXPECT_EQ(facts.procedure, "");
  EXPECT_EQ(facts.started_utime, 0);
  EXPECT_EQ(facts.ended_utime, 0);
  EXPECT_EQ(facts.power_on_utime, 0);
  EXPECT_THAT(facts.parameters, IsEmpty());
  ASSERT_EQ(facts.said.size(), 2u);
  EXPECT_TRUE(std::isnan(facts.said[0].t_s));
  EXPECT_EQ(facts.said[0].text, "manoeuvre 1");
  EXPECT_EQ(facts.run_id, "20261121-153012-scale");
  EXPECT_THAT(facts.damage,
              ElementsAre("procedure: expected a text, found 5: it is left out",
                          HasSubstr("start_utime: expected microseconds"),
                          HasSubstr("end_utime: expected microseconds"),
                          HasSubstr("stand: expected an object"),
                          HasSubstr("measurement.power_on_utime: expected microseconds"),
                          HasSubstr("parameters: expected an object"),
                          HasSubstr("said[0].t_s: expected a number, found \"late\""),
                          HasSubstr("said[1]: expected an object")));
}

TEST(RunFacts, OfAFileThatIsNoJsonAreItsDamageAlone) {
  const TemporaryFolder folder;
  EXPECT_THAT(ReadRunFacts(folder.path()).damage, ElementsAre(HasSubstr("No such file")));
  WriteFile(folder / "run.json", "{\"run_id\": \"x\", ");
  const RunFacts facts = ReadRunFacts(folder.path());
  EXPECT_EQ(facts.run_id, "");
  EXPECT_THAT(facts.damage, ElementsAre(HasSubstr("run.json: no valid JSON at byte")));
  WriteFile(folder / "run.json", "[1, 2]");
  EXPECT_THAT(ReadRunFacts(folder.path()).damage,
              ElementsAre("expected an object {...}, found [1,2]: it is left out"));
}

}  // namespace
}  // namespace gyrobench::recording
