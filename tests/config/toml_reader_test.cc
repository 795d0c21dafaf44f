#include "config/toml_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/nearest_word.h"
#include "tests/config/config_files.h"

namespace gyrobench::config {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr NumberRange kRange{-1.5, 20, "deg/s"};

TomlTable Parse(std::string_view text) { return TomlTable::FromText(text, "bench/a.toml"); }

TEST(TomlReader, GivesWhatTheFileSays) {
  const auto root = Parse(R"(
number = 2.5
whole = 7
hex = 0x1F
flag = true
text = "drei"
word = "tcp"
path = "maps/x.toml"
rooted = "/etc/y.toml"
list = [1, 2.5, -1]
names = ["a", "b"]
[sub.deep]
key = 1
[[item]]
key = 2
[[item]]
key = 3
)");
  EXPECT_EQ(root.Number("number", kRange), 2.5);
  EXPECT_EQ(root.Number("whole", kRange), 7.0);
  EXPECT_EQ(root.Integer("hex", {}), 31);
  EXPECT_TRUE(root.Bool("flag"));
  EXPECT_EQ(root.String("text"), "drei");
  EXPECT_EQ(root.Choice<int>("word", {{"rtu", 4}, {"tcp", 5}}), 5);
  EXPECT_EQ(root.Path("path"), "bench/maps/x.toml");
  EXPECT_EQ(root.Path("rooted"), "/etc/y.toml");
  EXPECT_THAT(root.Numbers("list", kRange, {3, 3}), ElementsAre(1, 2.5, -1));
  EXPECT_THAT(root.Strings("names"), ElementsAre("a", "b"));
  EXPECT_EQ(root.Table("sub").Table("deep").Integer("key", {}), 1);
  EXPECT_EQ(root.Tables("item").at(0).Integer("key", {}), 2);
  EXPECT_EQ(root.Tables("item").at(1).Integer("key", {}), 3);
  EXPECT_NO_THROW(root.Finish());
}

TEST(TomlReader, GivesTheFallbackOfAnAbsentKey) {
  const auto root = Parse("");
  EXPECT_EQ(root.Number("a", kRange, 3.5), 3.5);
  EXPECT_EQ(root.OptionalNumber("a", kRange), std::nullopt);
  EXPECT_EQ(root.Integer("b", {}, 4), 4);
  EXPECT_EQ(root.OptionalInteger("b", {}), std::nullopt);
  EXPECT_TRUE(root.Bool("c", true));
  EXPECT_EQ(root.String("d", "x"), "x");
  EXPECT_EQ(root.OptionalString("d"), std::nullopt);
  EXPECT_EQ(root.Choice<int>("e", {{"rtu", 4}, {"tcp", 5}}, 4), 4);
  EXPECT_EQ(root.Path("f", "records"), "bench/records");
  EXPECT_EQ(root.OptionalPath("f"), std::nullopt);
  EXPECT_FALSE(root.OptionalTable("g"));
  EXPECT_TRUE(root.Tables("h").empty());
}

TEST(TomlReader, NamesFileLineKeyValueAndRangeOfANumber) {
  const auto root = Parse("\n[axis.inner]\nmax_rate_deg_s = -5\n");
  const auto inner = root.Table("axis").Table("inner");
  EXPECT_EQ(
      ErrorOf([&] {
        inner.Number("max_rate_deg_s", {0.001, 1000, "deg/s"});
      }),
      "bench/a.toml:3: axis.inner.max_rate_deg_s = -5: expected a number in 0.001 .. 1000 deg/s");
}

TEST(TomlReader, NamesTheRangeOfAWholeNumber) {
  EXPECT_EQ(ErrorOf([] {
              Parse("unit = 248").Integer("unit", {1, 247});
            }),
            "bench/a.toml:1: unit = 248: expected a whole number in 1 .. 247");
}

TEST(TomlReader, TakesTheEndsOfARange) {
  const auto root = Parse("low = -1.5\nhigh = 20\nfirst = 1\nlast = 4");
  EXPECT_EQ(root.Number("low", kRange), -1.5);
  EXPECT_EQ(root.Number("high", kRange), 20);
  EXPECT_EQ(root.Integer("first", {1, 4}), 1);
  EXPECT_EQ(root.Integer("last", {1, 4}), 4);
}

TEST(TomlReader, RefusesWhatIsNotANumber) {
  for (const char* value : {"nan", "-nan", "inf", "-inf", "\"5\"", "true", "[1]", "{ a = 1 }",
                            "2024-01-01", "20.001", "1e400"}) {
    EXPECT_THAT(ErrorOf([&] { Parse(std::string("x = ") + value).Number("x", kRange); }),
                StartsWith("bench/a.toml:1"))
        << value;
  }
  EXPECT_THAT(ErrorOf([] { Parse("x = nan").Number("x", {}); }), HasSubstr("x = nan"));
}

TEST(TomlReader, RefusesNanInsideAnArrayAndNamesItsPlace) {
  EXPECT_THAT(ErrorOf([] { Parse("x = [1,\n nan]").Numbers("x", kRange); }),
              AllOf(HasSubstr("a.toml:2"), HasSubstr("x[1] = nan")));
}

TEST(TomlReader, RefusesAFractionWhereAWholeNumberIsExpected) {
  EXPECT_THAT(ErrorOf([] { Parse("x = 2.0").Integer("x", {}); }),
              HasSubstr("x = 2.0: expected a whole number"));
}

TEST(TomlReader, NamesTheWordsToChooseFrom) {
  const auto error = ErrorOf([] {
    Parse("x = \"usb\"").Choice<int>("x", {{"rtu", 1}, {"tcp", 2}});
  });
  EXPECT_EQ(error, "bench/a.toml:1: x = \"usb\": expected one of \"rtu\", \"tcp\"");
  EXPECT_EQ(error, ErrorOf([] {
              Parse("x = \"usb\"").Choice<int>("x", {{"rtu", 1}, {"tcp", 2}}, 1);
            }));
}

TEST(TomlReader, RefusesAWrongTypeByNameOfTheRightOne) {
  EXPECT_THAT(ErrorOf([] { Parse("x = 1").Bool("x"); }), HasSubstr("expected true or false"));
  EXPECT_THAT(ErrorOf([] { Parse("x = 1").String("x"); }), HasSubstr("expected a text"));
  EXPECT_THAT(ErrorOf([] { Parse("x = \"\"").String("x"); }), HasSubstr("expected a text"));
  EXPECT_THAT(ErrorOf([] { Parse("x = 1").Path("x"); }), HasSubstr("expected a path"));
  EXPECT_THAT(ErrorOf([] { Parse("x = 1").Table("x"); }), HasSubstr("expected a table [x]"));
  EXPECT_THAT(ErrorOf([] { Parse("x = 1").Tables("x"); }), HasSubstr("expected tables [[x]]"));
  EXPECT_THAT(ErrorOf([] { Parse("x = [1]").Tables("x"); }), HasSubstr("expected tables [[x]]"));
  EXPECT_THAT(ErrorOf([] { Parse("x = \"a\\u0000b\"").Path("x"); }), HasSubstr("expected a path"));
}

TEST(TomlReader, NamesTheLengthOfAnArray) {
  EXPECT_THAT(ErrorOf([] {
                Parse("x = [1, 2]").Numbers("x", kRange, {3, 3});
              }),
              HasSubstr("x = [ 1, 2 ]: expected 3 numbers in -1.5 .. 20 deg/s"));
  EXPECT_THAT(ErrorOf([] { Parse("x = []").Strings("x", {1, 2}); }), HasSubstr("1 .. 2 texts"));
}

TEST(TomlReader, NamesTableAndLineOfAMissingKey) {
  const auto root = Parse("\n\n[gyro]\nunit = 21\n");
  EXPECT_EQ(ErrorOf([&] { root.Table("gyro").String("bus"); }),
            "bench/a.toml:3: gyro.bus is missing: expected a text that is not empty");
  EXPECT_THAT(ErrorOf([&] { root.Number("x", kRange); }),
              StartsWith("bench/a.toml:1: x is missing"));
}

TEST(TomlReader, PointsAtAMisspeltKeyWhereARequiredOneIsMissing) {
  EXPECT_THAT(ErrorOf([] { Parse("a = 1\nuint = 21").Integer("unit", {}); }),
              HasSubstr("unit is missing: expected a whole number (is \"uint\" in line 2 meant?)"));
}

TEST(TomlReader, RefusesAnUnknownKeyAndNamesTheNearestKnownOne) {
  const auto root = Parse("[axis.inner]\ngear_ratio = 40\nmax_rate = 60\n");
  const auto inner = root.Table("axis").Table("inner");
  inner.Number("gear_ratio", {});
  inner.Number("max_rate_deg_s", {}, 60);
  EXPECT_EQ(ErrorOf([&] { root.Finish(); }),
            "bench/a.toml:3: unknown key axis.inner.max_rate; did you mean \"max_rate_deg_s\"?");
}

TEST(TomlReader, RefusesAnUnknownTable) {
  const auto root = Parse("[gyro]\n[sight]\nlatitude_deg = 3\n");
  root.Table("gyro");
  root.OptionalTable("site");
  EXPECT_THAT(ErrorOf([&] { root.Finish(); }),
              HasSubstr("a.toml:2: unknown key sight; did you mean \"site\"?"));
}

TEST(TomlReader, RefusesAnUnknownKeyInAnArrayOfTables) {
  const auto root = Parse("[[fan]]\nat_s = 1\n[[fan]]\nat_ms = 1\n");
  for (const auto& fan : root.Tables("fan")) fan.Number("at_s", kRange, 0);
  EXPECT_THAT(ErrorOf([&] { root.Finish(); }),
              HasSubstr("a.toml:4: unknown key fan[1].at_ms; did you mean \"at_s\"?"));
}

TEST(TomlReader, SharesWhatWasAskedForBetweenHandlesOfOneTable) {
  const auto root = Parse("[a]\nx = 1\ny = 2\n");
  root.Table("a").Integer("x", {});
  root.Table("a").Integer("y", {});
  EXPECT_NO_THROW(root.Finish());
}

TEST(TomlReader, ListsWhatItExpectsAndWhatHoldsWithoutIt) {
  const auto root = Parse("[a]\nx = 1\n");
  root.Table("a").Number("x", kRange, 2.5);
  root.Table("a").OptionalNumber("y", {});
  std::vector<std::string> rows;
  for (const auto& key : root.KnownKeys()) {
    rows.push_back(key.name + "|" + key.expected + "|" + key.fallback);
  }
  EXPECT_THAT(rows, ElementsAre("a|a table [a]|required", "a.x|a number in -1.5 .. 20 deg/s|2.5",
                                "a.y|a number|optional"));
}

constexpr auto kReadThree = [](const TomlTable& root) {
  double sum = root.Number("a", kRange, 1.0) + root.Number("b", kRange, 2.0);
  if (sum > 20.0) root.Fail("a", "expected a + b of at most 20");
  if (root.Has("must")) sum += root.Table("must").Number("c", kRange);
  return sum;
};

TEST(TomlReader, NamesAllMistakesOfAFileAtOnce) {
  EXPECT_EQ(Parse("a = 3").ReadWhole(kReadThree), 5.0);
  const std::string error = ErrorOf(
      [] { Parse("a = 99\nx = 1\nb = \"two\"\n[must]\nc = 3\ny = 4").ReadWhole(kReadThree); });
  EXPECT_THAT(error, StartsWith("4 mistakes:\n"));
  for (const char* mistake :
       {"bench/a.toml:1: a = 99: expected a number in -1.5 .. 20 deg/s",
        "bench/a.toml:2: unknown key x", "bench/a.toml:3: b = \"two\": expected a number",
        "bench/a.toml:6: unknown key must.y"}) {
    EXPECT_THAT(error, HasSubstr(mistake));
  }
}

TEST(TomlReader, NamesNoMistakeThatOnlyFollowsFromAnother) {
  // Of a + b nothing can be said without a; that c is missing is not said of a c that is wrong.
  const auto error_of = [](std::string_view text) {
    return ErrorOf([&] { Parse(text).ReadWhole(kReadThree); });
  };
  EXPECT_EQ(error_of("a = 99\nb = 19.5"),
            "bench/a.toml:1: a = 99: expected a number in -1.5 .. 20 deg/s");
  EXPECT_EQ(error_of("[must]\nc = 99"),
            "bench/a.toml:2: must.c = 99: expected a number in -1.5 .. 20 deg/s");
  EXPECT_EQ(error_of("a = 19\nb = 19"), "bench/a.toml:1: a = 19: expected a + b of at most 20");
}

TEST(TomlReader, NamesTwentyMistakesAtMost) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += fmt::format("unknown{} = 1\n", i);
  const std::string error = ErrorOf([&] { Parse(text).ReadWhole(kReadThree); });
  EXPECT_THAT(error, StartsWith("the first 20 mistakes:\n"));
  EXPECT_EQ(std::ranges::count(error, '\n'), 20);
}

