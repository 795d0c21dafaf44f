// `gyrobench effects`: whatever a trace may name can be asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

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
  const json listed = json::parse(Gyrobench({"effects", "--json"}).out);
  for (const json& one : listed["effects"]) {
    EXPECT_FALSE(one["to_show_it"].get<std::string>().empty()) << one;
    if (one["owner"].is_null()) continue;
    for (const char* field : {"equation", "looks_like", "cause", "is_corrected"})
      EXPECT_FALSE(one[field].get<std::string>().empty()) << one;
    // A size that decides verdicts says where it is from; where there is none, why.
    EXPECT_FALSE(one["size_source"].get<std::string>().empty()) << one;
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

std::vector<std::string> SplitAt(const std::string& text, const std::string& mark) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(mark, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + mark.size();
  }
  return parts;
}

// What a table of the page says of `what`; empty where it does not.
std::string CellOf(const std::string& table, const std::string& what) {
  const std::string begin = "| " + what + " | ";
  const std::size_t at = table.find("\n" + begin);
  if (at == std::string::npos) return "";
  const std::size_t from = at + 1 + begin.size();
  return table.substr(from, table.find(" |\n", from) - from);
}

// Dots, not only a frame.
bool HasPicture(const std::string& table) {
  const std::vector<std::string> parts = SplitAt(table, "```");
  if (parts.size() != 3) return false;
  std::set<std::string> characters;
  for (std::size_t at = parts[1].find('\xE2'); at != std::string::npos;
       at = parts[1].find('\xE2', at + 1))
    characters.insert(parts[1].substr(at, 3));
  return characters.size() > 5;
}

TEST(EffectsCommand, WritesAPageThatSaysEverythingOfEachEffectOnce) {
  const std::string page = Gyrobench({"effects", "--markdown"}).out;
  std::vector<std::string> sections = SplitAt(page, "\n## `");
  sections.erase(sections.begin());
  std::set<std::string> ids;
  std::size_t tables = 0;
  for (const std::string& section : sections) {
    const std::string id = section.substr(0, section.find('`'));
    EXPECT_TRUE(ids.insert(id).second) << id << " is there twice";
    std::vector<std::string> forms = SplitAt(section, "| | |\n");
    forms.erase(forms.begin());
    tables += forms.size();
    for (const std::string& form : forms) {
      EXPECT_NE(CellOf(form, "to show it"), "") << section;
      if (!CellOf(form, "cannot be seen").empty()) continue;
      for (const char* what : {"parameters", "looks like", "cause", "belongs to", "largest size",
                               "hard to tell from", "must be known", "is corrected"})
        EXPECT_NE(CellOf(form, what), "") << what << " of " << section;
      EXPECT_NE(CellOf(form, "adds to the rate") + CellOf(form, "adds to the angle"), "");
      // The size with where it is from.
      EXPECT_THAT(CellOf(form, "largest size"), HasSubstr("; "));
      EXPECT_TRUE(HasPicture(form)) << section;
    }
  }
  std::set<std::string> known;
  for (const Effect& effect : EffectCatalogue()) known.insert(effect.id);
  for (const auto& effect : calibration::NeverSeenEffects()) known.insert(effect.id);
  EXPECT_EQ(ids, known);
  EXPECT_EQ(tables, EffectCatalogue().size() + calibration::NeverSeenEffects().size());
}

TEST(EffectsCommand, ShowsAPictureOfOneEffectAndWhatIsHardToTellFromIt) {
  const std::string text = Gyrobench({"effects", "scale.cubic"}).out;
  EXPECT_THAT(text, HasSubstr("rate error [deg/s]"));
  EXPECT_THAT(text, HasSubstr("scale.quadratic_odd"));
}

// Of the build, from which it is installed.
TEST(EffectsCommand, TheInstalledPageIsTheOneThatTheProgramWrites) {
  std::ifstream file(GYROBENCH_EFFECTS_PAGE);
  ASSERT_TRUE(file);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(page, Gyrobench({"effects", "--markdown"}).out);
}

}  // namespace
}  // namespace gyrobench::cli
