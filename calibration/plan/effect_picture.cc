#include "calibration/plan/effect_picture.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "base/geometry.h"
#include "calibration/plan/foresee.h"
#include "calibration/signal/collector.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/problem.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kChannel = 2, kTable = 2;  // z, inner
const std::vector<std::string> kColumns = {"x"};

// PictureMotion.
constexpr std::array kPoses_deg = {0.0, 90.0, 180.0};  // of the middle axis
constexpr std::array kRates_deg_s = {6.0, 12.0, 18.0, 27.0, 36.0};
constexpr double kAcceleration_deg_s2 = 40.0, kRest_s = 20.0;
// Surroundings.
constexpr double kCold_degC = 25.0, kHot_degC = 40.0, kWarms_s = 200.0;
constexpr double kResonance_deg_s = 18.0, kWidth_deg_s = 4.0, kShakes_g = 0.1;
constexpr double kColumnPeriod_s = 140.0;
constexpr double kStep_s = 0.02;
constexpr int kSamplesPerPictureReading = 5;
// Where a scan finds what has a place of its own.
constexpr double kStepAt_s = 400.0, kToneAt_hz = 0.004, kPeriodsInTurn = 6.0;

struct PictureMotion {
  std::vector<ForeseenMove> moves;
  double duration_s = 0.0;

  void Turn(StandAxis axis, double from_deg, double to_deg, double rate_deg_s) {
    moves.push_back({axis, duration_s, from_deg, to_deg, rate_deg_s, kAcceleration_deg_s2});
    duration_s += std::fabs(to_deg - from_deg) / rate_deg_s + rate_deg_s / kAcceleration_deg_s2;
  }
  Vector3 At(double t_s) const {
    Vector3 angles_deg = {};
    for (const ForeseenMove& move : moves) {
      if (move.begin_s > t_s) break;
      angles_deg[static_cast<std::size_t>(move.axis)] = AngleOf(move, t_s - move.begin_s);
    }
    return angles_deg;
  }
};

PictureMotion TypicalMotion() {
  PictureMotion motion;
  double pose_deg = 0.0;
  for (const double next_deg : kPoses_deg) {
    if (next_deg != pose_deg) motion.Turn(StandAxis::kMiddle, pose_deg, next_deg, 18.0);
    pose_deg = next_deg;
    motion.duration_s += kRest_s;
    for (const double rate_deg_s : kRates_deg_s) {
      motion.Turn(StandAxis::kInner, 0.0, kFullTurn_deg, rate_deg_s);
      motion.duration_s += 1.0;
      motion.Turn(StandAxis::kInner, kFullTurn_deg, 0.0, rate_deg_s);
      motion.duration_s += 1.0;
    }
  }
  motion.duration_s += kRest_s;
  return motion;
}

MeasurementInfo TypicalInfo() {
  MeasurementInfo info;
  info.source = "typical";
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_units_per_deg_s = 1.0;
  info.gyro_present = info.accel_present = info.stand_axis_present = {true, true, true};
  info.temperature_present = true;
  info.reference = ReferenceKind::kStandAngles;
  info.gear_ratio = 40.0;
  info.power_on = "1";
  info.covariates = kColumns;
  return info;
}

double Vibration_g(double rate_deg_s) {
  const double off = (std::fabs(rate_deg_s) - kResonance_deg_s) / kWidth_deg_s;
  return std::fabs(rate_deg_s) > 0.1 ? kShakes_g / std::sqrt(1.0 + off * off) : 0.0;
}

// What a perfect sensor shows.
Recording Record(const PictureMotion& motion, double begin_s, bool heats) {
  Collector collector;
  const MeasurementInfo info = TypicalInfo();
  collector.OnInfo(info);
  const kinematics::StandFrame stand(info.geometry);
  const auto samples = static_cast<std::int64_t>(motion.duration_s / kStep_s);
  for (std::int64_t k = 0; k <= samples; ++k) {
    const double t_s = static_cast<double>(k) * kStep_s;
    const Vector3 angles_deg = motion.At(t_s);
    if (k % kSamplesPerPictureReading == 0) {
      for (const int axis : {0, 1, 2})
        collector.OnAngle({begin_s + t_s, axis, angles_deg[static_cast<std::size_t>(axis)]});
    }
    const Vector3 before_deg = motion.At(t_s - 0.5 * kStep_s),
                  after_deg = motion.At(t_s + 0.5 * kStep_s);
    const Matrix3 rates = stand.Rates(angles_deg);
    const Vector3 up = kinematics::TransposedTimes(stand.Orientation(angles_deg), {0.0, 0.0, 1.0});
    // A sensor that gives the same value again and again is taken for frozen.
    const double dither = std::sin(2.4 * static_cast<double>(k));
    const double inner_deg_s = (after_deg[kTable] - before_deg[kTable]) / kStep_s;
    GyroSample sample;
    sample.t_s = begin_s + t_s;
    for (std::size_t c = 0; c < 3; ++c) {
      sample.xi[c] = 1e-4 * dither;
      for (std::size_t a = 0; a < 3; ++a)
        sample.xi[c] += rates[c][a] * (after_deg[a] - before_deg[a]) / kStep_s;
      sample.accel_g[c] = up[c] + (1e-4 + std::sqrt(2.0 / 3.0) * Vibration_g(inner_deg_s)) * dither;
    }
    const double settled = std::exp(-t_s / kWarms_s), range = kHot_degC - kCold_degC;
    sample.temperature_degC = heats ? kHot_degC - range * settled : kCold_degC + range * settled;
    const double phase = std::fmod((begin_s + t_s) / kColumnPeriod_s, 1.0);
    const std::array<double, 1> column = {std::fabs(2.0 * phase - 1.0)};
    collector.OnCovariates(sample.t_s, column);
    collector.OnGyro(sample);
  }
  return collector.Take();
}

