#include "procedures/engine/procedure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <limits>

#include "procedures/engine/sandbox.h"
#include "procedures/engine/text.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

Procedure Declared(const std::string& fields) {
  return Procedure::FromSource("d", "d.lua", "procedure = { " + fields + " } function run(p) end");
}

Procedure WithParameter(const std::string& fields) {
  return Declared("summary = 's', parameters = { { name = 'x', help = 'h', " + fields + " } }");
}

std::string ParameterFailure(const Procedure& procedure, const Value& value) {
  return MessageOf<ParameterError>([&] { CheckParameters(procedure.info(), {{"x", value}}); });
}

TEST(Declaration, GivesEveryFieldOfAParameter) {
  const Procedure procedure = Declared(
      "summary = 'sum', description = 'des', measures = { 'scale', 'bias' }, parameters = { "
      "{ name = 'rate_deg_s', type = 'number', default = 2, unit = 'deg/s', min = 1, max = 3, "
      "help = 'hel' }, { name = 'c', type = 'choice', default = 'b', choices = { 'a', 'b' }, "
      "help = 'h2' } }");
  const ProcedureInfo& info = procedure.info();
  EXPECT_EQ(info.name, "d");
  EXPECT_EQ(info.summary, "sum");
  EXPECT_EQ(info.description, "des");
  EXPECT_THAT(info.measures, ElementsAre("scale", "bias"));
  ASSERT_EQ(info.parameters.size(), 2U);
  const Parameter& rate = info.parameters[0];
  EXPECT_EQ(rate.name, "rate_deg_s");
  EXPECT_EQ(rate.type, ParameterType::kNumber);
  EXPECT_EQ(rate.default_value, Value(2.0));
  EXPECT_EQ(rate.unit, "deg/s");
  EXPECT_EQ(rate.min, 1.0);
  EXPECT_EQ(rate.max, 3.0);
  EXPECT_EQ(rate.help, "hel");
  EXPECT_THAT(info.parameters[1].choices, ElementsAre("a", "b"));
  EXPECT_THAT(procedure.source(), StartsWith("procedure = { summary = 'sum'"));
}

TEST(Declaration, FaultsAreNamedByField) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "procedure: summary is missing"},
      {"summary = 5", "procedure: summary = 5: expected a text"},
      {"summary = 's', sumary = 's'", "unknown field \"sumary\" (did you mean summary?)"},
      {"summary = 's', measures = { 'scal' }", "\"scal\" is not known (did you mean scale?)"},
      {"summary = 's', parameters = 5", "procedure.parameters = 5: expected a list of tables"},
      {"summary = 's', parameters = { 5 }", "procedure.parameters[1]: expected a table"},
      {"summary = 's', parameters = { { } }", "procedure.parameters[1]: name is missing"},
  };
  for (const auto& [fields, message] : cases) {
    EXPECT_THAT(MessageOf<ScriptError>([&] { Declared(fields); }),
                AllOf(StartsWith("d.lua: "), HasSubstr(message)))
        << fields;
  }
}

TEST(Declaration, FaultsOfAParameterAreNamed) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"type = 'float', default = 1", "type = \"float\": expected \"number\""},
      {"type = 'number'", "default is missing: every parameter has a default"},
      {"type = 'number', default = 5, max = 4", "parameter x = 5: expected a number, 4 or less"},
      {"type = 'number', default = '5'", "default = \"5\": expected a number"},
      {"type = 'number', default = 1, min = 2, max = 1", "min = 2 is above max = 1"},
      {"type = 'integer', default = 1.5", "expected a whole number"},
      {"type = 'choice', default = 'a'", "needs at least one"},
      {"type = 'text', default = 'a', choices = { 'a' }", "choices belong to"},
      {"type = 'text', default = 'a', min = 1", "min and max belong to a number"},
      {"type = 'choice', default = 'c', choices = { 'a', 'b' }", "expected one of a, b"},
      {"type = 'boolean', default = 1", "expected true or false"},
  };
  for (const auto& [fields, message] : cases) {
    EXPECT_THAT(MessageOf<ScriptError>([&] { WithParameter(fields); }), HasSubstr(message))
        << fields;
  }
}

