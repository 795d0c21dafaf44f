#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/sensor/least_squares.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/report_parts.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

constexpr double kAbsorbed = 1e-6;

Eigen::MatrixXd White(const ChannelProblem& problem, const Effect& effect,
                      const Selection& selection) {
  BasisContext context;
  context.channel = problem.channel();
  Eigen::MatrixXd columns = problem.Columns(effect, context);
  selection.whitener().Apply(columns);
  return columns;
}

// What the model may bend to.
Eigen::MatrixXd Tangent(const ChannelFit& fit) {
  Eigen::MatrixXd out(fit.white.rows(), fit.white.cols() + fit.white_slopes.cols());
  out << fit.white, fit.white_slopes;
  return out;
}

// Components of the Earth's rotation that the data give columns of: without a heading, as of the
// accelerometer's gravity, the vertical one alone. None where it is taken off.
Eigen::MatrixXd WhiteEarth(const ChannelProblem& problem, const Selection& selection) {
  const Eigen::MatrixXd all = White(problem, EarthRotationEffect(), selection);
  std::vector<Eigen::Index> known;
  for (Eigen::Index j = 0; j < all.cols(); ++j) {
    if (all.col(j).allFinite() && !all.col(j).isZero(0.0)) known.push_back(j);
  }
  return all(Eigen::all, known);
}

// `response`: what the values are by 1 deg/s of each component, which is left out of the model. The
// rotation's size is known and its direction is not: each component's mean square is a third of
// its own.
Eigen::Matrix3d CovarianceOfEarth(const Eigen::MatrixXd& response) {
  return EarthRate_deg_s() * EarthRate_deg_s() / 3.0 * response * response.transpose();
}

// A member of the model, its columns from `column` on: solved as the model is, so that what depends
// on other columns is held at 0 here as well, and a component that the model has changes nothing.
Eigen::Matrix3d EarthInModel(const ChannelFit& fit, const Eigen::MatrixXd& earth,
                             Eigen::Index column) {
  if (earth.cols() == 0) return Eigen::Matrix3d::Zero();
  const Eigen::MatrixXd tangent = Tangent(fit);
  const Eigen::MatrixXd gram = tangent.transpose() * tangent, right = tangent.transpose() * earth;
  Eigen::MatrixXd response(3, earth.cols());
  for (Eigen::Index j = 0; j < earth.cols(); ++j)
    response.col(j) = SolveIndependent(gram, right.col(j)).segment<3>(column);
  return CovarianceOfEarth(response);
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
    } else if (std::hypot(row->std_error[j], std::sqrt(row->earth_covariance(j, j))) >
               effect.typical_size) {
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

// Gravity's columns next to the model, which is taken off them, and of length 1 before.
void FitBeside(const ChannelProblem& problem, const Selection& selection, const ChannelFit& fit,
               double grow, const Eigen::MatrixXd& earth, GravityRow* row) {
  const Eigen::MatrixXd gravity = White(problem, GSensitivityEffect(), selection);
  const Eigen::MatrixXd tangent = Tangent(fit);
  const Projection model(tangent(Eigen::all, IndependentColumns(tangent.transpose() * tangent)));
  const Eigen::Vector3d length = gravity.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd left = model.Off(gravity * length.cwiseInverse().asDiagonal());
  const Eigen::Matrix3d gram = left.transpose() * left;
  const SeenSolution solved = SolveSeen(gram, left.transpose() * fit.WhiteResidual(), kAbsorbed);
  row->value = solved.values.cwiseQuotient(length);
  row->std_error = grow * solved.covariance.diagonal().cwiseSqrt().cwiseQuotient(length);
  Eigen::MatrixXd response(3, earth.cols());
  for (Eigen::Index j = 0; j < earth.cols(); ++j) {
    response.col(j) =
        SolveSeen(gram, left.transpose() * earth.col(j), kAbsorbed).values.cwiseQuotient(length);
  }
  row->earth_covariance = CovarianceOfEarth(response);
  Judge(GSensitivityEffect(), selection, solved.seen, row);
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
  const Eigen::MatrixXd earth = WhiteEarth(problem, selection);
  const std::vector<Candidate>& members = selection.members();
  const auto named = std::ranges::find(members, &effect, &Candidate::effect);
  if (named == members.end()) {
    FitBeside(problem, selection, fit, grow, earth, &row);
    return row;
  }
  const auto member = static_cast<std::size_t>(named - members.begin());
  row.in_model = true;
  row.value = fit.values.segment<3>(fit.member_begin[member]);
  row.std_error = grow * fit.covariance.diagonal().segment<3>(fit.member_begin[member]).cwiseSqrt();
  row.earth_covariance = EarthInModel(fit, earth, fit.column_begin[member]);
  Judge(effect, selection, {true, true, true}, &row);
  return row;
}

}  // namespace gyrobench::calibration