// What an effect goes by, as its picture shows it.
enum class Against { kTime, kRate, kTemperature, kTableAngle, kShaftAngle, kColumn, kVibration };
enum class Shown { kRate, kShareOfRate, kAngle };

bool Has(const Effect& effect, unsigned needs) { return (effect.needs & needs) != 0; }

Shown ShownAs(const Effect& effect) {
  if (effect.domain == EffectDomain::kAngle) return Shown::kAngle;
  const bool product =
      Has(effect, kNeedsRate) && Has(effect, kNeedsGravity | kNeedsTemperature | kNeedsCovariate);
  return product ? Shown::kShareOfRate : Shown::kRate;
}

Against ShownAgainst(const Effect& effect) {
  const bool sudden = effect.of_one_time() || effect.of_one_run() || effect.unknown_start;
  if (Has(effect, kNeedsTemperature)) return Against::kTemperature;
  if (Has(effect, kNeedsCovariate)) return Against::kColumn;
  if (Has(effect, kNeedsVibration)) return Against::kVibration;
  if (sudden || Has(effect, kNeedsGravity | kNeedsPowerOn)) return Against::kTime;
  if (Has(effect, kNeedsGear)) return Against::kShaftAngle;
  if (Has(effect, kNeedsTableAxis)) return Against::kTableAngle;
  return Has(effect, kNeedsRate) ? Against::kRate : Against::kTime;
}

}  // namespace

class EffectGallery::Run {
 public:
  Run()
      : motion_(TypicalMotion()),
        recordings_{Record(motion_, 0.0, true), Record(motion_, motion_.duration_s + 10.0, false)},
        histories_{MakeStateHistory(recordings_[0], {1.0, 1.0, 1.0}, true, kColumns),
                   MakeStateHistory(recordings_[1], {1.0, 1.0, 1.0}, false, kColumns)},
        problem_(histories_, kChannel, 1.0) {
    for (std::size_t h = 0; h < histories_.size(); ++h) histories_[h].nodes.front().run = h + 1;
    weights_.resize(problem_.rows());
    for (Eigen::Index i = 0; i < problem_.rows(); ++i) weights_(i) = 1.0 / std::sqrt(Duration(i));
    baseline_ = Weighted(problem_.MakeBaseline().columns);
    fit_.compute(baseline_);
    for (const Candidate& one : CatalogueCandidates(problem_, kColumns, false)) {
      if (one.context.table_axis != kTable) continue;
      const Eigen::MatrixXd left = Residual(ColumnsOf(problem_, one, kColumns));
      if (left.allFinite()) others_.push_back({one.effect->id, left});
    }
  }

  EffectPicture PictureOf(const Effect& effect) const {
    const Shown shown = ShownAs(effect);
    const Eigen::VectorXd residual_deg = Residual(Made(effect)).array() / weights_.array();
    const auto [x_label, x] = Across(effect);
    EffectPicture out;
    out.x_label = x_label;
    out.y_label = shown == Shown::kAngle  ? "angle error [deg]"
                  : shown == Shown::kRate ? "rate error [deg/s]"
                                          : "rate error over rate [%]";
    double angle_deg = 0.0;
    for (Eigen::Index i = 0; i < problem_.rows(); ++i) {
      angle_deg += residual_deg(i);
      const double rate_deg_s = residual_deg(i) / Duration(i), w = Rate(i);
      if (shown == Shown::kShareOfRate && std::fabs(w) < kLeastRate_deg_s) continue;
      out.x.push_back(x(i));
      out.y.push_back(shown == Shown::kAngle  ? angle_deg
                      : shown == Shown::kRate ? rate_deg_s
                                              : 100.0 * rate_deg_s / w);
    }
    return out;
  }

