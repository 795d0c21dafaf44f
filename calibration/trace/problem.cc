#include "calibration/trace/problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>

#include "calibration/gls/independent_columns.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastPath_deg = 5.0;  // of an axis that counts as turned
// An element of M beyond is not to be believed: data that do not tell axes apart.
constexpr double kMostOfRow = 2.0;

// Whether a motion after a rest is of other axes than the motion before it. What the reference errs
// by in those that stand now stays as it is.
class AxesAtRests {
 public:
  explicit AxesAtRests(const StateHistory& history)
      : history_(history),
        known_(history.recording->info.reference == ReferenceKind::kStandAngles) {}

  bool OthersBegin(std::size_t interval) {
    const bool rests = history_.still[interval], rested = std::exchange(rested_, rests);
    if (rests && !rested) stopped_ = history_.axis_errs[interval];
    if (!known_ || rests || !rested) return false;
    // A soft ramp begins before the readings leave the rest: then nobody knows which axis it is.
    if (std::ranges::none_of(history_.axis_errs[interval], std::identity())) return false;
    for (std::size_t a = 0; a < 3; ++a) {
      if (stopped_[a] && history_.axis_errs[interval][a]) return false;
    }
    return true;
  }

 private:
  const StateHistory& history_;
  bool known_, rested_ = false;
  std::array<bool, 3> stopped_ = {};
};

// A straight line of the offset, which the baseline is free to have, needs less of a range than
// effects of the temperature: a tenth of a degree moves the offset of an ordinary part by several
// standard errors of a rest.
constexpr double kLeastLine_degC = 0.05;

// A polynomial of the temperature needs a range to be seen.
int TemperatureOrder(double range_degC) {
  if (!(range_degC >= kLeastLine_degC)) return 0;
  if (range_degC < 3.0) return 1;
  return range_degC < 6.0 ? 2 : 3;
}

}  // namespace

ChannelProblem::ChannelProblem(std::span<const StateHistory> histories, std::size_t channel,
                               double units_per_deg_s, ReferenceAngleErrors angle_errors,
                               std::vector<MisreadAxis> misread)
    : histories_(histories),
      channel_(channel),
      units_per_deg_s_(units_per_deg_s),
      angle_errors_(std::move(angle_errors)),
      misread_(std::move(misread)) {
  std::vector<double> output;
  double last_end_s = 0.0;
  bool new_power_on = true;
  for (std::size_t t = 0; t < histories.size(); ++t) {
    const StateHistory& history = histories[t];
    const std::vector<Node>& nodes = history.epochs;
    bool skipped_motion = true, first = true;
    AxesAtRests axes(history);
    // One whose first measurement has nothing to use begins with the next.
    new_power_on = new_power_on || history.new_power_on;
    for (std::size_t i = 0; i < history.still.size(); ++i) {
      const bool other_axis = axes.OthersBegin(i);
      if (!history.usable[i][channel]) {
        skipped_motion = skipped_motion || !history.still[i];
        continue;
      }
      if (first) run_begins_.push_back(rows());
      if (new_power_on) power_on_begins_.push_back(rows());
      Interval interval;
      interval.duration_s = nodes[i + 1].at.t_s - nodes[i].at.t_s;
      interval.still = history.still[i];
      interval.gap_before_s = new_power_on ? 0.0 : std::max(0.0, nodes[i].at.t_s - last_end_s);
      interval.new_reference = skipped_motion;
      interval.other_axis = other_axis;
      interval.new_run = new_power_on && !rows_.empty();
      interval.end_reference_walk_s = history.reference_walk_s[i + 1];
      interval.begin_reference_walk_s = history.reference_walk_s[i];
      intervals_.push_back(interval);
      rows_.push_back({static_cast<std::uint32_t>(t), static_cast<std::uint32_t>(i)});
      output.push_back((nodes[i + 1].at.z[channel] - nodes[i].at.z[channel]) / units_per_deg_s);
      last_end_s = nodes[i + 1].at.t_s;
      first = skipped_motion = new_power_on = false;
    }
    power_on_of_trail_.push_back(power_on_begins_.empty() ? 0 : power_on_begins_.size() - 1);
  }
  output_ = Eigen::Map<const Eigen::VectorXd>(output.data(), rows());
  misread_places_.resize(rows(), 0);
  Survey();
  TakeOffNominalTurn();
  const Vector3 row = RowOfM();
  ShareReferenceErrors(row);
  MoveReadingErrorToOutput(row);
  TakeOffMisread(row);
  FindMisreadPlaces(row[channel_]);
  if (corrected_drift_ppm() != 0.0) output_ -= row[channel_] * DriftCorrection_deg();
}

