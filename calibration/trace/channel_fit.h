// The numbers of a chosen model, their errors.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace gyrobench::calibration {

struct Baseline;
struct Candidate;
class ChannelProblem;
class Selection;

// Columns of a model, and what they change by when a non-linear parameter does.
struct ModelColumns {
  Eigen::MatrixXd linear;                  // rows x columns (baseline, members) [deg per unit]
  std::vector<Eigen::Index> column_begin;  // of each member
  Eigen::MatrixXd slopes;                  // [deg per unit of the parameter]
  std::vector<Eigen::Index> slope_begin;   // of each member
};
// `coefficients`: of the linear columns.
ModelColumns ColumnsOfModel(const ChannelProblem& problem, const Baseline& baseline,
                            const std::vector<Candidate>& members,
                            const Eigen::VectorXd& coefficients,
                            const std::vector<std::string>& covariates);

// Parameters in the order: baseline columns without the misread places, then member by member its
// linear coefficients and its non-linear parameters.
struct ChannelFit {
  Eigen::VectorXd values;
  // At the Cramer-Rao bound, for the noise as estimated, and with the errors of misread axes.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd by_misread;  // of the parameters, by ChannelProblem::MisreadDeviations
  std::vector<Eigen::Index> member_begin;  // of each member's parameters
  Eigen::MatrixXd raw;                     // rows x linear columns (baseline, members)
  Eigen::MatrixXd white;                   // the same, whitened
  Eigen::VectorXd linear;                  // coefficients of these columns
  std::vector<Eigen::Index> column_begin;  // of each member, in raw and white
  // What the linear columns change by when a non-linear parameter does [deg per its unit].
  Eigen::MatrixXd raw_slopes, white_slopes;
  std::vector<Eigen::Index> slope_begin;  // of each member, in these
  // Of each linear column: only one measurement knows it, or one moment of it.
  std::vector<bool> local;
  Eigen::VectorXd white_output;
  Eigen::Index baseline_columns = 0;
  Eigen::Index misread_places = 0;  // of them, the last (Baseline::misread_places)
  // Products of the linear columns, then of the slopes, in further rows, with each other and with
  // the output there: of members in those of single readings (trace/within_nodes.h), of misread
  // places in those of their priors.
  Eigen::MatrixXd more_products;
  Eigen::VectorXd more_with_output;

  Eigen::VectorXd WhiteResidual() const { return white_output - white * linear; }
  double whitened_rms() const;
  // Columns of raw and white, and of their slopes, that belong to a member.
  std::vector<Eigen::Index> ColumnsOf(std::size_t member) const;
  std::vector<Eigen::Index> SlopesOf(std::size_t member) const;
  // Of linear columns and slopes: their places in more_products.
  std::vector<Eigen::Index> PlacesInMore(const std::vector<Eigen::Index>& columns,
                                         const std::vector<Eigen::Index>& slopes) const;
  // Columns of raw and white that are not in `without`.
  std::vector<Eigen::Index> ColumnsBut(const std::vector<Eigen::Index>& without) const;
};

ChannelFit FitChannel(const ChannelProblem& problem, const Baseline& baseline,
                      const Selection& selection);

// Of the shapes about a member's that explain as much, within a standard error, the one by which it
// is smallest: more than that the data do not ask for.
std::vector<double> ShapeOfLeastSize(const ChannelProblem& problem, const Selection& selection,
                                     std::size_t member);

// A value that is not clear of zero by its own standard errors is no finding. Where its
// non-linear parameters are what makes it uncertain, as of a resonance that one speed alone meets,
// the data know what the effect does but not its shape: that is held where the effect is smallest,
// and the value tried again.
void DropUncertain(const ChannelProblem& problem, const Baseline& baseline, Selection* selection);
// A sentence on each member whose shape is held so.
std::vector<std::string> RemarksOnHeldShapes(const Selection& selection);

}  // namespace gyrobench::calibration
