#include "tests/blind_trials/vector_bound.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

namespace gyrobench::blind_trials {
namespace {

using Eigen::Vector3d;

// A step of a channel's rotation that is more than the encoders' rounding.
constexpr double kTurns_deg = 2e-3;

// The state at a reading of the reference, and integrals up to it.
struct Reading {
  double t_s = 0.0;
  Vector3d angle_deg = Vector3d::Zero();
  std::array<double, kBiasTerms> temperature = {};  // int (T - T0)^k dt
};

class Readings : public MeasurementSink {
 public:
  explicit Readings(double reference_degC) : reference_degC_(reference_degC) {}
  void OnInfo(const MeasurementInfo&) override {}
  void OnGyro(const GyroSample& sample) override {
    if (started_) {
      double power = 1.0;
      for (double& integral : now_.temperature) {
        integral += power * (sample.t_s - last_s_);
        power *= sample.temperature_degC - reference_degC_;
      }
    }
    started_ = true;
    last_s_ = sample.t_s;
  }
  void OnAngle(const AngleSample& sample) override {
    now_.angle_deg[sample.axis] = sample.angle_deg;
    if (sample.axis != 2) return;
    now_.t_s = sample.t_s;
    readings.push_back(now_);
  }
  void OnOrientation(const OrientationSample&) override {}
  void OnTickPair(const TickPair&) override {}
  void OnSegment(const SegmentMark&) override {}
  void OnDefect(const Defect&) override {}

  std::vector<Reading> readings;

 private:
  double reference_degC_, last_s_ = 0.0;
  bool started_ = false;
  Reading now_;
};

// About axes that sit upright on the table, from one reading to the next, by R = Rz(outer)
// Rx(middle) Rz(inner).
Vector3d Rotation(const Reading& before, const Reading& now) {
  constexpr double kRad = std::numbers::pi / 180.0;
  const Vector3d mean = 0.5 * kRad * (before.angle_deg + now.angle_deg);
  const Vector3d step = now.angle_deg - before.angle_deg;
  const double m = mean[1], i = mean[2];
  return {std::cos(i) * step[1] + std::sin(m) * std::sin(i) * step[0],
          -std::sin(i) * step[1] + std::sin(m) * std::cos(i) * step[0],
          step[2] + std::cos(m) * step[0]};
}

Vector3d Gravity(const Reading& before, const Reading& now) {
  constexpr double kRad = std::numbers::pi / 180.0;
  const Vector3d mean = 0.5 * kRad * (before.angle_deg + now.angle_deg);
  return {std::sin(mean[1]) * std::sin(mean[2]), std::sin(mean[1]) * std::cos(mean[2]),
          std::cos(mean[1])};
}

// Angle of the gyro less that of the reference, as each parameter makes it: rows of readings.
Eigen::MatrixXd Columns(const std::vector<Reading>& readings, const Eigen::Matrix3d& mount) {
  const auto n = static_cast<Eigen::Index>(readings.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, kRowParameters);
  for (Eigen::Index k = 1; k < n; ++k) {
    const Reading &before = readings[static_cast<std::size_t>(k - 1)],
                  &now = readings[static_cast<std::size_t>(k)];
    columns.row(k) = columns.row(k - 1);
    columns.row(k).head<3>() += Rotation(before, now).transpose() * mount;
    columns.row(k).tail<3>() += (now.t_s - before.t_s) * Gravity(before, now).transpose() * mount;
    for (Eigen::Index j = 0; j < kBiasTerms; ++j)
      columns(k, 3 + j) = now.temperature[static_cast<std::size_t>(j)];
  }
  return columns;
}

// Number of each reading's stretch: readings between which the channel feels no turning.
std::vector<std::size_t> Stretches(const Eigen::MatrixXd& columns, Eigen::Index channel) {
  std::vector<std::size_t> out(static_cast<std::size_t>(columns.rows()), 0);
  for (std::size_t k = 1; k < out.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const bool turned = std::fabs(columns(row, channel) - columns(row - 1, channel)) > kTurns_deg;
    out[k] = out[k - 1] + (turned ? 1 : 0);
  }
  return out;
}

// The filter's state: angle, bias, the reference's error of this stretch.
struct Filter {
  Eigen::Vector3d gain;
  double inverse_sigma = 1.0, dt_s = 0.0;
  bool new_stretch = false;
};

std::vector<Filter> Filters(const std::vector<Reading>& readings,
                            const std::vector<std::size_t>& stretch, const TrialTruth& noise) {
  const double n2 = std::pow(noise.angle_random_walk_deg_sqrt_s, 2);
  const double k2 = std::pow(noise.bias_random_walk_deg_s_sqrt_s, 2);
  std::vector<double> count(stretch.back() + 1, 0.0);
  for (const std::size_t s : stretch) count[s] += 1.0;
  Eigen::Matrix3d p = Eigen::Matrix3d::Zero();
  p(0, 0) = 1e2;  // where the table stood at first is not known
  std::vector<Filter> out(readings.size());
  for (std::size_t k = 0; k < readings.size(); ++k) {
    Filter& step = out[k];
    step.new_stretch = k == 0 || stretch[k] != stretch[k - 1];
    if (k > 0) {
      const double dt = step.dt_s = readings[k].t_s - readings[k - 1].t_s;
      Eigen::Matrix3d f = Eigen::Matrix3d::Identity(), q = Eigen::Matrix3d::Zero();
      f(0, 1) = dt;
      q.topLeftCorner<2, 2>() << n2 * dt + k2 * dt * dt * dt / 3, k2 * dt * dt / 2,
          k2 * dt * dt / 2, k2 * dt;
      p = f * p * f.transpose() + q;
    }
    if (step.new_stretch) {
      p.row(2).setZero();
      p.col(2).setZero();
      p(2, 2) = noise.reference_deg * noise.reference_deg / count[stretch[k]];
    }
    const Eigen::Vector3d across = p.col(0) + p.col(2);
    const double variance = across[0] + across[2];
    step.gain = across / variance;
    step.inverse_sigma = 1.0 / std::sqrt(variance);
    p -= step.gain * across.transpose();
  }
  return out;
}

void Whiten(const std::vector<Filter>& filters, Eigen::Ref<Eigen::VectorXd> column) {
  Eigen::Vector3d state = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < filters.size(); ++k) {
    double& y = column[static_cast<Eigen::Index>(k)];
    state[0] += filters[k].dt_s * state[1];
    if (filters[k].new_stretch) state[2] = 0.0;
    const double innovation = y - state[0] - state[2];
    state += filters[k].gain * innovation;
    y = innovation * filters[k].inverse_sigma;
  }
}

}  // namespace

