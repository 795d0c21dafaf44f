// What is known beside the nodes' means, as further rows of the least squares: what single readings
// say, and the priors of misread places.
#include <algorithm>

#include "calibration/trace/selection.h"

namespace gyrobench::calibration {

bool Selection::HasReadings(const Candidate& candidate) const {
  return !within_.empty() && candidate.effect != nullptr && candidate.effect->of_each_reading;
}

void Selection::HoldMisreadPlaces(Eigen::Index count) {
  if (count == 0 && within_.empty()) return;
  const Eigen::Index readings = within_.output().size();
  Eigen::VectorXd output = Eigen::VectorXd::Zero(readings + count);
  output.head(readings) = within_.output();
  store_.SetMoreOfOutput(std::move(output));
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(readings + count, count);
  rows.bottomRows(count).setIdentity();
  store_.SetMore({base_.end() - count, base_.end()}, rows);
}

void Selection::TakeInMoreRows(const Baseline& baseline) {
  within_ = WithinNodes(*problem_, baseline, store_.Solve(base_), walk_deg_sqrt_s_);
  if (within_.empty()) return;
  HoldMisreadPlaces(baseline.misread_places);
  for (const Candidate& candidate : pool_) SetMore(candidate);
}

Eigen::VectorXd Selection::OutputOfReadings() const {
  return store_.more_of_output().head(within_.output().size());
}

Eigen::VectorXd Selection::ResidualOfReadings(const WhiteStore::Columns& model) const {
  return store_.MoreOfResidual(model).head(within_.output().size());
}

Eigen::MatrixXd Selection::ColumnsOfReadings(const Candidate& candidate) const {
  return HasReadings(candidate)
             ? within_.Columns(*candidate.effect, candidate.context, candidate.power_on)
             : Eigen::MatrixXd(within_.output().size(), 0);
}

void Selection::SetMore(const Candidate& candidate) {
  if (!HasReadings(candidate)) return;
  const Eigen::MatrixXd columns = ColumnsOfReadings(candidate);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(store_.more_of_output().size(), columns.cols());
  rows.topRows(columns.rows()) = columns;
  store_.SetMore(candidate.columns, rows);
}

void Selection::Store(Candidate* candidate) {
  candidate->columns = store_.Add(White(*candidate));
  SetMore(*candidate);
}

// Gain of all rows less that of the nodes' alone.
double Selection::GainByReadings(std::size_t member) {
  if (!HasReadings(members_[member])) return 0.0;
  const WhiteStore::Columns others = ModelWithout(member);
  const auto gain = [&](const WhiteStore::Columns& own) {
    WhiteStore::Columns with = others;
    with.insert(with.end(), own.begin(), own.end());
    return store_.FitTo(others).residual_square - store_.FitTo(with).residual_square;
  };
  const Eigen::Index mark = store_.used();
  const double by_nodes = gain(store_.Add(White(members_[member])));
  store_.DropFrom(mark);
  return std::max(gain(members_[member].columns) - by_nodes, 0.0);
}

bool Selection::ReadingsConfirm(std::size_t member) {
  const Candidate& candidate = members_[member];
  const double gain = GainByReadings(member);
  return gain > 0.0 && candidate.LogChance(gain, static_cast<double>(candidate.columns.size())) <
                           candidate.log_level;
}

}  // namespace gyrobench::calibration
