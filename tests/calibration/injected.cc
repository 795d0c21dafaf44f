#include "tests/calibration/injected.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobench::testing {

using calibration::ChannelTrace;
using calibration::ModelParameter;
using calibration::TracedEffect;

Injection Rate(std::function<double(const BenchState&)> rate) { return {std::move(rate), {}, {}}; }
Injection Angle(std::function<double(const BenchState&)> angle) {
  return {{}, std::move(angle), {}};
}
Injection Latency(const SyntheticBench&) {
  return {{}, {}, [](double t_s) { return t_s + 0.012; }};
}

void ExpectWithinItsInterval(const std::vector<ModelParameter>& parameters,
                             const Expected& expected) {
  constexpr double kStdErrors = 4.0;
  const auto found = std::ranges::find(parameters, expected.name, &ModelParameter::name);
  ASSERT_NE(found, parameters.end()) << "no parameter " << expected.name;
  if (expected.within > 0.0) {
    EXPECT_NEAR(found->value, expected.value, expected.within) << expected.name;
    return;
  }
  // An interval that holds nothing as well says nothing.
  EXPECT_LT(kStdErrors * found->std_error, std::fabs(expected.value)) << expected.name;
  EXPECT_NEAR(found->value, expected.value, kStdErrors * found->std_error)
      << expected.name << ": off by " << (found->value - expected.value) / found->std_error
      << " standard errors";
}

std::vector<std::string> NamesOf(const ChannelTrace& channel) {
  std::vector<std::string> names;
  for (const TracedEffect& effect : channel.effects) names.push_back(effect.id);
  return names;
}

}  // namespace gyrobench::testing
