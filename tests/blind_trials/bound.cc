#include "tests/blind_trials/bound.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace gyrobench::blind_trials {
namespace {

constexpr double kStep_s = 0.1;
constexpr double kNominal = 131.0;
// The filter starts without knowledge; after so many steps it is steady.
constexpr Eigen::Index kSettle = 100;

// Angle error z - phi at each reading of the reference, and what the baseline is made of.
class AngleErrors : public MeasurementSink {
 public:
  void OnInfo(const MeasurementInfo&) override {}
  void OnGyro(const GyroSample& sample) override {
    const double w = sample.xi[2] / kNominal;
    if (started_) {
      z_ += 0.5 * (w + last_w_) * (sample.t_s - last_t_s_);
      Temperature(sample.temperature_degC - 30.0, sample.t_s - last_t_s_);
    }
    started_ = true;
    last_w_ = w;
    last_t_s_ = sample.t_s;
  }
  void OnAngle(const AngleSample& sample) override {
    angle_[static_cast<std::size_t>(sample.axis)] = sample.angle_deg;
    if (sample.axis != 2) return;
    rows_.push_back({z_ + (started_ ? last_w_ * (sample.t_s - last_t_s_) : 0.0), angle_[0],
                     angle_[1], angle_[2], t_[0], t_[1], t_[2], t_[3]});
  }
  void OnOrientation(const OrientationSample&) override {}
  void OnTickPair(const TickPair&) override {}
  void OnSegment(const SegmentMark&) override {}
  void OnDefect(const Defect&) override {}

  // z; outer, middle and inner angle; integrals of (T - 30 degC)^0 .. 3.
  using Row = std::array<double, 8>;
  const std::vector<Row>& rows() const { return rows_; }

 private:
  void Temperature(double off_degC, double dt_s) {
    double power = 1.0;
    for (double& integral : t_) {
      integral += power * dt_s;
      power *= off_degC;
    }
  }
  std::array<double, 3> angle_ = {};
  std::array<double, 4> t_ = {};
  std::vector<Row> rows_;
  bool started_ = false;
  double z_ = 0.0, last_w_ = 0.0, last_t_s_ = 0.0;
};

// Innovations of the steady Kalman filter of
//   a_k+1 = a_k + dt b_k + n,  b_k+1 = b_k + m,  y_k = a_k + e,   over their standard deviation.
class Whitener {
 public:
  Whitener(double n, double k, double s) {
    const double dt = kStep_s;
    Eigen::Matrix2d f, q;
    f << 1, dt, 0, 1;
    q << n * n * dt + k * k * dt * dt * dt / 3, k * k * dt * dt / 2, k * k * dt * dt / 2,
        k * k * dt;
    Eigen::Matrix2d p = Eigen::Vector2d(1e-4, 1e-6).asDiagonal();
    for (int i = 0; i < 20000; ++i) {
      variance_ = p(0, 0) + s * s;
      const Eigen::Vector2d gain = p.col(0) / variance_;
      gain_ = f * gain;
      p = f * (p - gain * p.row(0)) * f.transpose() + q;
    }
  }
  void Apply(Eigen::Ref<Eigen::VectorXd> column) const {
    Eigen::Vector2d state(column[0], 0.0);
    const double scale = 1.0 / std::sqrt(variance_);
    for (double& y : column) {
      const double innovation = y - state[0];
      state = Eigen::Vector2d(state[0] + kStep_s * state[1], state[1]) + gain_ * innovation;
      y = innovation * scale;
    }
  }

 private:
  Eigen::Vector2d gain_ = Eigen::Vector2d::Zero();
  double variance_ = 1.0;
};

std::vector<AngleErrors::Row> Simulate(const TrialSpec& spec, TrialTruth& truth) {
  AngleErrors sink;
  truth = RecordTrial(spec, sink);
  return sink.rows();
}

// The rotation about the sensor's x and y is theirs by the poses: as much of the outer and middle
// angles as cosine and sine of the inner one give. Sums over steps.
std::array<double, 3> Rotation(const AngleErrors::Row& before, const AngleErrors::Row& now) {
  constexpr double kRad = M_PI / 180.0;
  const double m = 0.5 * (before[2] + now[2]) * kRad, i = 0.5 * (before[3] + now[3]) * kRad;
  const double outer = now[1] - before[1], middle = now[2] - before[2], inner = now[3] - before[3];
  return {std::cos(i) * middle + std::sin(m) * std::sin(i) * outer,
          -std::sin(i) * middle + std::sin(m) * std::cos(i) * outer, inner + std::cos(m) * outer};
}

// Rotation x, y, z; offset; integrals of the temperature's powers.
Eigen::MatrixXd Baseline(const std::vector<AngleErrors::Row>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, 8);
  columns.col(3).setOnes();
  for (Eigen::Index k = 1; k < n; ++k) {
    const auto& now = rows[static_cast<std::size_t>(k)];
    const auto step = Rotation(rows[static_cast<std::size_t>(k) - 1], now);
    for (Eigen::Index j = 0; j < 3; ++j) {
      columns(k, j) = columns(k - 1, j) + step[static_cast<std::size_t>(j)];
    }
    for (Eigen::Index j = 0; j < 4; ++j) columns(k, 4 + j) = now[static_cast<std::size_t>(4 + j)];
  }
  return columns;
}

