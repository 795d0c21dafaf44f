// The least-squares problem of one channel over all measurements: rows, output, and the columns of
// anything that may act on it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/effects/factor.h"
#include "calibration/gls/interval_gls.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/misread_axis.h"
#include "calibration/trace/reference_angle_error.h"

namespace gyrobench::calibration {

// Effects of the temperature need this range to be told from other slow ones.
inline constexpr double kLeastTemperatureRange_degC = 1.0;

// Of the stand, as parameters and remarks name them.
inline constexpr std::array<const char*, 3> kTableAxisNames = {"outer", "middle", "inner"};

// Of one axis, in one interval.
struct FeltAxis {
  // Of a turn of the axis: what the channel turns by [deg per deg].
  double turn = 0.0;
  // Of an angle by which the axis is read wrong all along the interval: what the channel turns by
  // more than the readings say, since the motions of the axes outside of it come from another
  // direction [deg per deg].
  double direction = 0.0;
};

// By stand axis. Of a single-axis reference: that axis of the sensor. All 0 for an orientation.
std::array<FeltAxis, 3> FeelAxes(const StateHistory& history, std::size_t interval,
                                 std::size_t channel);

// In one measurement at least.
bool GyroDelayIsDeclared(std::span<const StateHistory> histories);

// One interval of one measurement.
struct ProblemRow {
  std::uint32_t history = 0;
  std::uint32_t interval = 0;
};

// Columns of the baseline: M w + b(T), and the shape of the filter whose delay is declared: a
// filter that is late by d shows the angle Phi(t - d) + c dw/dt, with c = 0 for a pure delay, d^2/2
// for a lag of first order. The turns of a short motion would else have another scale factor.
struct Baseline {
  std::vector<std::size_t> turned;   // sensor axes with a column of M, its own first; may be empty
  std::size_t constants = 0;         // zero-rate offsets: one a power-on
  int temperature_order = 0;         // of b(T) beyond the constant
  double reference_degC = kMissing;  // T0
  int filter_shapes = 0;             // 1 where a delay of the gyro is declared: c [deg per deg/s^2]
  // Errors of the angles at which an axis rests on the steps of its encoder while others turn, each
  // in its standard deviations: its prior is 0 +- 1, which Selection and NoiseSearch hold it to.
  int misread_places = 0;
  // rows x (turned + constants + temperature_order + filter_shapes + misread_places)
  Eigen::MatrixXd columns;

  // Without the misread places, which are no parameters of the sensor.
  Eigen::Index of_sensor() const { return columns.cols() - misread_places; }

  Baseline Part(const std::vector<Eigen::Index>& rows) const;
};

// A channel that shows less of a table's rate than this has no scale factor that angles could be
// divided by.
inline constexpr double kLeastScaleFactor = 1e-3;

class ChannelProblem {
 public:
  // `histories` must outlive the problem. `units_per_deg_s`: s0. `angle_errors`: those about
  // other axes are added to the turns about them; the delays about its own axis are the time after
  // which the reference has the shape of the filter. `misread`: what these axes turn the directions
  // of motions by is taken off the output.
  ChannelProblem(std::span<const StateHistory> histories, std::size_t channel,
                 double units_per_deg_s, ReferenceAngleErrors angle_errors = {},
                 std::vector<MisreadAxis> misread = {});
  // Some of its rows, in order, as if the others had not been measured: what happened in them is
  // known, what the sensor said is not. Every power-on must keep a row.
  ChannelProblem Part(const std::vector<Eigen::Index>& rows) const;

