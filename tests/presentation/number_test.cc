#include "presentation/number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <regex>

#include "base/measurement.h"

namespace gyrobench::presentation {
namespace {

struct Written {
  double value = 0.0, std_error = 0.0;
  std::string value_text, error_text;
};

// Reads "a ± b" and "(a ± b)e-07" again.
Written Read(const std::string& text) {
  static const std::regex kForm(R"(\(?(-?[0-9.]+) ± ([0-9.]+)(?:\)(e[+-][0-9]+))?)");
  std::smatch match;
  if (!std::regex_match(text, match, kForm)) ADD_FAILURE() << "not a measured value: " << text;
  const std::string power = match[3];
  return {std::stod(match[1].str() + power), std::stod(match[2].str() + power), match[1], match[2]};
}

std::string Decimals(const std::string& text) {
  const std::size_t point = text.find('.');
  return point == std::string::npos ? "" : text.substr(point + 1);
}

struct Sample {
  double value, std_error;
};

std::vector<Sample> RandomSamples() {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-12.0, 9.0), ratio(0.0, 8.0), sign(-1.0, 1.0);
  std::vector<Sample> samples;
  for (int i = 0; i < 2000; ++i) {
    const double size = std::pow(10.0, exponent(random));
    samples.push_back({std::copysign(size, sign(random)), size * std::pow(10.0, -ratio(random))});
  }
  return samples;
}

TEST(FormatMeasured, KeepsTheStandardErrorToTwoDigits) {
  for (const Sample& s : RandomSamples()) {
    const Written written = Read(FormatMeasured(s.value, s.std_error));
    EXPECT_NEAR(written.std_error, s.std_error, 0.05 * s.std_error * 1.0001);
  }
}

// Rounding may cost the value at most half of the last digit of its own uncertainty.
TEST(FormatMeasured, MovesTheValueByLessThanATwentiethOfItsStandardError) {
  for (const Sample& s : RandomSamples()) {
    const Written written = Read(FormatMeasured(s.value, s.std_error));
    EXPECT_NEAR(written.value, s.value, 0.0501 * s.std_error)
        << FormatMeasured(s.value, s.std_error);
  }
}

TEST(FormatMeasured, WritesBothToTheSameDecimalPlace) {
  for (const Sample& s : RandomSamples()) {
    const Written written = Read(FormatMeasured(s.value, s.std_error));
    EXPECT_EQ(Decimals(written.value_text).size(), Decimals(written.error_text).size());
  }
}

TEST(FormatMeasured, SaysTheSameOfWhatItHasWritten) {
  for (const Sample& s : RandomSamples()) {
    const std::string text = FormatMeasured(s.value, s.std_error);
    const Written written = Read(text);
    EXPECT_EQ(FormatMeasured(written.value, written.std_error), text);
  }
}

TEST(FormatMeasured, ChangesOnlyTheSignWithTheSign) {
  for (const Sample& s : RandomSamples()) {
    const Written plus = Read(FormatMeasured(std::abs(s.value), s.std_error));
    const Written minus = Read(FormatMeasured(-std::abs(s.value), s.std_error));
    EXPECT_EQ("-" + plus.value_text, minus.value_text);
    EXPECT_EQ(plus.error_text, minus.error_text);
  }
}

TEST(FormatMeasured, WritesAsALaboratoryDoes) {
  EXPECT_EQ(FormatMeasured(0.0076204, 0.0000313), "0.007620 ± 0.000031");
  EXPECT_EQ(FormatMeasured(12345.6, 234.5), "12350 ± 230");
  EXPECT_EQ(FormatMeasured(0.0, 0.5), "0.00 ± 0.50");
  // The second digit of an error that rounds up to a power of ten is still there.
  EXPECT_EQ(FormatMeasured(1.0, 0.0999), "1.00 ± 0.10");
  EXPECT_EQ(FormatMeasured(1.23456e-7, 1.2e-10), "(1.2346 ± 0.0012)e-07");
}

TEST(FormatMeasured, WritesAValueWithoutStandardErrorAlone) {
  EXPECT_EQ(FormatMeasured(0.25, kMissing), "0.25");
  EXPECT_EQ(FormatMeasured(0.25, 0.0), "0.25");
  EXPECT_EQ(FormatMeasured(0.25, HUGE_VAL), "0.25");
}

// A missing value must never look like a number.
TEST(FormatNumber, ShowsAMissingValueAsADash) {
  EXPECT_EQ(FormatNumber(kMissing), "-");
  EXPECT_EQ(FormatMeasured(kMissing, 0.1), "-");
  EXPECT_EQ(WithUnit("-", "deg"), "-");
  EXPECT_EQ(WithUnit("1.5", "deg"), "1.5 deg");
}

TEST(FormatDuration, ChangesUnitsWithoutEverShowingSixtyOfOne) {
  EXPECT_EQ(FormatDuration(0.25), "0.25 s");
  EXPECT_EQ(FormatDuration(59.96), "1 min 00 s");
  EXPECT_EQ(FormatDuration(3599.6), "1 h 00 min");
  EXPECT_EQ(FormatDuration(3 * 3600 + 125), "3 h 02 min");
  EXPECT_EQ(FormatDuration(kMissing), "unknown");
  const std::regex sixty("(^| )60 (s|min)");
  for (double s = 0.1; s < 1e6; s *= 1.003) {
    EXPECT_FALSE(std::regex_search(FormatDuration(s), sixty)) << FormatDuration(s);
  }
}

TEST(FormatCount, GroupsByThousands) {
  EXPECT_EQ(FormatCount(0), "0");
  EXPECT_EQ(FormatCount(999), "999");
  EXPECT_EQ(FormatCount(1234567), "1 234 567");
  EXPECT_EQ(FormatCount(-1000), "-1 000");
}

TEST(FormatFigure, KeepsThreeDigitsAndTheirZeros) {
  EXPECT_EQ(FormatFigure(0.15), "0.150");
  EXPECT_EQ(FormatFigure(9.996), "10.0");
  EXPECT_EQ(FormatFigure(-1.03e-7), "-1.03e-07");
  EXPECT_EQ(FormatFigure(0.0), "0.00");
  EXPECT_EQ(FormatFigure(kMissing), "-");
}

TEST(FormatRatio, TellsFiguresThatAreCloseToOneApart) {
  EXPECT_EQ(FormatRatio(1.0082), "1.008");
  EXPECT_EQ(FormatRatio(32.08), "32.1");
}

TEST(FormatPValue, NeverSaysZero) {
  EXPECT_EQ(FormatPValue(0.0), "p < 1e-16");
  EXPECT_EQ(FormatPValue(3.4e-9), "p = 3.4e-09");
  EXPECT_EQ(FormatPValue(0.0021), "p = 0.0021");
  EXPECT_EQ(FormatPValue(kMissing), "p not known");
}

// Typeset and read again, by the characters that a page has in place of ASCII.
std::string Plain(std::string text) {
  const std::pair<const char*, const char*> signs[] = {{"\u00A0×\u00A010", "e"},
                                                       {"\u00A0", " "},
                                                       {"−", "-"},
                                                       {"⁻", "-"},
                                                       {"⁰", "0"},
                                                       {"¹", "1"},
                                                       {"²", "2"},
                                                       {"³", "3"},
                                                       {"⁴", "4"},
                                                       {"⁵", "5"},
                                                       {"⁶", "6"},
                                                       {"⁷", "7"},
                                                       {"⁸", "8"},
                                                       {"⁹", "9"}};
  for (const auto& [from, to] : signs) {
    for (std::size_t at; (at = text.find(from)) != std::string::npos;)
      text.replace(at, std::string(from).size(), to);
  }
  return text;
}

TEST(Typeset, ChangesNoNumber) {
  for (const Sample& s : RandomSamples()) {
    const std::string text = FormatMeasured(s.value, s.std_error);
    const std::regex power("e([+-])0*([1-9])");
    const std::string plain = std::regex_replace(text, power, "e$1$2");
    EXPECT_EQ(Plain(Typeset(text)), std::regex_replace(plain, std::regex("e\\+"), "e"));
  }
}

TEST(Typeset, WritesAsABookDoes) {
  EXPECT_EQ(Typeset("(-1.235 ± 0.012)e-07"), "(−1.235\u00A0±\u00A00.012)\u00A0×\u00A010⁻⁷");
  EXPECT_EQ(Typeset("p < 1e-16"), "p\u00A0<\u00A01\u00A0×\u00A010⁻¹⁶");
  EXPECT_EQ(Typeset("-"), "–");
  EXPECT_EQ(Typeset("not seen"), "not\u00A0seen");
  EXPECT_EQ(TypesetUnit("deg/s/degC^2"), "deg/s/degC²");
  EXPECT_EQ(TypesetUnit("deg/s/sqrt(s)"), "deg/s/√s");
}

TEST(AlignDecimals, PutsAllPointsAtOneDistanceFromTheEnd) {
  std::vector<std::string> texts = {"1.25", "−31", "0.5", "–"};
  AlignDecimals(texts);
  EXPECT_EQ(texts[0], "1.25");
  EXPECT_EQ(texts[1], "−31\u2008\u2007\u2007");
  EXPECT_EQ(texts[2], "0.5\u2007");
  EXPECT_EQ(texts[3], "–\u2008\u2007\u2007");
}

TEST(FormatUtc, WritesTheTimeOfTheEpoch) {
  EXPECT_EQ(FormatUtc(1'000'000), "1970-01-01 00:00:01 UTC");
  EXPECT_EQ(FormatUtc(0), "-");
}

TEST(TypesetPowers, WritesNumbersAmongWordsAndLeavesPartsOfWords) {
  EXPECT_EQ(TypesetPowers("not white (p = 1.7e-04): 3e+08, -2.5e-07."),
            "not white (p = 1.7\u00A0×\u00A010⁻⁴): 3\u00A0×\u00A010⁸, −2.5\u00A0×\u00A010⁻⁷.");
  for (const char* as_it_is : {"1e-04.csv", "run1e-04", "3e-05f7", "a-b 1 - 2", ""})
    EXPECT_EQ(TypesetPowers(as_it_is), as_it_is);
}

TEST(UnitInName, IsWhatTheNameEndsIn) {
  EXPECT_EQ(UnitInName("rate_deg_s"), "deg/s");
  EXPECT_EQ(UnitInName("angle_deg"), "deg");
  EXPECT_EQ(UnitInName("initial_rest_s"), "s");
  EXPECT_EQ(UnitInName("frequencies_hz"), "Hz");
  EXPECT_EQ(UnitInName("axes"), "");
}

}  // namespace
}  // namespace gyrobench::presentation