int Terms(const TrialTruth& truth) {
  int terms = 0;
  for (const TrueParameter& parameter : truth.effects.front().parameters) {
    terms += static_cast<int>(parameter.names.size());
  }
  return std::max(terms, 1);
}

// What is hidden as the sequence shows it, white, the baseline projected out.
class HiddenAtBound {
 public:
  explicit HiddenAtBound(const TrialSpec& spec) {
    TrialSpec with = spec, without = spec;
    with.ideal = without.ideal = true;
    without.effects.clear();
    TrialTruth silent_truth;
    const auto rows = Simulate(with, truth_);
    silent_ = Simulate(without, silent_truth);
    silent_.resize(std::min(rows.size(), silent_.size()));
    Eigen::VectorXd effect(size());
    for (Eigen::Index k = 0; k < size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      effect[k] = (rows[i][0] - rows[i][3]) - (silent_[i][0] - silent_[i][3]);
    }
    whitener_.emplace(truth_.angle_random_walk_deg_sqrt_s, truth_.bias_random_walk_deg_s_sqrt_s,
                      truth_.reference_deg);
    Eigen::MatrixXd baseline = Baseline(silent_);
    for (Eigen::Index j = 0; j < baseline.cols(); ++j) whitener_->Apply(baseline.col(j));
    Eigen::MatrixXd a = baseline.bottomRows(size() - kSettle);
    for (Eigen::Index j = 0; j < a.cols(); ++j) a.col(j) /= std::max(a.col(j).norm(), 1e-300);
    baseline_.compute(a);
    baseline_columns_ = std::move(a);
    left_ = Left(effect);
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(silent_.size()); }
  const TrialTruth& truth() const { return truth_; }
  const std::vector<AngleErrors::Row>& rows() const { return silent_; }
  const Eigen::VectorXd& left() const { return left_; }

  // Of a column of angles, one a reading.
  Eigen::VectorXd Left(Eigen::VectorXd column) const {
    whitener_->Apply(column);
    const Eigen::VectorXd y = column.tail(size() - kSettle);
    return y - baseline_columns_ * baseline_.solve(y);
  }

  // By how much the columns together, each left of the baseline, fall short of the effect.
  double Short(const Eigen::MatrixXd& columns) const {
    return (left_ - columns * columns.colPivHouseholderQr().solve(left_)).squaredNorm();
  }

  // The same of a step of the rate, where it is the least.
  double ShortOfBestStep() const {
    constexpr Eigen::Index kCoarse = 50;  // 5 s
    double least = std::numeric_limits<double>::infinity();
    Eigen::Index best = kSettle;
    const auto try_all = [&](Eigen::Index from, Eigen::Index to, Eigen::Index every) {
      for (Eigen::Index at = std::max(from, kSettle); at < std::min(to, size() - 1); at += every) {
        const double at_this = Short(Left(Step(at)));
        if (at_this < least) best = at;
        least = std::min(least, at_this);
      }
    };
    try_all(0, size(), kCoarse);
    try_all(best - kCoarse, best + kCoarse, 1);
    return least;
  }

 private:
  // Angles that one deg/s from there on brings.
  Eigen::VectorXd Step(Eigen::Index at) const {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
    const Eigen::Index after = size() - at;
    out.tail(after).setLinSpaced(0.0, kStep_s * static_cast<double>(after - 1));
    return out;
  }

  TrialTruth truth_;
  std::vector<AngleErrors::Row> silent_;
  std::optional<Whitener> whitener_;
  Eigen::MatrixXd baseline_columns_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> baseline_;
  Eigen::VectorXd left_;
};

// Angles that one deg/s/g along x, y and z brings: up in the sensor's frame, by the inner and the
// middle angle.
Eigen::MatrixXd GravityAngles(const std::vector<AngleErrors::Row>& rows) {
  constexpr double kRad = M_PI / 180.0;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const double m = 0.5 * (rows[k - 1][2] + rows[k][2]) * kRad;
    const double i = 0.5 * (rows[k - 1][3] + rows[k][3]) * kRad;
    const Eigen::RowVector3d g(std::sin(m) * std::sin(i), std::sin(m) * std::cos(i), std::cos(m));
    const auto row = static_cast<Eigen::Index>(k);
    out.row(row) = out.row(row - 1) + kStep_s * g;
  }
  return out;
}

}  // namespace

std::set<std::string> CopiesAtBound(const TrialSpec& spec) {
  constexpr double kAlone = 10.0;
  const HiddenEffect& effect = spec.effects.front();
  const auto& levels = FindInjection(effect.id).levels;
  // What quantisation leaves in the difference counts as little as it can.
  TrialSpec high = spec;
  high.effects.front().level = kHigh;
  const HiddenAtBound hidden(high);
  const double least = kAlone * std::pow(levels[kHigh] / levels[effect.level], 2);
  std::set<std::string> out;
  const Eigen::MatrixXd angles = GravityAngles(hidden.rows());
  Eigen::MatrixXd gravity(hidden.left().size(), angles.cols());
  for (Eigen::Index j = 0; j < angles.cols(); ++j) gravity.col(j) = hidden.Left(angles.col(j));
  if (hidden.Short(gravity) < least) out.insert("bias.g_linear");
  if (hidden.ShortOfBestStep() < least) out.insert("bias.step");
  return out;
}

Visibility VisibilityAtBound(const TrialSpec& spec) {
  const HiddenAtBound hidden(spec);
  return {hidden.left().norm(), Terms(hidden.truth())};
}

}  // namespace gyrobench::blind_trials