// Where the axis turned by itself its scale factor has a column, and Earth's rotation is in that;
// where it did not, Earth still turns it, by the nominal scale factor, and so does what it turned
// together with another axis: an axis of the stand that is not quite where it was tilts it a little
// more or less. Other references than the angles of a stand's axes say nothing of such small turns.
void ChannelProblem::TakeOffNominalTurn() {
  if (TurnsByItself()) return;
  const bool turns = TurnsWithOthersAlone();
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const std::vector<Node>& nodes = history(i).epochs;
    const std::uint32_t interval = ref(i).interval;
    const bool of_axes = history(i).recording->info.reference == ReferenceKind::kStandAngles;
    const double earth_deg =
        nodes[interval + 1].earth_deg[channel_] - nodes[interval].earth_deg[channel_];
    output_(i) -= turns || of_axes ? Rotation(i)[channel_] : earth_deg;
  }
}

// As least squares of the baseline gives it: noise is small beside what moves.
Vector3 ChannelProblem::RowOfM() const {
  Vector3 row = {};
  row[channel_] = 1.0;
  const Baseline baseline = MakeBaseline();
  if (baseline.turned.empty()) return row;
  const auto columns = baseline.columns.leftCols(baseline.of_sensor());
  const Eigen::VectorXd fit =
      SolveIndependent(columns.transpose() * columns, columns.transpose() * output_);
  for (std::size_t j = 0; j < baseline.turned.size(); ++j) {
    const double m = fit(static_cast<Eigen::Index>(j));
    if (std::fabs(m) < kMostOfRow) row[baseline.turned[j]] = m;
  }
  return row;
}

void ChannelProblem::ShareReferenceErrors(const Vector3& row_of_m) {
  for (Eigen::Index i = 0; i < rows(); ++i) {
    Interval& interval = intervals_[static_cast<std::size_t>(i)];
    interval.begin_reference_share = history(i).ReferenceShare(ref(i).interval, row_of_m);
    interval.end_reference_share = history(i).ReferenceShare(ref(i).interval + 1, row_of_m);
  }
}

// At steady speed the rates of the halves are those of the neighbours, without the noise of the
// row's own two readings, and every column that depends on the rate has them. What the readings say
// beyond that is noise of the output, where it is whitened. In a column it would be noise that the
// output has as well, and effects that are nearly one, such as a scale that depends on the
// temperature and one that depends on its rate, would be found by it.
void ChannelProblem::MoveReadingErrorToOutput(const Vector3& row_of_m) {
  for (const std::size_t c : turned_) {
    const Eigen::VectorXd by_rates_deg = TurnByRates(c);
    for (Eigen::Index i = 0; i < rows(); ++i)
      output_(i) -= row_of_m[c] * (Rotation(i)[c] - by_rates_deg(i));
  }
}

Eigen::VectorXd ChannelProblem::TurnByRates(std::size_t axis) const {
  return RateColumn([&](const SensorState& point) { return point.rate_deg_s[axis]; });
}

bool ChannelProblem::TurnsByItself() const { return !turned_.empty() && turned_[0] == channel_; }

bool ChannelProblem::TurnsWithOthersAlone() const {
  return path_[channel_] > kLeastPath_deg && !TurnsByItself();
}

