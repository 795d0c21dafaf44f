#include "calibration/trace/candidate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "calibration/gls/statistics.h"
#include "calibration/trace/scans.h"

namespace gyrobench::calibration {
namespace {

// All points of the grid of an effect's non-linear parameters.
std::vector<std::vector<double>> GridOf(const Effect& effect) {
  std::vector<std::vector<double>> points = {{}};
  for (const NonlinearParameter& parameter : effect.nonlinear) {
    std::vector<std::vector<double>> next;
    for (const std::vector<double>& point : points) {
      for (const double value : parameter.grid) {
        next.push_back(point);
        next.back().push_back(value);
      }
    }
    points = std::move(next);
  }
  return points;
}

BasisContext ContextOf(const ChannelProblem& problem) {
  BasisContext context;
  context.channel = problem.channel();
  context.gear_ratio = problem.gear_ratio();
  context.reference_degC = 0.5 * (problem.min_temperature_degC() + problem.max_temperature_degC());
  return context;
}

bool OnStand(const ChannelProblem& problem) {
  return std::ranges::any_of(problem.histories(), [](const StateHistory& history) {
    return history.recording->info.reference == ReferenceKind::kStandAngles;
  });
}

double CovariateMean(const ChannelProblem& problem, std::size_t index) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) sum += problem.half(i, 0).covariates[index];
  return sum / static_cast<double>(problem.rows());
}

// A quantity that hardly changes is no factor.
constexpr double kLeastGravityRange_g = 0.3;

// Data sheets give sensitivities at this temperature.
constexpr double kNominal_degC = 25.0;
bool IsGravity(const std::string& factor) { return factor.starts_with("g_"); }
// 0 of g_x.
std::size_t AxisOfGravity(const std::string& factor) {
  return static_cast<std::size_t>(factor.back() - 'x');
}
// The axes along which gravity changes by more than the error of its direction.
std::vector<std::string> AxesOfGravity(const ChannelProblem& problem) {
  std::vector<std::string> out;
  for (std::size_t a = 0; a < 3; ++a) {
    if (problem.gravity_range_g()[a] > kLeastGravityRange_g)
      out.push_back(fmt::format("g_{}", "xyz"[a]));
  }
  return out;
}

// Where the table stops near right angles alone one of two axes is always about level: their
// product is the error of the direction of gravity, and its coefficient anything.
bool ProductOfGravityChanges(const ChannelProblem& problem, std::size_t a, std::size_t b) {
  double low = kMissing, high = kMissing;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const Vector3& g = problem.half(i, 0).gravity_g;
    low = std::fmin(low, g[a] * g[b]);
    high = std::fmax(high, g[a] * g[b]);
  }
  return high - low > kLeastGravityRange_g * kLeastGravityRange_g;
}

// g-sensitivity that grows with temperature: nearly the plain one while the temperature stays.
Candidate WarmGravity(const ChannelProblem& problem) {
  Candidate candidate;
  candidate.context = ContextOf(problem);
  for (const std::string& axis : AxesOfGravity(problem)) {
    candidate.factors.insert(candidate.factors.end(), {axis, "T"});
    candidate.offsets.insert(candidate.offsets.end(), {0.0, kNominal_degC});
  }
  candidate.id = candidate.family = "composed(g*T)";
  return candidate;
}

// From 0 at `from` to 1.
double Ramp(double value, double from, double length) {
  const double x = (value - from) / length;
  return std::isnan(x) ? x : std::clamp(x, 0.0, 1.0);
}

DataRange RangeOf(const ChannelProblem& problem) {
  return {problem.max_rate_deg_s(), problem.max_temperature_degC() - problem.min_temperature_degC(),
          problem.turns_in_run()};
}

}  // namespace