  std::size_t channel() const { return channel_; }
  Eigen::Index rows() const { return static_cast<Eigen::Index>(rows_.size()); }
  const std::vector<ProblemRow>& row_refs() const { return rows_; }
  const std::vector<Interval>& intervals() const { return intervals_; }
  // y = int xi / s0 dt of each row, less M (turn by the row's two readings - turn by the rates of
  // its halves): y = M (turn by rates) + noise of the gyro - M (error of the readings).
  const Eigen::VectorXd& output_deg() const { return output_; }
  // Of a row: what the rate did between samples, as of BetweenSamples.
  struct Between {
    double corners_deg2 = 0.0, steps_deg2 = 0.0, bends_deg = 0.0;
    // AsMeans at a node and half an interval of the samples after it.
    struct AtNode {
      double as_means_deg = 0.0, as_means_later_deg = 0.0;
    };
    AtNode begin, end;
  };
  Between between(Eigen::Index row) const;
  // By which the reference's readings were put on the gyro's clock; 0 where they were not, or the
  // channel does not turn. The output is as if they had not been: that the clocks part is an effect
  // to be found.
  double corrected_drift_ppm() const;
  // What the correction makes of how far the channel's axis turned beyond the reference, row by row.
  Eigen::VectorXd DriftCorrection_deg() const;
  void AddOutput(const Eigen::VectorXd& more_deg) { output_ += more_deg; }
  // Other noise of the same rows, in order.
  void SetIntervals(std::vector<Interval> intervals) { intervals_ = std::move(intervals); }
  std::span<const StateHistory> histories() const { return histories_; }
  const StateHistory& history(Eigen::Index row) const { return histories_[ref(row).history]; }
  double begin_s(Eigen::Index row) const;
  double end_s(Eigen::Index row) const;
  const SensorState& half(Eigen::Index row, std::size_t h) const;
  const SensorState& end_node(Eigen::Index row) const;
  const Node& end_epoch(Eigen::Index row) const;
  double units_per_deg_s() const { return units_per_deg_s_; }
  // Rows at which another measurement begins.
  const std::vector<Eigen::Index>& run_begins() const { return run_begins_; }
  // Rows at which another power-on begins, and with it another zero-rate offset. Measurements of
  // one power-on share theirs: its random walk goes on through the gaps between them.
  const std::vector<Eigen::Index>& power_on_begins() const { return power_on_begins_; }
  // Of a row: index of its power-on.
  std::size_t power_on(Eigen::Index row) const { return power_on_of_trail_[ref(row).history]; }
  // Its rows.
  Eigen::Index begin_of(std::size_t power_on) const { return power_on_begins_[power_on]; }
  Eigen::Index end_of(std::size_t power_on) const {
    return power_on + 1 < power_on_begins_.size() ? power_on_begins_[power_on + 1] : rows();
  }
  // Of the first measurement of a power-on, as they were given, from 1.
  std::size_t first_number(std::size_t power_on) const;

  Baseline MakeBaseline() const;
  // rows() x terms: what each term of the effect adds to each row's output, per unit. `power_on`:
  // of an effect without a memory that acts in this one alone.
  Eigen::MatrixXd Columns(const Effect& effect, const BasisContext& context,
                          std::optional<std::size_t> power_on = {}) const;
  // The same of the power-on's own rows, beyond which it is 0.
  Eigen::MatrixXd ColumnsIn(std::size_t power_on, const Effect& effect,
                            const BasisContext& context) const;
  // What the misread axes may turn the directions of motions by more than was taken off, by
  // independent standard deviations of what was found: rows() x these [deg].
  Eigen::MatrixXd MisreadDeviations() const;
  // What they are of, the same for all channels that were told the same.
  std::vector<std::string> NamesOfMisreadDeviations() const;
  // The same for a rate [deg/s per unit] that is a function of the state.
  template <typename RateOf>
  Eigen::VectorXd RateColumn(RateOf rate_of) const {
    Eigen::VectorXd out(rows());
    for (Eigen::Index i = 0; i < rows(); ++i) {
      const double half_s = 0.5 * intervals_[static_cast<std::size_t>(i)].duration_s;
      out(i) = half_s * (rate_of(half(i, 0)) + rate_of(half(i, 1)));
    }
    return out;
  }

