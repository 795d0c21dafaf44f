#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/sensor/least_squares.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/report_parts.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

constexpr double kAbsorbed = 1e-6;

struct LeftColumns {
  Eigen::MatrixXd columns;
  Eigen::Matrix3d gram;   // of what the model leaves of them, columns of length 1 before
  Eigen::Vector3d right;  // with the output
  Eigen::Vector3d length;
};

Eigen::MatrixXd White(const ChannelProblem& problem, const Effect& effect,
                      const Selection& selection) {
  BasisContext context;
  context.channel = problem.channel();
  Eigen::MatrixXd columns = problem.Columns(effect, context);
  selection.whitener().Apply(columns);
  return columns;
}

// Everything that the model's `columns` (of fit.white) and its shapes may bend to, taken off.
LeftColumns Left(const ChannelProblem& problem, const Selection& selection, const ChannelFit& fit,
                 const std::vector<Eigen::Index>& columns) {
  const Eigen::MatrixXd gravity = White(problem, GSensitivityEffect(), selection);
  Eigen::MatrixXd tangent(fit.white.rows(),
                          static_cast<Eigen::Index>(columns.size()) + fit.white_slopes.cols());
  tangent << fit.white(Eigen::all, columns), fit.white_slopes;
  const std::vector<Eigen::Index> kept = IndependentColumns(tangent.transpose() * tangent);
  const Projection model(tangent(Eigen::all, kept));
  LeftColumns out;
  out.length = gravity.colwise().norm().cwiseMax(1e-300);
  out.columns = model.Off(gravity * out.length.cwiseInverse().asDiagonal());
  out.gram = out.columns.transpose() * out.columns;
  out.right = out.columns.transpose() * fit.WhiteResidual();
  return out;
}

std::optional<std::size_t> MemberOf(const Effect& effect, const Selection& selection) {
  const std::vector<Candidate>& members = selection.members();
  const auto at = std::ranges::find(members, &effect, &Candidate::effect);
  if (at == members.end()) return std::nullopt;
  return static_cast<std::size_t>(at - members.begin());
}

// Of the model without its g-sensitivity and without the Earth.
std::vector<Eigen::Index> ColumnsOfTheRest(const Selection& selection, const ChannelFit& fit) {
  std::vector<Eigen::Index> without;
  for (const Effect* effect : {&GSensitivityEffect(), &EarthRotationEffect()}) {
    if (const auto member = MemberOf(*effect, selection)) {
      const std::vector<Eigen::Index> own = fit.ColumnsOf(*member);
      without.insert(without.end(), own.begin(), own.end());
    }
  }
  return fit.ColumnsBut(without);
}

// Whether the model has this component of the Earth's rotation, and the data determine it.
bool IsFitted(Eigen::Index component, const Selection& selection, const ChannelFit& fit) {
  const auto member = MemberOf(EarthRotationEffect(), selection);
  if (!member) return false;
  const Eigen::Index at = fit.member_begin[*member] + component;
  return fit.covariance(at, at) > 0.0;
}

// What the Earth's rotation adds to the covariance of the row: its size is known and its direction
// is not, so that each component's mean square is a third of its own.
Eigen::Matrix3d CovarianceOfEarth(const ChannelProblem& problem, const Selection& selection,
                                  const ChannelFit& fit) {
  // Nothing where it is taken off.
  const Eigen::MatrixXd earth = White(problem, EarthRotationEffect(), selection);
  if (earth.isZero(0.0)) return Eigen::Matrix3d::Zero();
  const LeftColumns left = Left(problem, selection, fit, ColumnsOfTheRest(selection, fit));
  const Eigen::Matrix3d right = left.columns.transpose() * earth;
  const double rate_deg_s = EarthRotationEffect().typical_size;
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  for (Eigen::Index j = 0; j < 3; ++j) {
    if (IsFitted(j, selection, fit)) continue;
    const Eigen::Vector3d row =
        SolveSeen(left.gram, right.col(j), kAbsorbed).values.cwiseQuotient(left.length);
    out += rate_deg_s * rate_deg_s / 3.0 * row * row.transpose();
  }
  return out;
}

void Drop(const std::vector<std::string>& names, const std::string& why, GravityRow* row) {
  if (names.empty()) return;
  row->because +=
      fmt::format("{}{}: {}", row->because.empty() ? "" : "; ", fmt::join(names, ", "), why);
}

// The members that are a product with gravity along that axis: "composed(g_y*supply_v)".
std::string ProductsWith(const Selection& selection, const std::string& axis) {
  std::vector<std::string> ids;
  for (const Candidate& member : selection.members()) {
    if (member.effect == nullptr && std::ranges::count(member.factors, "g_" + axis) > 0)
      ids.push_back(member.id);
  }
  return fmt::format("{}", fmt::join(ids, " and "));
}

// NaN where too little is known, with the reason.
void Judge(const Effect& effect, const Selection& selection, const std::vector<bool>& seen,
           GravityRow* row) {
  std::vector<std::string> absorbed, vague;
  for (Eigen::Index j = 0; j < 3; ++j) {
    const std::string name(1, "xyz"[j]);
    // A term of the model that these data are blind to is held at 0, without an error.
    const bool known = seen[static_cast<std::size_t>(j)] && std::isfinite(row->std_error[j]) &&
                       row->std_error[j] > 0.0;
    if (const std::string products = ProductsWith(selection, name); !known && !products.empty()) {
      Drop({name}, fmt::format("it is in {}, and changes with the other quantity", products), row);
    } else if (!known) {
      absorbed.push_back(name);
    } else if (row->std_error[j] > effect.typical_size) {
      vague.push_back(name);
    } else {
      continue;
    }
    row->value[j] = row->std_error[j] = kMissing;
  }
  Drop(absorbed, "the poses do not tell gravity along it from the rest of the model", row);
  Drop(vague,
       fmt::format("its standard error is beyond {:.2g} deg/s/g, the largest size of such parts",
                   effect.typical_size),
       row);
}

}  // namespace

GravityRow FitGravityRow(const ChannelProblem& problem, const Selection& selection,
                         const ChannelFit& fit, double grow) {
  GravityRow row;
  const Effect& effect = GSensitivityEffect();
  if ((problem.observables() & kNeedsGravity) == 0) {
    row.because = "gravity in the sensor's frame is not known";
    return row;
  }
  row.earth_covariance = CovarianceOfEarth(problem, selection, fit);
  if (const auto member = MemberOf(effect, selection)) {
    row.in_model = true;
    const Eigen::Index begin = fit.member_begin[*member];
    row.value = fit.values.segment<3>(begin);
    row.std_error = grow * fit.covariance.diagonal().segment<3>(begin).cwiseSqrt();
    Judge(effect, selection, {true, true, true}, &row);
    return row;
  }
  const LeftColumns left = Left(problem, selection, fit, fit.ColumnsBut({}));
  const SeenSolution solved = SolveSeen(left.gram, left.right, kAbsorbed);
  row.value = solved.values.cwiseQuotient(left.length);
  row.std_error = grow * solved.covariance.diagonal().cwiseSqrt().cwiseQuotient(left.length);
  Judge(effect, selection, solved.seen, &row);
  return row;
}

}  // namespace gyrobench::calibration
