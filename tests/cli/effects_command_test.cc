// `gyrobench effects`: whatever a trace may name can be asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibration/effects/effect.h"
#include "tests/cli/program.h"

namespace gyrobench::cli {
namespace {

using calibration::Effect;
using calibration::EffectCatalogue;
using nlohmann::json;
using testing::HasSubstr;

TEST(EffectsCommand, SaysOfEveryEffectWhatItLooksLikeAndWhatShowsIt) {
  const Finished all = Gyrobench({"effects"});
  EXPECT_EQ(all.status, 0);
  for (const Effect& effect : EffectCatalogue()) {
    EXPECT_THAT(all.out, HasSubstr(effect.id));
  }
  for (const json& one : json::parse(Gyrobench({"effects", "--json"}).out)["effects"]) {
    EXPECT_FALSE(one["to_show_it"].get<std::string>().empty()) << one;
    if (one["owner"].is_null()) continue;
    for (const char* field : {"equation", "looks_like", "cause", "is_corrected"})
      EXPECT_FALSE(one[field].get<std::string>().empty()) << one;
    // A size that decides verdicts says where it is from.
    if (!one["largest_size"].is_null()) {
      EXPECT_FALSE(one["size_source"].get<std::string>().empty()) << one;
    }
  }
}

TEST(EffectsCommand, KnowsAnEffectOfAColumnByTheNameThatATraceGivesIt) {
  EXPECT_THAT(Gyrobench({"effects", "bias.of(supply_v)"}).out, HasSubstr("a column"));
}

TEST(EffectsCommand, TellsWhichOfThemACalibrationCorrects) {
  const auto correction = [](const std::string& id) {
    return json::parse(Gyrobench({"effects", id, "--json"}).out)["effects"][0]["is_corrected"]
        .get<std::string>();
  };
  EXPECT_THAT(correction("scale.cubic"), HasSubstr("C"));
  EXPECT_THAT(correction("bias.hysteresis"), testing::StartsWith("by gyrobench apply"));
  EXPECT_THAT(correction("angle.eccentricity_1"), testing::StartsWith("no: "));
  EXPECT_THAT(correction("bias.step"), testing::StartsWith("no: "));
}

TEST(EffectsCommand, PointsFromAMistypedIdToTheNearest) {
  const Finished done = Gyrobench({"effects", "bias.histeresis"});
  EXPECT_EQ(done.status, 2);
  EXPECT_THAT(done.err, HasSubstr("bias.hysteresis"));
}

// What the JSON has of an effect is what a trace's parameters of it may be.
TEST(EffectsCommand, NamesTheNonlinearParametersWithTheirRanges) {
  const json one =
      json::parse(Gyrobench({"effects", "bias.hysteresis", "--json"}).out)["effects"][0];
  ASSERT_EQ(one["parameters"].size(), 2u);
  EXPECT_EQ(one["parameters"][1]["name"], "r");
  EXPECT_LT(one["parameters"][1]["low"].get<double>(), one["parameters"][1]["high"].get<double>());
}

TEST(EffectsCommand, SaysWhatADescriptionWithoutACauseIs) {
  const Finished done = Gyrobench({"effects", "composed(w*g_z)"});
  EXPECT_EQ(done.status, 2);
  EXPECT_THAT(done.err, HasSubstr("product of two quantities"));
}

TEST(EffectsCommand, WritesAPageWithOneTableForEachEffect) {
  const std::string page = Gyrobench({"effects", "--markdown"}).out;
  std::size_t headings = 0;
  for (std::size_t at = page.find("\n## "); at != std::string::npos;
       at = page.find("\n## ", at + 1))
    ++headings;
  EXPECT_EQ(headings, EffectCatalogue().size() + calibration::NeverSeenEffects().size());
}

}  // namespace
}  // namespace gyrobench::cli
