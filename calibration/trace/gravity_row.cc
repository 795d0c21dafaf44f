#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
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
  Eigen::Matrix3d gram;   // of what the model leaves of them, columns of length 1 before
  Eigen::Vector3d right;  // with the output
  Eigen::Vector3d length;
};

// Everything that the model may bend to, taken off.
LeftColumns Left(const ChannelProblem& problem, const Effect& effect, const Selection& selection,
                 const ChannelFit& fit) {
  BasisContext context;
  context.channel = problem.channel();
  Eigen::MatrixXd gravity = problem.Columns(effect, context);
  selection.whitener().Apply(gravity);
  Eigen::MatrixXd tangent(fit.white.rows(), fit.white.cols() + fit.white_slopes.cols());
  tangent << fit.white, fit.white_slopes;
  const std::vector<Eigen::Index> kept = IndependentColumns(tangent.transpose() * tangent);
  const Projection model(tangent(Eigen::all, kept));
  LeftColumns out;
  out.length = gravity.colwise().norm().cwiseMax(1e-300);
  const Eigen::MatrixXd left = model.Off(gravity * out.length.cwiseInverse().asDiagonal());
  out.gram = left.transpose() * left;
  out.right = left.transpose() * fit.WhiteResidual();
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
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    if (selection.members()[i].effect != &effect) continue;
    row.in_model = true;
    row.value = fit.values.segment<3>(fit.member_begin[i]);
    row.std_error = grow * fit.covariance.diagonal().segment<3>(fit.member_begin[i]).cwiseSqrt();
    Judge(effect, selection, {true, true, true}, &row);
    return row;
  }
  const LeftColumns left = Left(problem, effect, selection, fit);
  const SeenSolution solved = SolveSeen(left.gram, left.right, kAbsorbed);
  row.value = solved.values.cwiseQuotient(left.length);
  row.std_error = grow * solved.covariance.diagonal().cwiseSqrt().cwiseQuotient(left.length);
  Judge(effect, selection, solved.seen, &row);
  return row;
}

}  // namespace gyrobench::calibration
