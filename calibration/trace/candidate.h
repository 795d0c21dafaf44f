// What may be added to the model of a channel.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/effects/factor.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

struct ScanPeak;

// Of a product: the quantity whose zero has been found, and its range in the data, in its own unit.
// The zero itself is the non-linear parameter.
struct Origin {
  std::string of;  // T, or a covariate
  double low = 0.0, high = 0.0;

  std::string parameter() const { return of == "T" ? "T0" : of + "_0"; }
};

struct Candidate {
  const Effect* effect = nullptr;  // nullptr: composed or empirical
  BasisContext context;
  std::string id;      // as it is reported: bias.of(supply_v)
  std::string family;  // id and axis: of one family one member is enough
  std::string suffix;  // of its parameters' names: _inner
  // Composed: two factors a term, one term after the other, and their offsets, of which `origin`
  // was found. Empirical: one, and two knots: the curve rises from 0 at the first to its
  // coefficient at the second.
  std::vector<std::string> factors;
  std::vector<double> offsets, knots;
  std::optional<Origin> origin;
  std::optional<std::size_t> power_on;  // steps and tones: acts in this power-on alone
  // Share of the chance of a false discovery that is this candidate's: threshold of its p-value.
  double log_level = 0.0;
  // Of what one row decides (ScanPeak).
  double tail_freedom = std::numeric_limits<double>::infinity();
  // What it gained of -2 log L when each of both models had the noise that suits it and, beside a
  // residual that is not white, with errors that allow for that; not less than what it gains under
  // one noise, where that has not been worked out.
  double gain_over_noise = std::numeric_limits<double>::infinity();
  // Of its coefficients together [their unit].
  double largest = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Index> columns;  // in the WhiteStore
  std::optional<RawColumns> raw;      // ColumnsOf, where they have been worked out

  // Logarithm of the chance that it gains so much of -2 log L by its columns without being there.
  double LogChance(double gain, double degrees) const;
  // Its columns, with coefficients that are no larger than what is plausible of the effect.
  RawColumns Limited(const RawColumns& its) const {
    return effect == nullptr ? its : its.Limited(effect->implausible_size());
  }
  bool empirical() const { return !knots.empty(); }
  // What -2 log L must gain for it to be named before an effect that does nearly the same.
  double complexity_penalty() const;

  Search search() const { return effect == nullptr ? Search::kNone : effect->search; }
  // Its non-linear parameters are searched for: they are no places of a scan or a grid, and not
  // the coefficient.
  bool searched() const {
    if (effect == nullptr) return !context.nonlinear.empty();
    return effect->search == Search::kGrid || effect->search == Search::kFrequency ||
           effect->search == Search::kPeriods;
  }
  // The data know what it does, but not its non-linear parameters beside its coefficients: those
  // hold for the parameters as they are, which have no standard error.
  bool shape_held = false;
  bool shape_is_free() const { return searched() && !shape_held; }
  // By its shape its size may be anything, and only what it is in the data is known. The amplitude
  // of a tone or a ripple hardly depends on its frequency.
  bool size_unknown() const {
    if (!shape_held) return false;
    return effect == nullptr ||
           (effect->search == Search::kGrid && effect->domain == EffectDomain::kRate);
  }
  bool is_delay() const { return effect != nullptr && effect->delay_s != nullptr; }
  bool is_play() const {
    return search() == Search::kCoefficient && (effect->needs & kNeedsTableAxis) != 0;
  }
  bool of_one_run() const { return effect != nullptr && effect->of_one_run(); }
  // A scan has found it, at its place; there is no grid of such.
  bool scanned() const {
    return effect != nullptr && (effect->of_one_time() || effect->search == Search::kPeriods);
  }
  // A step of an angle: one row knows it.
  bool angle_step() const {
    return search() == Search::kTime && effect->domain == EffectDomain::kAngle;
  }
  bool bias_step() const {
    return search() == Search::kTime && effect->domain == EffectDomain::kRate;
  }
};

// All grid points of all effects of the catalogue that the measurements allow to look for.
std::vector<Candidate> CatalogueCandidates(const ChannelProblem& problem,
                                           const std::vector<std::string>& covariates,
                                           bool earth_rate_known);
// Products of two factors that are not in the catalogue.
std::vector<Candidate> ComposedCandidates(const ChannelProblem& problem,
                                          const std::vector<std::string>& covariates);
// One effect of the catalogue outside the grid, at its place; `power_on`: in which alone it acts.
Candidate PlacedCandidate(const ChannelProblem& problem, const Effect& effect,
                          std::size_t table_axis, std::vector<double> nonlinear,
                          std::optional<std::size_t> power_on);
// What a scan has found.
Candidate ScannedCandidate(const ChannelProblem& problem, const ScanPeak& peak);

// A quantity that curves are sought in, cut into equal cells of its range.
struct CurveCells {
  std::string factor;
  std::vector<double> edges;  // one more than the cells
  // rows x cells: int over each row of a ramp from 0 to 1 across the cell [deg per deg/s].
  RawColumns raw;
};
std::vector<CurveCells> CellsOfCurves(const ChannelProblem& problem,
                                      const std::vector<std::string>& covariates);
// The ramp from one edge to another.
Candidate EmpiricalCandidate(const ChannelProblem& problem, const std::string& factor, double from,
                             double to);

// Value of a factor where a step is placed.
double ValueAt(const ChannelProblem& problem, const std::string& factor,
               const std::vector<std::string>& covariates, const Candidate& step);

// Everything that is tried on a channel, its raw columns worked out once.
struct CandidateSet {
  std::vector<std::string> covariates;
  std::vector<Candidate> grid;  // the catalogue's, and what may take an effect's place
  std::vector<Candidate> products;
  std::vector<CurveCells> cells;

  // For ChannelProblem::Part(rows); of the set of all rows.
  CandidateSet Part(const std::vector<Eigen::Index>& rows) const;
};
// `placed`: candidates beside the catalogue's grid.
CandidateSet AllCandidates(const ChannelProblem& problem, std::vector<std::string> covariates,
                           bool earth_rate_known, std::vector<Candidate> placed = {});

// Of the square of a column: more than what those before leave of it changes the noise.
inline constexpr double kNearlyDependent = 1e-3;
// Columns of the baseline beside which noise is judged. Misread places are held to their prior.
std::vector<RawColumns> RawBaseline(const Baseline& baseline);
// Columns beside which the noise is judged first: the baseline's, and every grid point of the
// catalogue, of a long grid one in three, which span what the others do, nearly.
// `delays`: with what makes the gyro late, as latencies and filters are.
std::vector<RawColumns> EverythingThatMayAct(const Baseline& baseline,
                                             const CandidateSet& candidates, bool delays = true);

// Raw columns of a candidate: rows x terms, deg per unit.
Eigen::MatrixXd ColumnsOf(const ChannelProblem& problem, const Candidate& candidate,
                          const std::vector<std::string>& covariates);

}  // namespace gyrobench::calibration
