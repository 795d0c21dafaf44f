// What is no finding by its own standard error, and what is one though its shape is not known.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Two standard errors of one value: the logarithm of the chance of more.
const double kUncertain = LogChiSquareTail(4.0, 1.0);

// Of values that are zero in truth: logarithm of the chance of being as far from it. Values that
// were left at zero have no variance and do not count.
double LogChanceOfNone(const Eigen::VectorXd& values, const Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> known;
  for (Eigen::Index j = 0; j < values.size(); ++j) {
    if (covariance(j, j) > 0.0) known.push_back(j);
  }
  if (known.empty()) return 0.0;
  const Eigen::VectorXd some = values(known);
  const double square = ScaledLdlt(covariance(known, known)).Solve(some).col(0).dot(some);
  return LogChiSquareTail(square, static_cast<double>(known.size()));
}

// Of all that are known together.
double VarianceOf(const Eigen::MatrixXd& covariance) {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < covariance.rows(); ++j)
    sum += covariance(j, j) > 0.0 ? covariance(j, j) : 0.0;
  return sum;
}

// A lag of the gyro's filter that a delay takes back but for a twentieth: two causes that hardly
// ever do so, and their columns are then one but for the acceleration, which the gyro's own noise
// makes up a part of. The delay alone is what is known. Index of the lag; nothing where there is
// none.
std::optional<std::size_t> LagThatADelayTakesBack(const Selection& selection,
                                                  const ChannelFit& fit) {
  constexpr double kLeft = 0.05;
  const std::vector<Candidate>& members = selection.members();
  for (std::size_t lag = 0; lag < members.size(); ++lag) {
    if (members[lag].effect == nullptr || !members[lag].effect->filter_shape ||
        members[lag].is_delay())
      continue;
    const double late_s = fit.values(fit.member_begin[lag]);
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (!members[i].is_delay() || members[i].of_one_run()) continue;
      const double delay_s = fit.values(fit.member_begin[i]);
      if (std::fabs(late_s + delay_s) < kLeft * std::fabs(late_s)) return lag;
    }
  }
  return std::nullopt;
}

// What the delay had gained was beside the lag.
void RemoveLag(std::size_t lag, Selection* selection) {
  selection->Remove(lag);
  for (std::size_t i = 0; i < selection->members().size(); ++i) {
    if (selection->members()[i].is_delay())
      selection->SetGainByAnyNoise(i, std::numeric_limits<double>::infinity());
  }
}

}  // namespace

void DropUncertain(const ChannelProblem& problem, const Baseline& baseline, Selection* selection) {
  for (bool again = true; again && !selection->members().empty();) {
    again = false;
    const ChannelFit fit = FitChannel(problem, baseline, *selection);
    if (const auto lag = LagThatADelayTakesBack(*selection, fit)) {
      RemoveLag(*lag, selection);
      again = true;
      continue;
    }
    const double grow = std::max(1.0, fit.whitened_rms());
    std::size_t weakest = selection->members().size();
    double log_p = kUncertain;
    for (std::size_t i = 0; i < selection->members().size(); ++i) {
      const auto count = static_cast<Eigen::Index>(fit.ColumnsOf(i).size());
      const Eigen::Index first = fit.member_begin[i];
      const Eigen::VectorXd values = fit.values.segment(first, count);
      const Eigen::MatrixXd covariance = fit.covariance.block(first, first, count, count);
      // Of a size that another channel bounds, and that is not known within that here: nothing.
      const bool unknown = VarianceOf(covariance) > std::pow(selection->members()[i].largest, 2);
      const double own = unknown ? 0.0 : LogChanceOfNone(values / grow, covariance);
      if (own <= log_p) continue;
      log_p = own;
      weakest = i;
    }
    if (weakest == selection->members().size()) return;
    if (selection->members()[weakest].shape_is_free()) {
      selection->HoldShape(weakest, ShapeOfLeastSize(problem, *selection, weakest));
    } else {
      selection->Remove(weakest);
    }
    again = true;
  }
}

std::vector<std::string> RemarksOnHeldShapes(const Selection& selection) {
  std::vector<std::string> out;
  for (const Candidate& member : selection.members()) {
    if (!member.shape_held) continue;
    std::vector<std::string> names;
    if (member.effect != nullptr) {
      for (const NonlinearParameter& parameter : member.effect->nonlinear)
        names.push_back(parameter.name);
    } else {
      names.push_back(member.origin->parameter());
    }
    if (member.size_unknown()) {
      names.insert(names.begin(), "its size");
      out.push_back(fmt::format(
          "{}: these data know what it does in them, but not {} and {} apart, which have no "
          "standard error; at other conditions it may do more or less",
          member.id, fmt::join(names.begin(), names.end() - 1, ", "), names.back()));
    } else {
      out.push_back(
          fmt::format("{}: its size is known at the conditions of these data, but not "
                      "{}, which {} no standard error",
                      member.id, fmt::join(names, " and "), names.size() == 1 ? "has" : "have"));
    }
  }
  return out;
}

}  // namespace gyrobench::calibration