std::vector<Candidate> CatalogueCandidates(const ChannelProblem& problem,
                                           const std::vector<std::string>& covariates,
                                           bool earth_rate_known) {
  std::vector<Candidate> out;
  const unsigned observables = problem.observables() | (covariates.empty() ? 0u : kNeedsCovariate);
  const DataRange range = RangeOf(problem);
  for (const Effect& effect : EffectCatalogue()) {
    if ((effect.needs & observables) != effect.needs) continue;
    if (effect.true_motion && earth_rate_known) continue;
    const bool per_axis = (effect.needs & kNeedsTableAxis) != 0;
    const bool per_covariate = (effect.needs & kNeedsCovariate) != 0;
    const std::size_t copies =
        per_axis ? problem.table_axes().size() : (per_covariate ? covariates.size() : 1);
    for (std::size_t copy = 0; copy < copies; ++copy) {
      for (const std::vector<double>& point : GridOf(effect)) {
        if (effect.makes_sense != nullptr && !effect.makes_sense(range, point)) continue;
        Candidate candidate;
        candidate.effect = &effect;
        candidate.context = ContextOf(problem);
        candidate.context.nonlinear = point;
        if (effect.delay_of_clocks) candidate.context.nonlinear = {problem.corrected_drift_ppm()};
        candidate.id = candidate.family = effect.id;
        if (per_axis) {
          candidate.context.table_axis = problem.table_axes()[copy];
          if (OnStand(problem))
            candidate.suffix = fmt::format("_{}", kTableAxisNames[candidate.context.table_axis]);
        }
        if (per_covariate) {
          candidate.context.covariate = copy;
          candidate.context.covariate_mean = CovariateMean(problem, copy);
          candidate.id = fmt::format("{}({})", effect.id, covariates[copy]);
        }
        candidate.family = candidate.id + candidate.suffix;
        if (effect.search == Search::kEachPoint) candidate.family += fmt::format("_{}", point[0]);
        out.push_back(std::move(candidate));
      }
    }
  }
  return out;
}

double Candidate::LogChance(double gain, double degrees) const {
  if (!(degrees > 0.0)) return 0.0;
  return degrees > 1.0 ? LogChiSquareTail(gain, degrees) : LogHeavyTail(gain, tail_freedom);
}

double Candidate::complexity_penalty() const {
  // A name of the catalogue comes before a description.
  // The knots of a curve are free, hundreds of pairs of them.
  constexpr double kProduct = 14.0, kCurve = 20.0;
  if (effect != nullptr) return effect->complexity_penalty;
  return empirical() ? kCurve : kProduct;
}

std::vector<Candidate> ComposedCandidates(const ChannelProblem& problem,
                                          const std::vector<std::string>& covariates) {
  std::vector<std::string> factors;
  const unsigned observables = problem.observables();
  if ((observables & kNeedsRate) != 0) factors.insert(factors.end(), {"w", "abs_w"});
  if ((observables & kNeedsGravity) != 0) {
    for (std::string& axis : AxesOfGravity(problem)) factors.push_back(std::move(axis));
  }
  if ((observables & kNeedsTemperature) != 0) factors.insert(factors.end(), {"T", "dT_dt"});
  const std::size_t known = factors.size();
  factors.insert(factors.end(), covariates.begin(), covariates.end());
  // Products that the catalogue has, or the baseline.
  auto listed = [&](std::size_t i, std::size_t j) {
    const std::string &a = factors[i], &b = factors[j];
    if (i == j) return i < known;  // squares of columns alone are new
    if (a == "w") return b == "abs_w" || b == "T" || j >= known || b.starts_with("g_");
    return false;
  };
  std::vector<Candidate> out;
  auto in_vector = [&](std::size_t i, std::size_t j) {
    return i < known && factors[i].starts_with("g_") && factors[j] == "T";
  };
  for (std::size_t i = 0; i < factors.size(); ++i) {
    for (std::size_t j = i; j < factors.size(); ++j) {
      if (listed(i, j) || in_vector(i, j)) continue;
      if (j < known && IsGravity(factors[i]) && IsGravity(factors[j]) &&
          !ProductOfGravityChanges(problem, AxisOfGravity(factors[i]), AxisOfGravity(factors[j])))
        continue;
      Candidate candidate;
      candidate.context = ContextOf(problem);
      candidate.factors = {factors[i], factors[j]};
      for (const std::size_t index : {i, j}) {
        double offset = 0.0;
        if (factors[index] == "T") offset = candidate.context.reference_degC;
        if (index >= known) offset = CovariateMean(problem, index - known);
        candidate.offsets.push_back(offset);
      }
      candidate.id = fmt::format("composed({}*{})", factors[i], factors[j]);
      candidate.family = candidate.id;
      out.push_back(std::move(candidate));
    }
  }
  return out;
}