  std::vector<std::string> RivalsOf(const Effect& effect) const {
    constexpr double kNearlyAll = 0.9;
    const Eigen::VectorXd residual = Residual(Made(effect));
    std::map<std::string, double> described;
    for (const auto& [id, columns] : others_) {
      if (id == effect.id) continue;
      const Eigen::VectorXd as_other = columns * columns.colPivHouseholderQr().solve(residual);
      double& most = described[id];
      most = std::max(most, as_other.squaredNorm() / residual.squaredNorm());
    }
    std::vector<std::string> rivals;
    for (const auto& [id, share] : described) {
      if (share > kNearlyAll) rivals.push_back(id);
    }
    return rivals;
  }

 private:
  // A share of less is the noise of small numbers.
  static constexpr double kLeastRate_deg_s = 2.0;

  double Duration(Eigen::Index i) const {
    return problem_.intervals()[static_cast<std::size_t>(i)].duration_s;
  }
  double Rate(Eigen::Index i) const {
    return 0.5 *
           (problem_.half(i, 0).rate_deg_s[kChannel] + problem_.half(i, 1).rate_deg_s[kChannel]);
  }
  // Of an angle random walk.
  Eigen::MatrixXd Weighted(const Eigen::MatrixXd& columns) const {
    return weights_.asDiagonal() * columns;
  }
  // What is left of them, weighted, when the baseline is fitted.
  Eigen::MatrixXd Residual(const Eigen::MatrixXd& columns) const {
    const Eigen::MatrixXd weighted = Weighted(columns);
    return weighted - baseline_ * fit_.solve(weighted);
  }

  // In the middle of what is searched.
  std::vector<double> Nonlinear(const Effect& effect) const {
    if (effect.search == Search::kCoefficient) return {effect.typical_size};
    if (effect.search == Search::kTime) return {kStepAt_s};
    if (effect.search == Search::kFrequency) return {kToneAt_hz};
    if (effect.search == Search::kPeriods) return {kPeriodsInTurn};
    std::vector<double> values;
    for (const NonlinearParameter& parameter : effect.nonlinear)
      values.push_back(parameter.grid[effect.search == Search::kEachPoint
                                          ? std::min<std::size_t>(1, parameter.grid.size() - 1)
                                          : parameter.grid.size() / 3]);
    return values;
  }
  // What the effect adds to each row [deg].
  Eigen::VectorXd Made(const Effect& effect) const {
    Candidate candidate = PlacedCandidate(problem_, effect, kTable, Nonlinear(effect), {});
    candidate.context.covariate_mean = 0.5;
    const double size = effect.typical_size > 0.0 ? effect.typical_size : 1.0;
    return size * ColumnsOf(problem_, candidate, kColumns).rowwise().sum();
  }

  std::pair<std::string, std::function<double(Eigen::Index)>> Across(const Effect& effect) const {
    switch (ShownAgainst(effect)) {
      case Against::kRate:
        return {"rate [deg/s]", [this](Eigen::Index i) { return Rate(i); }};
      case Against::kTemperature:
        return {"temperature [degC]",
                [this](Eigen::Index i) { return problem_.half(i, 0).temperature_degC; }};
      case Against::kTableAngle:
        return {"angle of the table [deg]",
                [this](Eigen::Index i) { return problem_.end_node(i).table_deg[kTable]; }};
      case Against::kShaftAngle:
        return {"angle of the shaft [deg]", [this](Eigen::Index i) {
                  const double shaft_deg =
                      problem_.gear_ratio() * problem_.end_node(i).table_deg[kTable];
                  return shaft_deg - kFullTurn_deg * std::floor(shaft_deg / kFullTurn_deg);
                }};
      case Against::kColumn:
        return {"column x", [this](Eigen::Index i) { return problem_.half(i, 0).covariates[0]; }};
      case Against::kVibration:
        return {"vibration, mean square [g^2]",
                [this](Eigen::Index i) { return problem_.half(i, 0).vibration_g2; }};
      case Against::kTime:
        break;
    }
    return {"time [min]", [this](Eigen::Index i) { return problem_.end_s(i) / 60.0; }};
  }

  PictureMotion motion_;
  std::array<Recording, 2> recordings_;
  std::array<StateHistory, 2> histories_;
  ChannelProblem problem_;
  Eigen::VectorXd weights_;
  Eigen::MatrixXd baseline_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> fit_;
  struct Other {
    std::string id;
    Eigen::MatrixXd columns;  // residual of them
  };
  std::vector<Other> others_;
};

EffectGallery::EffectGallery() : run_(std::make_unique<Run>()) {}
EffectGallery::~EffectGallery() = default;
EffectGallery::EffectGallery(EffectGallery&&) noexcept = default;

EffectPicture EffectGallery::PictureOf(const Effect& effect) const {
  return run_->PictureOf(effect);
}

std::vector<std::string> EffectGallery::RivalsOf(const Effect& effect) const {
  return run_->RivalsOf(effect);
}

}  // namespace gyrobench::calibration