  // The axis turned, but always together with others: its scale factor is taken as nominal.
  bool TurnsWithOthersAlone() const;
  // What the measurements allow: Needs, as bits.
  unsigned observables() const { return observables_; }
  // The gyro's delay is stated, with which its filter's shape is free in the baseline.
  bool DelayIsDeclared() const;
  // Axes of the table whose turning the channel feels.
  const std::vector<std::size_t>& table_axes() const { return table_axes_; }
  // These, and those that turn while others' motions are felt: an error of their angle is felt.
  const std::vector<std::size_t>& axes_with_felt_errors() const { return axes_with_felt_errors_; }
  // Of each run: whether the sensor turns about the channel's axis.
  std::vector<bool> turns_in_run() const;
  // Of a run, by its place from 0: its number as the measurements were given, from 1.
  std::size_t number_of_run(std::size_t place) const { return histories_[place].number; }
  double gear_ratio() const;
  double min_temperature_degC() const { return min_temperature_; }
  double max_temperature_degC() const { return max_temperature_; }
  double max_rate_deg_s() const { return max_rate_; }
  double mean_rate_in_motion_deg_s() const { return mean_rate_in_motion_; }
  // What rounding errs by in motion where the steps of an encoder are coarser than its noise, the
  // largest; 0 where they are not [deg]. It is a function of the angle.
  double rounding_deg() const;
  // The largest wave that rounding may make of this channel's rate (OutputRounding).
  double output_rounding_deg_s() const;
  // Of the encoders of all measurements, the coarsest; 0 where none has steps.
  double LargestStep_deg(std::size_t axis) const;
  // Of the readings of one of the table's axes, the largest of the measurements' [deg].
  double rounding_wave_deg(std::size_t axis) const { return rounding_wave_deg_[axis]; }
  // The standard deviation of the same [deg].
  double rounding_error_deg(std::size_t axis) const;
  // Of one of the table's axes at a node in motion, the largest of the measurements' [deg].
  double angle_error_deg(std::size_t axis) const;
  // The components of gravity along the sensor's axes: how far apart the largest and the smallest
  // are [g]. NaN where gravity is not known.
  const Vector3& gravity_range_g() const { return gravity_range_; }
  // How much of a turn of the table's axis the channel feels in a row.
  double AxisProjection(Eigen::Index row, std::size_t table_axis) const {
    return felt_axes_[static_cast<std::size_t>(row)][table_axis].turn;
  }
  // An axis of the table turns in a row, and the channel feels it.
  bool FeelsTable(Eigen::Index row) const { return feels_table_[static_cast<std::size_t>(row)]; }

 private:
  const ProblemRow& ref(Eigen::Index row) const { return rows_[static_cast<std::size_t>(row)]; }
  Eigen::VectorXd TemperaturePower(int power) const;
  Eigen::VectorXd FilterShape() const;
  // `out`: of the power-on's rows, or of all.
  void FillColumns(const Effect& effect, const BasisContext& context,
                   std::optional<std::size_t> power_on, Eigen::Ref<Eigen::MatrixXd> out) const;
  // Of the reference about the sensor's axes in a row [deg].
  const Vector3& Rotation(Eigen::Index row) const {
    return history(row).rotation_deg[ref(row).interval];
  }
  // The same of all rows, as the rates of their halves have it.
  Eigen::VectorXd TurnByRates(std::size_t axis) const;
  // The same, about another axis with the angle error there.
  Eigen::VectorXd Turn(std::size_t axis) const;
  // The channel's, by what the rows say.
  Vector3 RowOfM() const;
  void Survey();
  void TakeOffNominalTurn();
  bool TurnsByItself() const;
  void SurveyTurns();
  void ShareReferenceErrors(const Vector3& row_of_m);
  void MoveReadingErrorToOutput(const Vector3& row_of_m);
  Eigen::MatrixXd ColumnsOf(const MisreadAxis& misread) const;
  void TakeOffMisread(const Vector3& row_of_m);
  // `scale`: what the channel shows of an angle.
  void FindMisreadPlaces(double scale);
  bool PowerOnIsKnown() const;
  void SurveyTemperature();
  void SurveyGravity();
  void SurveyRounding();

  std::span<const StateHistory> histories_;
  std::size_t channel_;
  double units_per_deg_s_;
  ReferenceAngleErrors angle_errors_;
  std::vector<MisreadAxis> misread_;
  double misread_scale_ = 1.0;  // of the channel: what it shows of an angle
  std::vector<ProblemRow> rows_;
  std::vector<Interval> intervals_;
  std::vector<Eigen::Index> run_begins_, power_on_begins_;
  std::vector<std::size_t> power_on_of_trail_;
  Eigen::VectorXd output_;
  Eigen::MatrixXd misread_places_;  // as in Baseline::columns
  unsigned observables_ = 0;
  bool temperature_known_ = false;
  std::vector<std::size_t> table_axes_, axes_with_felt_errors_;
  std::vector<bool> feels_table_;
  // Of each row; every effect of the table asks for them.
  std::vector<std::array<FeltAxis, 3>> felt_axes_;
  Vector3 path_ = {};
  std::vector<std::size_t> turned_;  // Baseline::turned
  double min_temperature_ = kMissing, max_temperature_ = kMissing, mean_temperature_ = kMissing;
  double max_rate_ = 0.0, mean_rate_in_motion_ = 0.0;
  Vector3 rounding_wave_deg_ = {};
  Vector3 gravity_range_ = {kMissing, kMissing, kMissing};
};

}  // namespace gyrobench::calibration