// Axes that turn by more than a tenth of their motion apart from the others: of those that always
// turn together the one that turns most stands for all, and this channel's own where it turns at
// least half as much. What is left of the rest is the noise of readings, which would make up a
// scale factor. So would a small part of every turn, as an axis has that another tilts: it is no
// better known than the angle of the tilt.
void ChannelProblem::SurveyTurns() {
  constexpr double kApart = 0.01;  // of the square
  constexpr double kTilt = 0.1;    // of the turn, as by a tilt of 6 deg
  constexpr double kOwnCounts = 2.0;
  Vector3 beyond_tilt_deg = {};
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < rows(); ++i) {
    if (half(i, 0).still) continue;
    const Eigen::Vector3d turn_deg(Rotation(i).data());
    squares += turn_deg * turn_deg.transpose();
    for (std::size_t c = 0; c < 3; ++c) {
      const double turned_deg = std::fabs(Rotation(i)[c]);
      if (turned_deg > kTilt * turn_deg.norm()) beyond_tilt_deg[c] += turned_deg;
    }
  }
  std::array<std::size_t, 3> axes = {channel_, (channel_ + 1) % 3, (channel_ + 2) % 3};
  const auto counts = [&](std::size_t c) { return (c == channel_ ? kOwnCounts : 1.0) * path_[c]; };
  std::stable_sort(axes.begin(), axes.end(),
                   [&](std::size_t a, std::size_t b) { return counts(a) > counts(b); });
  // Of each axis what those before it leave, as in Gram and Schmidt's way.
  Eigen::Matrix3d left = squares;
  std::array<bool, 3> turned = {};
  for (const std::size_t c : axes) {
    const auto k = static_cast<Eigen::Index>(c);
    if (!(beyond_tilt_deg[c] > kLeastPath_deg) || !(left(k, k) > kApart * squares(k, k))) continue;
    turned[c] = true;
    const Eigen::Vector3d column = left.col(k);
    left -= column * column.transpose() / column(k);
  }
  // Its own first.
  for (const std::size_t c : {channel_, (channel_ + 1) % 3, (channel_ + 2) % 3}) {
    if (turned[c]) turned_.push_back(c);
  }
}

ChannelProblem ChannelProblem::Part(const std::vector<Eigen::Index>& rows) const {
  ChannelProblem out = *this;
  out.rows_.clear();
  out.intervals_.clear();
  out.feels_table_.clear();
  out.felt_axes_.clear();
  out.run_begins_.clear();
  out.power_on_begins_.clear();
  out.output_ = output_(rows);
  out.misread_places_ = misread_places_(rows, Eigen::all);
  Eigen::Index next = 0;  // of the rows, the first that was neither kept nor left out yet
  for (const Eigen::Index row : rows) {
    Interval interval = intervals_[static_cast<std::size_t>(row)];
    for (; next < row; ++next) {
      const Interval& left_out = intervals_[static_cast<std::size_t>(next)];
      if (power_on(next) == power_on(row)) {
        interval.gap_before_s += left_out.gap_before_s + left_out.duration_s;
        interval.bias_jump_per_s += left_out.bias_jump_per_s;
      }
      interval.new_reference = interval.new_reference || left_out.new_reference || !left_out.still;
    }
    next = row + 1;
    const Eigen::Index index = out.rows();
    if (index == 0 || out.rows_.back().history != ref(row).history)
      out.run_begins_.push_back(index);
    if (power_on(row) == out.power_on_begins_.size()) {
      out.power_on_begins_.push_back(index);
      interval.gap_before_s = 0.0;
      interval.new_reference = true;
      interval.new_run = index > 0;
    }
    out.intervals_.push_back(interval);
    out.rows_.push_back(ref(row));
    out.feels_table_.push_back(FeelsTable(row));
    out.felt_axes_.push_back(felt_axes_[static_cast<std::size_t>(row)]);
  }
  out.ShareReferenceErrors(out.RowOfM());
  return out;
}

Baseline Baseline::Part(const std::vector<Eigen::Index>& rows) const {
  Baseline out = *this;
  out.columns = columns(rows, Eigen::all);
  return out;
}