Eigen::Matrix3d MountOf(const TrialSpec& spec) {
  const Vector3d angle =
      Eigen::Map<const Vector3d>(spec.mount_deg.data()) * std::numbers::pi / 180.0;
  return (Eigen::AngleAxisd(angle[2], Vector3d::UnitZ()) *
          Eigen::AngleAxisd(angle[1], Vector3d::UnitY()) *
          Eigen::AngleAxisd(angle[0], Vector3d::UnitX()))
      .toRotationMatrix();
}

std::array<RowCovariance, 3> VectorBound(const TrialSpec& spec, double reference_degC) {
  TrialSpec ideal = spec;
  ideal.ideal = true;
  ideal.all_channels = false;
  Readings sink(reference_degC);
  const TrialTruth noise = RecordTrial(ideal, sink);
  const Eigen::MatrixXd columns =
      Columns(sink.readings,
              spec.mount_known ? MountOf(spec) : Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  std::array<RowCovariance, 3> out;
  for (Eigen::Index c = 0; c < 3; ++c) {
    const std::vector<Filter> filters = Filters(sink.readings, Stretches(columns, c), noise);
    Eigen::MatrixXd white = columns;
    for (Eigen::Index j = 0; j < white.cols(); ++j) Whiten(filters, white.col(j));
    const Eigen::VectorXd scale = white.colwise().norm().cwiseInverse();
    white *= scale.asDiagonal();
    const Eigen::MatrixXd inverse =
        (white.transpose() * white).ldlt().solve(RowCovariance::Identity());
    out[static_cast<std::size_t>(c)] = scale.asDiagonal() * inverse * scale.asDiagonal();
  }
  return out;
}

}  // namespace gyrobench::blind_trials