Candidate PlacedCandidate(const ChannelProblem& problem, const Effect& effect,
                          std::size_t table_axis, std::vector<double> nonlinear,
                          std::optional<std::size_t> power_on) {
  Candidate candidate;
  candidate.effect = &effect;
  candidate.context = ContextOf(problem);
  candidate.context.table_axis = table_axis;
  candidate.context.nonlinear = std::move(nonlinear);
  candidate.id = effect.id;
  candidate.power_on = power_on;
  if ((effect.needs & kNeedsTableAxis) != 0 && OnStand(problem))
    candidate.suffix = fmt::format("_{}", kTableAxisNames[table_axis]);
  candidate.family = effect.id + candidate.suffix;
  // Several steps or tones are several effects.
  if (candidate.scanned())
    candidate.family += fmt::format("@{:.9g}", candidate.context.nonlinear.front());
  if (power_on) candidate.family += fmt::format(" of power-on {}", *power_on);
  return candidate;
}

Candidate ScannedCandidate(const ChannelProblem& problem, const ScanPeak& peak) {
  std::optional<std::size_t> power_on;
  if (peak.effect->of_one_time() && problem.power_on_begins().size() > 1)
    power_on = problem.power_on(peak.row);
  return PlacedCandidate(problem, *peak.effect, peak.table_axis, {peak.nonlinear}, power_on);
}

Eigen::MatrixXd ColumnsOf(const ChannelProblem& problem, const Candidate& candidate,
                          const std::vector<std::string>& covariates) {
  if (candidate.raw) return candidate.raw->Copy();
  if (candidate.effect != nullptr) {
    return problem.Columns(*candidate.effect, candidate.context, candidate.power_on);
  }
  std::vector<Factor> factors;
  for (const std::string& name : candidate.factors)
    factors.push_back(*Factor::Make(name, problem.channel(), covariates));
  if (candidate.empirical()) {
    const double from = candidate.knots[0], length = candidate.knots[1] - candidate.knots[0];
    return problem.RateColumn(
        [&](const SensorState& point) { return Ramp(factors[0].At(point), from, length); });
  }
  Eigen::MatrixXd out(problem.rows(), static_cast<Eigen::Index>(factors.size() / 2));
  for (std::size_t k = 0; k < factors.size(); k += 2) {
    out.col(static_cast<Eigen::Index>(k / 2)) = problem.RateColumn([&](const SensorState& point) {
      return (factors[k].At(point) - candidate.offsets[k]) *
             (factors[k + 1].At(point) - candidate.offsets[k + 1]);
    });
  }
  return out;
}

std::vector<CurveCells> CellsOfCurves(const ChannelProblem& problem,
                                      const std::vector<std::string>& covariates) {
  constexpr std::size_t kCells = 24;
  std::vector<std::string> names = covariates;
  if ((problem.observables() & kNeedsTemperature) != 0) names.insert(names.begin(), "T");
  std::vector<CurveCells> out;
  for (const std::string& name : names) {
    const Factor factor = *Factor::Make(name, problem.channel(), covariates);
    double low = kMissing, high = kMissing;
    std::vector<double> values;  // two a row
    for (Eigen::Index i = 0; i < problem.rows(); ++i) {
      values.push_back(factor.At(problem.half(i, 0)));
      values.push_back(factor.At(problem.half(i, 1)));
      low = std::fmin(low, values[values.size() - 2]);
      high = std::fmax(high, values[values.size() - 2]);
    }
    if (!(high > low)) continue;
    CurveCells cells;
    cells.factor = name;
    for (std::size_t e = 0; e <= kCells; ++e)
      cells.edges.push_back(low + (high - low) * static_cast<double>(e) / kCells);
    Eigen::MatrixXd raw(problem.rows(), static_cast<Eigen::Index>(kCells));
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      const double from = cells.edges[cell], length = cells.edges[cell + 1] - from;
      for (std::size_t i = 0; i < problem.intervals().size(); ++i) {
        const double half_s = 0.5 * problem.intervals()[i].duration_s;
        raw(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(cell)) =
            half_s * (Ramp(values[2 * i], from, length) + Ramp(values[2 * i + 1], from, length));
      }
    }
    if (!raw.allFinite()) continue;
    cells.raw = RawColumns(std::move(raw));
    out.push_back(std::move(cells));
  }
  return out;
}

