// What `gyrobench effects` shows of the catalogue, by formulas of its own.
#include "calibration/plan/effect_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace gyrobench::calibration {
namespace {

const EffectGallery& Gallery() {
  static const EffectGallery gallery;
  return gallery;
}

double LargestOf(const EffectPicture& picture) {
  double largest = 0.0;
  for (const double y : picture.y) largest = std::max(largest, std::fabs(y));
  return largest;
}

TEST(EffectPicture, IsThereForEveryEffectOfTheCatalogue) {
  for (const Effect& effect : EffectCatalogue()) {
    const EffectPicture picture = Gallery().PictureOf(effect);
    ASSERT_EQ(picture.x.size(), picture.y.size());
    EXPECT_GT(picture.x.size(), 1000U) << effect.id;
    EXPECT_TRUE(std::ranges::all_of(picture.x, [](double x) { return std::isfinite(x); }))
        << effect.id;
    EXPECT_TRUE(std::ranges::all_of(picture.y, [](double y) { return std::isfinite(y); }))
        << effect.id;
    EXPECT_GT(LargestOf(picture), 1e-5) << effect.id << ", " << picture.y_label;
    EXPECT_FALSE(picture.x_label.empty() || picture.y_label.empty());
  }
}

// A scale factor by another name.
class OwnRate final : public Basis {
 public:
  void At(const SensorState& point, double* terms) override { terms[0] = point.rate_deg_s[2]; }
};

TEST(EffectPicture, HasNothingOfWhatTheBaselineDescribes) {
  const Effect effect = {.id = "of_the_test",
                         .needs = kNeedsRate,
                         .terms = {{"c", "1"}},
                         .typical_size = 0.01,
                         .basis = [](const BasisContext&) -> std::unique_ptr<Basis> {
                           return std::make_unique<OwnRate>();
                         }};
  EXPECT_LT(LargestOf(Gallery().PictureOf(effect)), 1e-9);
}

// c |w| is the same both ways: a rate error that is as large forwards as backwards, less its mean.
TEST(EffectPicture, ShowsAnAsymmetryAsARoofOverTheRate) {
  const Effect& effect = *FindEffect("scale.asymmetry");
  const EffectPicture picture = Gallery().PictureOf(effect);
  const auto mean_at = [&](double rate_deg_s) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < picture.x.size(); ++i) {
      if (std::fabs(picture.x[i] - rate_deg_s) > 0.2) continue;
      sum += picture.y[i];
      count += 1.0;
    }
    return sum / count;
  };
  for (const double rate_deg_s : {12.0, 18.0, 36.0}) {
    const double expected_deg_s = effect.typical_size * (rate_deg_s - 6.0);
    EXPECT_NEAR(mean_at(rate_deg_s) - mean_at(6.0), expected_deg_s, 0.02 * expected_deg_s);
    EXPECT_NEAR(mean_at(-rate_deg_s) - mean_at(-6.0), expected_deg_s, 0.02 * expected_deg_s);
  }
}

TEST(EffectPicture, NamesAsRivalsWhatDoesNearlyTheSame) {
  EXPECT_THAT(Gallery().RivalsOf(*FindEffect("scale.cubic")),
              testing::Contains("scale.quadratic_odd"));
  EXPECT_THAT(Gallery().RivalsOf(*FindEffect("angle.latency")),
              testing::Contains("bandwidth.first_order"));
  EXPECT_THAT(Gallery().RivalsOf(*FindEffect("scale.temperature")),
              testing::Not(testing::Contains("scale.cubic")));
}

}  // namespace
}  // namespace gyrobench::calibration