TEST(TomlReader, NamesLineAndColumnOfBadSyntax) {
  EXPECT_THAT(ErrorOf([] { Parse("a = 1\nb = = 2\n"); }),
              StartsWith("bench/a.toml:2, column 5: not valid TOML: "));
  EXPECT_THAT(ErrorOf([] { Parse("a = 1\na = 2\n"); }), StartsWith("bench/a.toml:2"));
  for (const char* comma : {"a = 1\nb =  -0,5  # deg\n", "a = 1\nb = -0,5", "a = 1\r\nb=-0,5\r\n"})
    EXPECT_THAT(ErrorOf([&] { Parse(comma); }), EndsWith("; write -0.5")) << comma;
  EXPECT_THAT(ErrorOf([] { Parse("a = 1,2,3\n"); }), Not(HasSubstr("write")));
}

TEST(TomlReader, SaysWhyAFileCannotBeRead) {
  const TestFolder folder;
  EXPECT_THAT(ErrorOf([&] { TomlTable::FromFile(folder.path() / "none.toml"); }),
              AllOf(HasSubstr("none.toml"), HasSubstr("No such file")));
  EXPECT_THAT(ErrorOf([&] { TomlTable::FromFile(folder.path()); }), HasSubstr("is a folder"));
}

// It ended the program: each part is a table within the one before.
TEST(TomlReader, RefusesAKeyOfEndlessParts) {
  const auto dotted = [](int parts) {
    std::string key = "a";
    for (int i = 1; i < parts; ++i) key += i % 2 == 0 ? ".a" : " . \"=\"";
    return key;
  };
  for (const std::string& text : {"\n" + dotted(50'000) + " = 1", "\n[" + dotted(50'000) + "]",
                                  "\nx = {" + dotted(50'000) + " = 1}"}) {
    EXPECT_THAT(ErrorOf([&] { Parse(text); }),
                HasSubstr("bench/a.toml:2: a key of more than 100 parts"));
  }
  EXPECT_NO_THROW(Parse(dotted(100) + " = 1\n# " + std::string(1000, '.') + "\nx = \"" +
                        std::string(1000, '.') + "\""));
  const std::string dots = "\nmany" + std::string(1000, '.') + "\nmore";
  for (const std::string quotes : {"\"\"\"", "'''"}) {
    std::string text = "x = ";
    text.append(quotes).append(dots).append(quotes).append("\ny = 1");
    EXPECT_NO_THROW(Parse(text));
  }
}

TEST(TomlReader, CutsALongValueInItsMessage) {
  const std::string text = "x = \"" + std::string(5000, 'y') + "\"";
  EXPECT_LT(ErrorOf([&] { Parse(text).Number("x", kRange); }).size(), 200u);
}

// Messages travel in JSON, which takes whole characters only.
TEST(TomlReader, CutsALongValueBetweenCharacters) {
  for (const char* pad : {"", "a", "aa", "aaa"}) {
    std::string text = std::string("x = \"") + pad;
    for (int i = 0; i < 50; ++i) text += "\u20ac";  // three bytes each
    const std::string error = ErrorOf([&] { Parse(text + "\"").Number("x", kRange); });
    EXPECT_NO_THROW(nlohmann::json(error).dump()) << error;
  }
}

class Includes : public testing::Test {
 protected:
  TestFolder folder_;
};

TEST_F(Includes, PutTheIncludingFileInFrontKeyByKey) {
  folder_.Write("base/base.toml", "name = \"base\"\nrate = 5\n[gyro]\nunit = 21\nfilter = 3\n");
  const auto file = folder_.Write(
      "top.toml", "include = \"base/base.toml\"\nname = \"top\"\n[gyro]\nfilter = 4\n");
  const auto root = TomlTable::FromFile(file);
  EXPECT_EQ(root.String("name"), "top");
  EXPECT_EQ(root.Number("rate", {}), 5);
  EXPECT_EQ(root.Table("gyro").Integer("unit", {}), 21);
  EXPECT_EQ(root.Table("gyro").Integer("filter", {}), 4);
  EXPECT_NO_THROW(root.Finish());
}

TEST_F(Includes, NameTheFileThatIsWrong) {
  folder_.Write("base/base.toml", "[gyro]\n\nunit = 999\n");
  const auto file = folder_.Write("top.toml", "include = \"base/base.toml\"\n[gyro]\nfilter = 9\n");
  const auto gyro = TomlTable::FromFile(file).Table("gyro");
  EXPECT_THAT(ErrorOf([&] {
                gyro.Integer("unit", {1, 247});
              }),
              HasSubstr("base/base.toml:3: gyro.unit"));
  EXPECT_THAT(ErrorOf([&] {
                gyro.Integer("filter", {0, 6});
              }),
              HasSubstr("/top.toml:3: gyro.filter"));
}

TEST_F(Includes, NameTheFileOfAnUnknownKey) {
  folder_.Write("base.toml", "[gyro]\nunti = 1\n");
  const auto file = folder_.Write("top.toml", "include = \"base.toml\"\n[gyro]\nunit = 9\n");
  const auto root = TomlTable::FromFile(file);
  root.Table("gyro").Integer("unit", {});
  EXPECT_THAT(ErrorOf([&] { root.Finish(); }),
              AllOf(HasSubstr("base.toml:2"), HasSubstr("\"unit\"")));
}

TEST_F(Includes, TakeARelativePathFromTheFileItStandsIn) {
  folder_.Write("base/base.toml", "map = \"m.toml\"\n");
  const auto root = TomlTable::FromFile(
      folder_.Write("top.toml", "include = \"base/base.toml\"\nrecords = \"r\"\n"));
  EXPECT_EQ(root.Path("map"), folder_.path() / "base/m.toml");
  EXPECT_EQ(root.Path("records"), folder_.path() / "r");
}

TEST_F(Includes, OfAMissingFileAreNamedByTheirLine) {
  const auto file = folder_.Write("top.toml", "\ninclude = \"none.toml\"\n");
  EXPECT_THAT(ErrorOf([&] { TomlTable::FromFile(file); }),
              AllOf(HasSubstr("top.toml:2: include = "), HasSubstr("No such file")));
}

TEST_F(Includes, MustNotGoInACircle) {
  folder_.Write("a.toml", "include = \"b.toml\"\n");
  const auto file = folder_.Write("b.toml", "include = \"a.toml\"\n");
  EXPECT_THAT(ErrorOf([&] { TomlTable::FromFile(file); }), HasSubstr("include each other"));
}

TEST_F(Includes, MustAgreeOnWhatIsATable) {
  folder_.Write("base.toml", "gyro = 1\n");
  const auto file = folder_.Write("top.toml", "include = \"base.toml\"\n[gyro]\n");
  EXPECT_THAT(ErrorOf([&] { TomlTable::FromFile(file).Table("gyro"); }),
              HasSubstr("base.toml:1: gyro = 1: expected a table"));
}

TEST(EditDistance, IsAMetricOnWords) {
  const std::vector<std::string> words = {"",     "a",    "ab",    "ba",
                                          "unit", "uint", "units", "gear_ratio"};
  for (const auto& a : words) {
    EXPECT_EQ(EditDistance(a, ""), static_cast<int>(a.size()));
    for (const auto& b : words) {
      EXPECT_EQ(EditDistance(a, b), EditDistance(b, a));
      EXPECT_EQ(EditDistance(a, b) == 0, a == b);
    }
  }
  EXPECT_EQ(EditDistance("unit", "uint"), 1);
  EXPECT_EQ(EditDistance("unit", "units"), 1);
}

TEST(Suggestion, ListsAllKeysWhenNoneIsNear) {
  EXPECT_THAT(Suggestion("colour", {"bus", "unit"}), HasSubstr("known here: \"bus\", \"unit\""));
  EXPECT_THAT(Suggestion("colour", {"bus", "unit"}), Not(HasSubstr("did you mean")));
  EXPECT_THAT(Suggestion("uint", {"bus", "unit"}), Not(HasSubstr("known here")));
  // As near as "site" is to "sight", and nothing that anybody would call it.
  EXPECT_THAT(Suggestion("history", {"runs", "stop"}), Not(HasSubstr("did you mean")));
  EXPECT_THAT(Suggestion("list", {"runs", "reset"}), Not(HasSubstr("did you mean")));
}

}  // namespace
}  // namespace gyrobench::config
