#include "report/number.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace gyrobench::report {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string Plain(std::string text) {
  for (const std::string space : {"\u202F", "\u2007", "\u2008"}) {
    for (std::size_t at; (at = text.find(space)) != std::string::npos;) {
      text.erase(at, space.size());
    }
  }
  if (text.rfind("−", 0) == 0) text = "-" + text.substr(std::string("−").size());
  return text;
}

std::size_t Decimals(const std::string& text) {
  const std::size_t point = text.find('.');
  return point == std::string::npos ? 0 : text.size() - point - 1;
}

// What is printed, read again, is the value to half a unit of the last place of its error.
TEST(RoundTogether, LosesLessThanATwentiethOfTheError) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> mantissa(-10.0, 10.0), power(-9.0, 5.0), ratio(-5.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const double value = mantissa(random) * std::pow(10.0, power(random));
    const double error = std::abs(value) * std::pow(10.0, ratio(random));
    const Measured printed = RoundTogether(value, error, error);
    const double scale = std::pow(10.0, printed.power);
    EXPECT_NEAR(std::stod(Plain(printed.value)) * scale, value, 0.051 * error) << printed.value;
    EXPECT_NEAR(std::stod(Plain(printed.error)) * scale, error, 0.051 * error) << printed.error;
    EXPECT_EQ(Decimals(printed.value), Decimals(printed.error));
    EXPECT_EQ(printed.error, printed.bound);
    EXPECT_EQ(printed.power % 3, 0);
  }
}

TEST(RoundTogether, SaysSoWhereANumberIsMissing) {
  EXPECT_EQ(RoundTogether(kNaN, 0.1, 0.1).value, "–");
  EXPECT_EQ(RoundTogether(1.0, kNaN, kNaN).error, "–");
  EXPECT_EQ(RoundTogether(kNaN, kNaN, kNaN).bound, "–");
}

TEST(FormatMeasured, WritesValueAndErrorToOnePlace) {
  EXPECT_EQ(FormatMeasured(7.6204, 0.0313, "ms"), "7.620 ± 0.031 ms");
  EXPECT_EQ(FormatMeasured(-1.2346e-7, 1.2e-9, "deg"), "(−123.5 ± 1.2) × 10⁻⁹ deg");
  EXPECT_EQ(FormatMeasured(0.99996, 0.0996, ""), "1.00 ± 0.10");
}

TEST(FormatNumber, KeepsTheDigitsAskedFor) {
  EXPECT_EQ(FormatNumber(0.15, 3), "0.150");
  EXPECT_EQ(FormatNumber(9.996, 3), "10.0");
  EXPECT_EQ(FormatNumber(-1.03e-4, 3), "−1.03 × 10⁻⁴");
  EXPECT_EQ(FormatNumber(0.0, 3), "0.00");
  EXPECT_EQ(FormatNumber(kNaN), "–");
  EXPECT_EQ(FormatNumber(std::numeric_limits<double>::infinity()), "∞");
}

TEST(FormatPValue, NeverSaysZero) {
  EXPECT_EQ(FormatPValue(0.0), "p < 10⁻¹⁶");
  EXPECT_EQ(FormatPValue(3.4e-9), "p = 3 × 10⁻⁹");
  EXPECT_EQ(FormatPValue(0.0021), "p = 0.0021");
  EXPECT_EQ(FormatPValue(kNaN), "p not estimated");
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
  EXPECT_EQ(FormatUtc(0), "–");
}

}  // namespace
}  // namespace gyrobench::report