ChannelProblem::Between ChannelProblem::between(Eigen::Index row) const {
  const std::size_t i = ref(row).interval;
  const BetweenSamples& between = history(row).between[i];
  const std::vector<Node>& epochs = history(row).epochs;
  const double square = units_per_deg_s_ * units_per_deg_s_;
  const auto at_node = [&](const Node& node) -> Between::AtNode {
    return {node.as_means[channel_] / units_per_deg_s_,
            node.as_means_later[channel_] / units_per_deg_s_};
  };
  return {between.corners[channel_] / square, between.steps[channel_] / square,
          between.bends[channel_] / units_per_deg_s_, at_node(epochs[i]), at_node(epochs[i + 1])};
}

double ChannelProblem::begin_s(Eigen::Index row) const {
  return history(row).nodes[ref(row).interval].t_s;
}
double ChannelProblem::end_s(Eigen::Index row) const { return end_node(row).t_s; }
const SensorState& ChannelProblem::half(Eigen::Index row, std::size_t h) const {
  return history(row).midpoints[2 * ref(row).interval + h];
}
const SensorState& ChannelProblem::end_node(Eigen::Index row) const {
  return history(row).nodes[ref(row).interval + 1];
}

const Node& ChannelProblem::end_epoch(Eigen::Index row) const {
  return history(row).epochs[ref(row).interval + 1];
}

double ChannelProblem::gear_ratio() const {
  for (const StateHistory& history : histories_) {
    if (history.recording->info.gear_ratio) return *history.recording->info.gear_ratio;
  }
  return kMissing;
}

std::vector<bool> ChannelProblem::turns_in_run() const {
  std::vector<double> path_deg(histories_.size(), 0.0);
  for (Eigen::Index i = 0; i < rows(); ++i) {
    if (!half(i, 0).still) path_deg[ref(i).history] += std::fabs(Rotation(i)[channel_]);
  }
  std::vector<bool> turns;
  for (const double path : path_deg) turns.push_back(path > kLeastPath_deg);
  return turns;
}

double ChannelProblem::rounding_deg() const {
  double rounding_deg = 0.0;
  for (const StateHistory& history : histories_)
    rounding_deg = std::max(rounding_deg, history.rounding_deg);
  return rounding_deg;
}

double ChannelProblem::output_rounding_deg_s() const {
  double wave = 0.0;
  for (const StateHistory& history : histories_)
    wave = std::max(wave, history.recording->rounding[channel_].wave);
  return wave / std::fabs(units_per_deg_s_);
}

// Of an even spread over a step, of which the wave is the first harmonic.
double ChannelProblem::rounding_error_deg(std::size_t axis) const {
  return rounding_wave_deg_[axis] * std::numbers::pi / std::sqrt(12.0);
}

double ChannelProblem::LargestStep_deg(std::size_t axis) const {
  double step_deg = 0.0;
  for (const StateHistory& history : histories_) {
    if (const double own_deg = history.rest_flicker[axis].step_deg; std::isfinite(own_deg))
      step_deg = std::max(step_deg, own_deg);
  }
  return step_deg;
}

// Also where this channel has nothing usable in it.
std::size_t ChannelProblem::first_number(std::size_t power_on) const {
  std::size_t first = ref(power_on_begins_[power_on]).history;
  while (first > 0 && !histories_[first].new_power_on) --first;
  return histories_[first].number;
}

double ChannelProblem::angle_error_deg(std::size_t axis) const {
  double error_deg = 0.0;
  for (const StateHistory& history : histories_)
    error_deg = std::max(error_deg, history.axis_error_deg[axis]);
  return error_deg;
}