TEST(Declaration, WhatCannotBeAProcedureIsRefused) {
  const auto refusal = [](const std::string& source) {
    return MessageOf<ScriptError>([&] { Procedure::FromSource("d", "d.lua", source); });
  };
  EXPECT_THAT(refusal(""), HasSubstr("`procedure = {"));
  EXPECT_THAT(refusal("procedure = { summary = 's' }"), HasSubstr("`run(p)` is missing"));
  EXPECT_THAT(refusal("procedure = {\n summary = \n}"), StartsWith("d.lua:3: unexpected symbol"));
  EXPECT_THAT(refusal("\nbench.rest{duration_s=1}"), StartsWith("d.lua:2: bench commands can be"));
  EXPECT_THAT(refusal("-- \xff"), HasSubstr("UTF-8"));
  EXPECT_THAT(refusal(std::string(2 << 20, ' ')), HasSubstr("at most 1 MB"));
  EXPECT_THROW(Procedure::FromSource("a/b", "b.lua", ""), ScriptError);
}

TEST(Parameters, OutOfRangeNamesParameterValueUnitAndRange) {
  const Procedure procedure =
      WithParameter("type = 'number', default = 20, unit = 'deg/s', min = 0.5, max = 60");
  EXPECT_EQ(ParameterFailure(procedure, 90.0),
            "d: parameter x = 90 deg/s: expected a number, 0.5 .. 60 deg/s");
  EXPECT_NE(ParameterFailure(procedure, std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_NE(ParameterFailure(procedure, "fast"), "");
  EXPECT_NE(ParameterFailure(procedure, true), "");
  EXPECT_EQ(ParameterFailure(procedure, 0.5), "");
  EXPECT_EQ(ParameterFailure(procedure, 60.0), "");
}

TEST(Parameters, IntegersAreWhole) {
  const Procedure procedure = WithParameter("type = 'integer', default = 2, min = 1");
  EXPECT_EQ(ParameterFailure(procedure, 2.5),
            "d: parameter x = 2.5: expected a whole number, 1 or more");
  EXPECT_NE(ParameterFailure(procedure, 1e300), "");
  EXPECT_EQ(ParameterFailure(procedure, 3.0), "");
}

TEST(Parameters, TextOfACommandLineIsReadAsTheDeclaredType) {
  const auto read = [](const std::string& fields, const std::string& text) {
    return CheckParameters(WithParameter(fields).info(), {{"x", text}}).at("x");
  };
  EXPECT_EQ(read("type = 'number', default = 1", "-2.5e1"), Value(-25.0));
  EXPECT_EQ(read("type = 'integer', default = 1", "40"), Value(40.0));
  EXPECT_EQ(read("type = 'boolean', default = false", "true"), Value(true));
  EXPECT_EQ(read("type = 'text', default = ''", "40"), Value("40"));
  for (const char* bad : {"", "4x", " 4", "0x10", "nan", "inf", "1,5"}) {
    EXPECT_THROW(read("type = 'number', default = 1", bad), ParameterError) << bad;
  }
}

TEST(Parameters, ARefusalShowsHowWhatWasMeantIsWritten) {
  const Procedure number = WithParameter("type = 'number', default = 1");
  EXPECT_THAT(ParameterFailure(number, "0,5"), EndsWith("expected a number; write 0.5"));
  EXPECT_THAT(ParameterFailure(number, "1,5,2"), EndsWith("expected a number"));
  const Procedure list = WithParameter("type = 'numbers', default = '1', min = 0.5");
  for (const char* apart : {"1;2;3", "1 2 3", "1; 2 ;3"})
    EXPECT_THAT(ParameterFailure(list, apart), EndsWith("; write 1,2,3")) << apart;
  EXPECT_THAT(ParameterFailure(list, "0,7"), EndsWith("is one number meant? Write 0.7"));
  EXPECT_THAT(ParameterFailure(list, "1;two"), EndsWith("0.5 or more"));
}

TEST(Parameters, UnknownOnesAreRefusedWithTheNearest) {
  const Procedure procedure = WithParameter("type = 'number', default = 1");
  EXPECT_EQ(MessageOf<ParameterError>([&] {
              CheckParameters(procedure.info(), {{"y", 1.0}});
            }),
            "d: there is no parameter \"y\" (did you mean x?); parameters: x");
}

TEST(Parameters, AreCompletedWithDefaults) {
  const Procedure procedure = WithParameter("type = 'number', default = 7");
  EXPECT_EQ(CheckParameters(procedure.info(), {}), (Parameters{{"x", 7.0}}));
}

class Library : public ::testing::Test {
 protected:
  Library() {
    std::string pattern = ::testing::TempDir() + "proceduresXXXXXX";
    root_ = mkdtemp(pattern.data());
  }
  ~Library() override { std::filesystem::remove_all(root_); }

  void Write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  ProcedureLibrary Open() const {
    return ProcedureLibrary({root_ / "one", root_ / "missing", root_ / "two"});
  }

  std::filesystem::path root_;
};

std::string Simple(const std::string& summary) {
  return "procedure = { summary = '" + summary + "' } function run(p) end";
}

TEST_F(Library, ListsByNameAndTheFirstDirectoryWins) {
  Write("two/b.lua", Simple("second b"));
  Write("one/b.lua", Simple("first b"));
  Write("two/a.lua", Simple("a"));
  Write("one/notes.txt", "no procedure");
  const auto list = Open().List();
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].summary, "a");
  EXPECT_EQ(list[1].summary, "first b");
  EXPECT_EQ(list[1].file, root_ / "one/b.lua");
}

