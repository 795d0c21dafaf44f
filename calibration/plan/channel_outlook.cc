#include "calibration/plan/channel_outlook.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/whitener.h"

namespace gyrobench::calibration {
namespace {

constexpr double kFinest = 100.0;  // nothing more is asked of an effect below this share

// Of the products of columns `of` with each other, what is left when `others` are taken off them.
Eigen::MatrixXd Left(const Eigen::MatrixXd& gram, const std::vector<Eigen::Index>& of,
                     const std::vector<Eigen::Index>& others) {
  std::vector<Eigen::Index> kept;
  for (const Eigen::Index k : IndependentColumns(gram(others, others)))
    kept.push_back(others[static_cast<std::size_t>(k)]);
  const Eigen::MatrixXd cross = gram(kept, of);
  return gram(of, of) - cross.transpose() * ScaledLdlt(gram(kept, kept)).Solve(cross);
}

}  // namespace

ChannelOutlook::ChannelOutlook(std::span<const StateHistory> histories, const ChannelModel& model,
                               const NoiseModel& noise) {
  const ChannelProblem problem(histories, static_cast<std::size_t>(model.axis),
                               model.units_per_deg_s);
  const Baseline baseline = problem.MakeBaseline();
  baseline_columns_ = static_cast<Eigen::Index>(baseline.turned.size()) +
                      baseline.temperature_order + baseline.filter_shapes;
  Eigen::Index next = baseline_columns_;
  std::vector<Eigen::MatrixXd> raw;
  const auto take = [&](const Eigen::MatrixXd& columns) {
    Columns out;
    for (Eigen::Index j = 0; j < columns.cols(); ++j) out.push_back(next++);
    raw.push_back(columns);
    return out;
  };
  for (const Candidate& candidate :
       CatalogueCandidates(problem, {}, histories.front().earth_rate_known)) {
    // The manoeuvres are to be parts of one run.
    if (candidate.of_one_run()) continue;
    const Eigen::MatrixXd columns = problem.Columns(*candidate.effect, candidate.context);
    if (!columns.allFinite()) continue;
    catalogue_.push_back({candidate.id,
                          candidate.family,
                          candidate.effect->typical_size,
                          candidate.effect->positive,
                          take(columns),
                          {}});
  }
  for (const ModelTerm& term : model.terms) {
    const Effect* effect = term.origin == EffectOrigin::kCatalogue
                               ? FindEffect(term.id, term.nonlinear.size())
                               : nullptr;
    if (effect == nullptr || (effect->needs & kNeedsCovariate) != 0) continue;
    BasisContext context;
    context.channel = problem.channel();
    context.table_axis = term.table_axis;
    context.gear_ratio = problem.gear_ratio();
    context.reference_degC = term.reference_degC;
    context.nonlinear = term.nonlinear;
    const Eigen::MatrixXd columns = problem.Columns(*effect, context);
    if (!columns.allFinite()) continue;
    Member member = {term.id, term.id, effect->typical_size, effect->positive, take(columns), {}};
    member.coefficients = Eigen::Map<const Eigen::VectorXd>(
        term.coefficients.data(), static_cast<Eigen::Index>(member.columns.size()));
    named_.push_back(std::move(member));
  }
  Fill(problem, baseline, noise, raw);
}

void ChannelOutlook::Fill(const ChannelProblem& problem, const Baseline& baseline,
                          const NoiseModel& noise, const std::vector<Eigen::MatrixXd>& columns) {
  const auto turned = static_cast<Eigen::Index>(baseline.turned.size());
  const auto constants = static_cast<Eigen::Index>(baseline.constants);
  Eigen::Index count = baseline_columns_ + 1;
  for (const Eigen::MatrixXd& matrix : columns) count += matrix.cols();
  Eigen::MatrixXd all(problem.rows(), count);
  all.leftCols(turned) = baseline.columns.leftCols(turned);
  const Eigen::Index after = baseline.temperature_order + baseline.filter_shapes;
  all.middleCols(turned, after) = baseline.columns.middleCols(turned + constants, after);
  Eigen::Index next = baseline_columns_;
  for (const Eigen::MatrixXd& matrix : columns) {
    all.middleCols(next, matrix.cols()) = matrix;
    next += matrix.cols();
  }
  all.col(next) = baseline.columns.middleCols(turned, constants).rowwise().sum();
  Whitener(problem.intervals(), {noise.angle_random_walk_deg_sqrt_s,
                                 noise.bias_random_walk_deg_s_sqrt_s, noise.reference_deg})
      .Apply(all);
  Eigen::Index row = 0;
  for (std::size_t t = 0; t < problem.histories().size(); ++t) {
    const Eigen::Index begin = row;
    while (row < problem.rows() && problem.row_refs()[static_cast<std::size_t>(row)].history == t)
      ++row;
    const auto part = all.middleRows(begin, row - begin);
    Eigen::MatrixXd gram = part.transpose() * part;
    // Each has a constant of its own: what the bias was before says little after a while.
    if (gram(next, next) > 0.0) gram -= gram.col(next) * gram.row(next) / gram(next, next);
    grams_.push_back(gram.topLeftCorner(next, next));
  }
}

Eigen::MatrixXd ChannelOutlook::With(std::size_t manoeuvre) const {
  return grams_.front() + grams_[manoeuvre + 1];
}

// Whether the other, which may only be positive, would have to be negative to do what is named.
bool ChannelOutlook::WouldBeNegative(const Eigen::MatrixXd& gram, const Columns& rest,
                                     const Member& named, const Member& other) const {
  if (!other.positive) return false;
  Columns both = other.columns;
  both.insert(both.end(), named.columns.begin(), named.columns.end());
  const auto own = static_cast<Eigen::Index>(other.columns.size());
  const Eigen::MatrixXd left = Left(gram, both, rest);
  const Eigen::VectorXd score = left.topRightCorner(own, left.cols() - own) * named.coefficients;
  return ScaledLdlt(left.topLeftCorner(own, own)).Solve(score).minCoeff() < 0.0;
}

double ChannelOutlook::Odds(const Eigen::MatrixXd& gram, const Member& named,
                            const Member& other) const {
  Columns rest;
  for (Eigen::Index j = 0; j < baseline_columns_; ++j) rest.push_back(j);
  for (const Member& member : named_) {
    if (&member != &named) rest.insert(rest.end(), member.columns.begin(), member.columns.end());
  }
  if (!WouldBeNegative(gram, rest, named, other))
    rest.insert(rest.end(), other.columns.begin(), other.columns.end());
  const Eigen::MatrixXd left = Left(gram, named.columns, rest);
  return 0.5 * named.coefficients.dot(left * named.coefficients);
}

std::vector<ChannelOutlook::Rivalry> ChannelOutlook::Rivalries() const {
  std::vector<Rivalry> out;
  const std::size_t manoeuvres = grams_.size() - 1;
  std::vector<Eigen::MatrixXd> with;
  if (!named_.empty()) {
    for (std::size_t m = 0; m < manoeuvres; ++m) with.push_back(With(m));
  }
  for (const Member& named : named_) {
    std::map<std::string, Rivalry> hardest;
    for (const Member& other : catalogue_) {
      const bool among = std::any_of(named_.begin(), named_.end(),
                                     [&](const Member& m) { return m.id == other.id; });
      if (among) continue;
      const double now = Odds(grams_.front(), named, other);
      const auto [place, first] = hardest.try_emplace(other.id);
      Rivalry& rivalry = place->second;
      if (first) {
        rivalry = {named.id, other.id, now,
                   std::vector<double>(manoeuvres, std::numeric_limits<double>::infinity())};
      }
      rivalry.now = std::min(rivalry.now, now);
      for (std::size_t m = 0; m < manoeuvres; ++m)
        rivalry.then[m] = std::min(rivalry.then[m], Odds(with[m], named, other));
    }
    for (auto& [id, rivalry] : hardest) out.push_back(std::move(rivalry));
  }
  return out;
}

std::set<std::string> ChannelOutlook::Judged() const {
  std::set<std::string> ids;
  for (const Member& member : named_) ids.insert(member.id);
  return ids;
}

double ChannelOutlook::KnownOf(const Eigen::MatrixXd& gram, const Member& member) const {
  Columns rest;
  for (Eigen::Index j = 0; j < baseline_columns_; ++j) rest.push_back(j);
  const Eigen::MatrixXd left = Left(gram, member.columns, rest);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(left, Eigen::EigenvaluesOnly);
  const double size = member.typical_size * member.typical_size;
  double known = 0.0;
  for (const double value : solver.eigenvalues()) {
    const double seen = size * std::max(value, 0.0);
    known += 0.5 * (std::log1p(seen) - std::log1p(seen / (kFinest * kFinest)));
  }
  return known;
}

std::vector<ChannelOutlook::Knowledge> ChannelOutlook::KnowledgeOfAll() const {
  const std::size_t manoeuvres = grams_.size() - 1;
  std::vector<Eigen::MatrixXd> with;
  for (std::size_t m = 0; m < manoeuvres; ++m) with.push_back(With(m));
  // The mean over the grid of an effect's non-linear parameters.
  std::map<std::string, double> points;
  for (const Member& member : catalogue_) points[member.family] += 1.0;
  std::map<std::string, Knowledge> all;
  for (const Member& member : catalogue_) {
    if (!(member.typical_size > 0.0)) continue;
    Knowledge& known = all[member.id];
    known.id = member.id;
    known.then.resize(manoeuvres, 0.0);
    const double share = 1.0 / points[member.family];
    known.now += share * KnownOf(grams_.front(), member);
    for (std::size_t m = 0; m < manoeuvres; ++m) known.then[m] += share * KnownOf(with[m], member);
  }
  std::vector<Knowledge> out;
  for (auto& [id, known] : all) out.push_back(std::move(known));
  return out;
}

}  // namespace gyrobench::calibration