Baseline ChannelProblem::MakeBaseline() const {
  Baseline out;
  out.turned = turned_;
  out.constants = power_on_begins_.size();
  const double range = max_temperature_ - min_temperature_;
  out.temperature_order = temperature_known_ ? TemperatureOrder(range) : 0;
  out.reference_degC = mean_temperature_;
  const auto turned = static_cast<Eigen::Index>(out.turned.size());
  const auto constants = static_cast<Eigen::Index>(out.constants);
  out.filter_shapes = DelayIsDeclared() ? 1 : 0;
  out.misread_places = static_cast<int>(misread_places_.cols());
  const Eigen::Index of_sensor = turned + constants + out.temperature_order + out.filter_shapes;
  out.columns = Eigen::MatrixXd::Zero(rows(), of_sensor + out.misread_places);
  Eigen::Index power_on = -1;
  for (Eigen::Index i = 0; i < rows(); ++i) {
    if (power_on + 1 < constants && power_on_begins_[static_cast<std::size_t>(power_on + 1)] == i)
      ++power_on;
    const double dt = intervals_[static_cast<std::size_t>(i)].duration_s;
    out.columns(i, turned + power_on) = dt;
  }
  for (Eigen::Index j = 0; j < turned; ++j)
    out.columns.col(j) = Turn(out.turned[static_cast<std::size_t>(j)]);
  for (int k = 0; k < out.temperature_order; ++k)
    out.columns.col(turned + constants + k) = TemperaturePower(k + 1);
  if (out.filter_shapes > 0) out.columns.col(of_sensor - 1) = FilterShape();
  out.columns.rightCols(out.misread_places) = misread_places_;
  return out;
}

// Of (T - T0)^power, in degC^power s.
Eigen::VectorXd ChannelProblem::TemperaturePower(int power) const {
  return RateColumn([&](const SensorState& point) {
    return std::pow(point.temperature_degC - mean_temperature_, power);
  });
}

Eigen::MatrixXd ChannelProblem::Columns(const Effect& effect, const BasisContext& context,
                                        std::optional<std::size_t> power_on) const {
  Eigen::MatrixXd out(rows(), static_cast<Eigen::Index>(effect.terms.size()));
  if (power_on) {
    out.setZero();
    const Eigen::Index first = begin_of(*power_on);
    FillColumns(effect, context, power_on, out.middleRows(first, end_of(*power_on) - first));
  } else {
    FillColumns(effect, context, power_on, out);
  }
  return out;
}

Eigen::MatrixXd ChannelProblem::ColumnsIn(std::size_t power_on, const Effect& effect,
                                          const BasisContext& context) const {
  Eigen::MatrixXd out(end_of(power_on) - begin_of(power_on),
                      static_cast<Eigen::Index>(effect.terms.size()));
  FillColumns(effect, context, power_on, out);
  return out;
}

void ChannelProblem::FillColumns(const Effect& effect, const BasisContext& context,
                                 std::optional<std::size_t> power_on,
                                 Eigen::Ref<Eigen::MatrixXd> out) const {
  const std::size_t terms = effect.terms.size();
  const std::unique_ptr<Basis> basis = effect.basis(context);
  std::vector<double> a(terms), b(terms);
  const bool table = (effect.needs & kNeedsTableAxis) != 0;
  const Eigen::Index first = power_on ? begin_of(*power_on) : 0;
  auto row = static_cast<std::size_t>(first);
  for (std::size_t t = 0; t < histories_.size(); ++t) {
    if (power_on && power_on_of_trail_[t] != *power_on) continue;
    const StateHistory& history = histories_[t];
    if (effect.domain != EffectDomain::kRate && !history.nodes.empty())
      basis->At(history.nodes.front(), b.data());
    for (std::size_t i = 0; i < history.still.size(); ++i) {
      if (effect.domain == EffectDomain::kRate) {
        basis->At(history.midpoints[2 * i], a.data());
        basis->At(history.midpoints[2 * i + 1], b.data());
      } else {
        std::swap(a, b);
        basis->At(history.nodes[i + 1], b.data());
      }
      if (row == rows_.size() || rows_[row].history != t || rows_[row].interval != i) continue;
      const auto index = static_cast<Eigen::Index>(row++);
      const double half_s = 0.5 * intervals_[static_cast<std::size_t>(index)].duration_s;
      FeltAxis felt = {.turn = 1.0};
      if (table)
        felt = history.still[i] ? FeltAxis{}
                                : felt_axes_[static_cast<std::size_t>(index)][context.table_axis];
      for (std::size_t j = 0; j < terms; ++j) {
        out(index - first, static_cast<Eigen::Index>(j)) =
            effect.domain == EffectDomain::kRate
                ? half_s * (a[j] + b[j])
                : felt.turn * (b[j] - a[j]) + 0.5 * felt.direction * (a[j] + b[j]);
      }
    }
  }
}

}  // namespace gyrobench::calibration