TEST_F(Library, ABrokenScriptIsListedWithItsProblemAndHurtsNoOther) {
  Write("one/bad.lua", "procedure = {\n(");
  Write("one/loop.lua", "while true do end");
  Write("one/no name.lua", Simple("x"));
  Write("one/good.lua", Simple("good"));
  std::filesystem::create_directory(root_ / "one/folder.lua");
  // It has no other end, and would be waited for for ever.
  ASSERT_EQ(mkfifo((root_ / "one/pipe.lua").c_str(), 0600), 0);
  const auto list = Open().List();
  ASSERT_EQ(list.size(), 6U);
  EXPECT_THAT(list[0].problem, StartsWith("bad.lua:2:"));
  EXPECT_THAT(list[1].problem, HasSubstr("cannot be read"));
  EXPECT_EQ(list[2].problem, "");
  EXPECT_THAT(list[3].problem, StartsWith("loop.lua:1:"));
  EXPECT_THAT(list[4].problem, HasSubstr("name consists of"));
  EXPECT_THAT(list[5].problem, HasSubstr("expected a file"));
}

TEST_F(Library, FindsByNameAndSuggestsTheNearest) {
  Write("one/scale.lua", Simple("x"));
  Write("two/bias.lua", Simple("y"));
  EXPECT_EQ(Open().Find("bias").info().summary, "y");
  EXPECT_THAT(MessageOf<UnknownProcedure>([&] { Open().Find("scael"); }),
              AllOf(HasSubstr("no procedure \"scael\" (did you mean scale?); known: bias, scale"),
                    HasSubstr((root_ / "two").string())));
  EXPECT_THROW(Open().Find("../one/scale"), UnknownProcedure);
  EXPECT_THROW(Open().Find(""), UnknownProcedure);
}

TEST_F(Library, SeesAnEditedScriptWithoutARestart) {
  const ProcedureLibrary library = Open();
  Write("one/a.lua", Simple("before"));
  EXPECT_EQ(library.Find("a").info().summary, "before");
  Write("one/a.lua", Simple("after"));
  EXPECT_EQ(library.Find("a").info().summary, "after");
}

TEST_F(Library, ABrokenScriptIsRefusedWithFileAndLine) {
  Write("one/bad.lua", "procedure = {\n(");
  EXPECT_THAT(MessageOf<ScriptError>([&] { Open().Find("bad"); }), StartsWith("bad.lua:2:"));
}

TEST(Text, KnowsWellFormedUtf8) {
  for (const char* good :
       {"", "abc", "\xc2\xb0", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xed\x9f\xbf"}) {
    EXPECT_TRUE(IsText(good)) << good;
  }
  for (const char* bad : {"\xff", "\xc0\xaf", "\xe2\x82", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                          "\xf0\x80\x80\x80", "\xe0\x80\x80", "\x80", "\xc2 "}) {
    EXPECT_FALSE(IsText(bad));
  }
  EXPECT_FALSE(IsText(std::string_view("a\0b", 3)));
}

}  // namespace
}  // namespace gyrobench::procedures
