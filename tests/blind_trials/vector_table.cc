#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/blind_trials/vector_trial.h"

namespace gyrobench::blind_trials {
namespace {

constexpr double kNormal95 = 1.959964;

struct Figures {
  double over_bound = 0.0, bounds = 0.0;  // squares of error / bound, and how many
  double over_error = 0.0, stated = 0.0;
  double size = 0.0;  // sum of standard errors
  int covered = 0, missing = 0;

  void Add(const StatedNumber& number) {
    const double error = number.estimate - number.truth;
    if (!std::isfinite(error) || !(number.std_error > 0.0)) {
      ++missing;
      return;
    }
    over_error += std::pow(error / number.std_error, 2);
    size += number.std_error;
    stated += 1.0;
    covered += std::fabs(error) <= kNormal95 * number.std_error ? 1 : 0;
    if (!(number.bound > 0.0)) return;
    over_bound += std::pow(error / number.bound, 2);
    bounds += 1.0;
  }
  std::string Text() const {
    const std::string bound =
        bounds > 0.0 ? fmt::format("{:.3f}", std::sqrt(over_bound / bounds)) : "-";
    return fmt::format("{:>9.2g} {:>9} {:>9.3f} {:>8.1f} % {:>6} {:>7}\n", size / stated, bound,
                       std::sqrt(over_error / stated), 100.0 * covered / stated, stated, missing);
  }
};

// In the order in which they come.
class Lines {
 public:
  Figures& At(const std::string& name) {
    for (auto& [known, figures] : lines_)
      if (known == name) return figures;
    return lines_.emplace_back(name, Figures()).second;
  }
  std::string Text() const {
    std::string text;
    for (const auto& [name, figures] : lines_) text += fmt::format("{:<24}", name) + figures.Text();
    return text;
  }

 private:
  std::vector<std::pair<std::string, Figures>> lines_;
};

std::string Head(const char* what) {
  return fmt::format("\n{:<24}{:>9} {:>9} {:>9} {:>10} {:>6} {:>7}\n", what, "std error",
                     "rms/bound", "rms/error", "95 % holds", "n", "unknown");
}

std::string Elsewhere(const std::vector<VectorOutcome>& outcomes) {
  double sum = 0.0, worst = 0.0, count = 0.0, over = 0.0;
  for (const VectorOutcome& outcome : outcomes) {
    for (const double rms : outcome.elsewhere_whitened_rms) {
      if (!std::isfinite(rms)) continue;
      sum += rms;
      count += 1.0;
      worst = std::max(worst, rms);
      over += rms > 1.02 ? 1.0 : 0.0;
    }
  }
  return fmt::format("{:.4f} in the mean, {:.4f} at worst, {} of {} beyond 1.02\n", sum / count,
                     worst, over, count);
}

}  // namespace

std::string VectorTable(const std::vector<VectorOutcome>& outcomes) {
  std::string text;
  for (const NoiseKind noise : {NoiseKind::kWhite, NoiseKind::kHeavyTails, NoiseKind::kFlicker}) {
    std::vector<VectorOutcome> some;
    Lines groups, elements;
    for (const VectorOutcome& outcome : outcomes) {
      if (!outcome.failure.empty() || outcome.noise != noise) continue;
      some.push_back(outcome);
      for (const StatedNumber& number : outcome.numbers) {
        groups.At(number.group).Add(number);
        elements.At(number.group + " " + number.name).Add(number);
      }
    }
    if (some.empty()) continue;
    const char* name = kNoiseNames[static_cast<std::size_t>(noise)];
    text += fmt::format("\nnoise: {}, {} seeds\n", name, some.size());
    text += Head("group") + groups.Text();
    if (noise == NoiseKind::kWhite) text += Head("element") + elements.Text();
    text += "\nwhitened rms of the corrected rates, unseen sequence: " + Elsewhere(some);
  }
  for (const VectorOutcome& outcome : outcomes)
    if (!outcome.failure.empty())
      text += fmt::format("seed {} failed: {}\n", outcome.seed, outcome.failure);
  return text;
}

}  // namespace gyrobench::blind_trials