double ValueAt(const ChannelProblem& problem, const std::string& factor,
               const std::vector<std::string>& covariates, const Candidate& step) {
  const Factor by = *Factor::Make(factor, problem.channel(), covariates);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const bool mine = !step.power_on || problem.power_on(i) == *step.power_on;
    if (mine && problem.end_s(i) > step.context.nonlinear[0]) return by.At(problem.half(i, 0));
  }
  return kMissing;
}

CandidateSet AllCandidates(const ChannelProblem& problem, std::vector<std::string> covariates,
                           bool earth_rate_known, std::vector<Candidate> placed) {
  CandidateSet out;
  out.covariates = std::move(covariates);
  out.grid = CatalogueCandidates(problem, out.covariates, earth_rate_known);
  constexpr unsigned kBoth = kNeedsGravity | kNeedsTemperature;
  if ((problem.observables() & kBoth) == kBoth) {
    if (Candidate warm = WarmGravity(problem); !warm.factors.empty())
      out.grid.push_back(std::move(warm));
  }
  std::ranges::move(placed, std::back_inserter(out.grid));
  out.products = ComposedCandidates(problem, out.covariates);
  for (std::vector<Candidate>* list : {&out.grid, &out.products}) {
    for (Candidate& candidate : *list) {
      candidate.raw = candidate.Limited(ColumnsOf(problem, candidate, out.covariates));
    }
    std::erase_if(*list, [](const Candidate& candidate) { return !candidate.raw->allFinite(); });
  }
  out.cells = CellsOfCurves(problem, out.covariates);
  return out;
}

std::vector<RawColumns> RawBaseline(const Baseline& baseline) {
  std::vector<RawColumns> out = {Eigen::MatrixXd(baseline.columns.leftCols(baseline.of_sensor()))};
  // Each by itself: NoiseSearch leaves out together what came together.
  for (Eigen::Index j = baseline.of_sensor(); j < baseline.columns.cols(); ++j) {
    const RawColumns place = Eigen::MatrixXd(baseline.columns.col(j));
    out.push_back(place.Limited(1.0));
  }
  return out;
}

std::vector<RawColumns> EverythingThatMayAct(const Baseline& baseline,
                                             const CandidateSet& candidates, bool delays) {
  std::vector<RawColumns> out = RawBaseline(baseline);
  std::string family;
  int place = 0;
  for (const Candidate& candidate : candidates.grid) {
    place = candidate.family == family ? place + 1 : 0;
    family = candidate.family;
    const bool late = candidate.effect != nullptr &&
                      (candidate.effect->of_delay() || candidate.effect->filter_shape);
    if (place % 3 == 0 && (delays || !late)) out.push_back(*candidate.raw);
  }
  return out;
}

CandidateSet CandidateSet::Part(const std::vector<Eigen::Index>& rows) const {
  CandidateSet out = *this;
  const auto picked = std::make_shared<const std::vector<Eigen::Index>>(rows);
  for (std::vector<Candidate>* list : {&out.grid, &out.products}) {
    for (Candidate& candidate : *list) candidate.raw = candidate.raw->Part(picked);
  }
  for (CurveCells& curve : out.cells) curve.raw = curve.raw.Part(picked);
  return out;
}

Candidate EmpiricalCandidate(const ChannelProblem& problem, const std::string& factor, double from,
                             double to) {
  Candidate candidate;
  candidate.context = ContextOf(problem);
  candidate.factors = {factor};
  candidate.knots = {from, to};
  candidate.id = fmt::format("empirical({})", factor);
  candidate.family = fmt::format("{}@{:.6g}..{:.6g}", candidate.id, from, to);
  return candidate;
}

}  // namespace gyrobench::calibration
