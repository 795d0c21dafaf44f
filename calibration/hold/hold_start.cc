#include "calibration/hold/hold_start.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

#include "base/geometry.h"
#include "base/robust.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kBatch_s = 0.4;
// Of slower samples a hand's tremble, up to some 12 Hz, reaches into what counts as white.
constexpr double kSlowestForWhite_hz = 80.0;
// Steps of the rough matrix: long against the accelerometer's noise, short against a turn.
constexpr double kRoughStep_s = 0.2;
// In motion the specific force is gravity within this, or it is not used for the rough matrix.
constexpr double kNearlyOne = 0.2;

std::span<const Epoch> EpochsOf(const HeldChain& chain, std::size_t rest, const EpochRange& range) {
  return std::span(chain.recordings[chain.rests[rest].recording]->epochs)
      .subspan(range.first, range.last - range.first);
}

// |a|^2 = 2 c a + (r^2 - c^2): linear in centre and the bracket.
AccelParameters Sphere(const HeldChain& chain) {
  Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double size = 0.0;
  for (const HeldRest& rest : chain.rests)
    size += rest.accel_g.norm() / static_cast<double>(chain.rests.size());
  for (const HeldRest& rest : chain.rests) {
    const Vector3d a = rest.accel_g / size;
    const Eigen::Vector4d row(2.0 * a.x(), 2.0 * a.y(), 2.0 * a.z(), 1.0);
    gram += row * row.transpose();
    right += row * a.squaredNorm();
  }
  // Poses that do not span space leave the centre where it is nominal.
  gram.topLeftCorner<3, 3>() += 1e-3 * Matrix3d::Identity();
  const Eigen::Vector4d fit = gram.ldlt().solve(right);
  AccelParameters out;
  out.offset_g = size * fit.head<3>();
  out.scale.setConstant(size * std::sqrt(std::max(0.01, fit[3] + fit.head<3>().squaredNorm())));
  return out;
}

HoldState StateWith(const HeldChain& chain, const AccelParameters& accel, const Vector3d& offset,
                    double unit, const Matrix3d& m) {
  HoldState state;
  state.unit = unit;
  state.m = m;
  state.accel = accel;
  const Matrix3d inverse = accel.Matrix().inverse();
  for (const HeldRest& rest : chain.rests) {
    NodeState node;
    node.gravity = (inverse * (rest.accel_g - accel.offset_g)).normalized();
    node.beta_begin = node.beta_end = unit * offset;
    state.nodes.push_back(node);
  }
  return state;
}

// Sums of d g = (g x) A dz over the turns.
struct RoughSums {
  Eigen::Matrix<double, 9, 9> gram = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> right = Eigen::Matrix<double, 9, 1>::Zero();
  int steps = 0;

  void Add(const Vector3d& before, const Vector3d& after, const Vector3d& angle) {
    const Vector3d g = (before + after).normalized();
    Eigen::Matrix<double, 3, 9> row;
    for (Index i = 0; i < 3; ++i) {
      const Vector3d column = g.cross(Vector3d::Unit(i));
      for (Index j = 0; j < 3; ++j) row.col(3 * i + j) = column * angle[j];
    }
    gram += row.transpose() * row;
    right += row.transpose() * (after - before);
    ++steps;
  }
};

// A from output to rad; the angles are scaled so that the sums are of size one.
std::optional<Matrix3d> RoughMatrix(const HeldChain& chain, const AccelParameters& accel,
                                    const Vector3d& offset) {
  const Matrix3d inverse = accel.Matrix().inverse();
  RoughSums sums;
  double scale = 0.0;
  for (std::size_t k = 0; k < chain.links.size(); ++k) {
    const HeldLink& link = chain.links[k];
    if (link.kind != LinkKind::kTurn) continue;
    std::optional<Vector3d> before;
    Vector3d angle = Vector3d::Zero();
    double since_s = 0.0;
    for (const Epoch& epoch : EpochsOf(chain, k, link.epochs)) {
      const Vector3d step = epoch.angle - epoch.duration_s() * offset;
      angle += 0.5 * step;
      since_s += epoch.duration_s();
      const Vector3d g = inverse * (epoch.accel_g - accel.offset_g);
      const bool gravity = std::fabs(g.norm() - 1.0) < kNearlyOne;
      if (since_s >= kRoughStep_s || !before) {
        if (before && gravity) {
          if (scale == 0.0) scale = angle.norm();
          sums.Add(*before, g.normalized(), angle / scale);
        }
        before = gravity ? std::optional<Vector3d>(g.normalized()) : std::nullopt;
        angle.setZero();
        since_s = 0.0;
      }
      angle += 0.5 * step;
    }
  }
  if (sums.steps < 12 || !(scale > 0.0)) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> fit = sums.gram.ldlt().solve(sums.right) / scale;
  Matrix3d a;
  for (Index i = 0; i < 3; ++i) a.row(i) = fit.segment<3>(3 * i).transpose();
  if (!a.allFinite() || std::fabs(a.determinant()) < 1e-3 * std::pow(a.norm(), 3))
    return std::nullopt;
  return a;
}

double MedianOfKnown(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return Median(std::move(values));
}

// Sum of squares about a straight line, in all three axes, of evenly spaced values.
struct Scatter {
  double square = 0.0;
  int degrees = 0;  // of freedom, of each axis
};

Scatter AboutLine(const std::vector<Vector3d>& values) {
  const auto n = static_cast<double>(values.size());
  Vector3d mean = Vector3d::Zero(), slope = Vector3d::Zero();
  for (const Vector3d& value : values) mean += value / n;
  double spread = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = static_cast<double>(i) - 0.5 * (n - 1.0);
    slope += x * values[i];
    spread += x * x;
  }
  if (spread > 0.0) slope /= spread;
  Scatter out;
  out.degrees = static_cast<int>(values.size()) - 2;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = static_cast<double>(i) - 0.5 * (n - 1.0);
    out.square += (values[i] - mean - x * slope).squaredNorm();
  }
  return out;
}

// Means of the accelerometer, freed of the tilt that the gyro sees, and of the rate over batches.
struct Batches {
  std::vector<Vector3d> accel_g, rate;
  double length_s = 0.0;  // of all together
};

Batches BatchesOf(std::span<const Epoch> epochs, const HeldRest& rest, const HoldState& state,
                  const NodeState& node) {
  Batches out;
  const Matrix3d to_angle = state.unit * state.m.inverse();
  Vector3d angle = Vector3d::Zero(), accel = Vector3d::Zero(), turned = Vector3d::Zero();
  double length_s = 0.0;
  for (const Epoch& epoch : epochs) {
    const double h = epoch.duration_s();
    angle += 0.5 * epoch.angle;
    const double share = (0.5 * (epoch.begin_s + epoch.end_s) - rest.begin_s) / rest.duration_s();
    const Vector3d path = to_angle * (angle - rest.angle * share);
    angle += 0.5 * epoch.angle;
    accel += h * (epoch.accel_g - state.accel.Matrix() * node.gravity.cross(path));
    turned += epoch.angle;
    length_s += h;
    if (length_s < kBatch_s) continue;
    out.accel_g.push_back(accel / length_s);
    out.rate.push_back(state.unit * turned / length_s);
    out.length_s += length_s;
    accel.setZero();
    turned.setZero();
    length_s = 0.0;
  }
  return out;
}

}  // namespace

std::vector<double> TurnMisses(const HeldChain& chain, const HoldState& state) {
  std::vector<double> misses;
  const GyroParameters gyro = state.Gyro();
  for (std::size_t k = 0; k < chain.links.size(); ++k) {
    misses.push_back(kMissing);
    if (chain.links[k].kind != LinkKind::kTurn) continue;
    const NodeState &from = state.nodes[k], &to = state.nodes[k + 1];
    const TurnRotation turn = IntegrateTurn(EpochsOf(chain, k, chain.links[k].epochs), gyro,
                                            from.beta_end, to.beta_begin);
    const Vector3d predicted = turn.r.transpose() * (RotationOf(-from.delta) * from.gravity);
    misses.back() = (predicted - to.gravity).norm();
  }
  return misses;
}

std::optional<HoldState> StartState(const HeldChain& chain, const Vector3d& offset,
                                    std::optional<double> units_per_deg_s) {
  const AccelParameters accel = Sphere(chain);
  std::vector<HoldState> starts;
  if (units_per_deg_s) {
    const double unit = kRadPerDeg / *units_per_deg_s;
    starts.push_back(StateWith(chain, accel, offset, unit, Matrix3d::Identity()));
  }
  if (const std::optional<Matrix3d> a = RoughMatrix(chain, accel, offset)) {
    const double unit =
        units_per_deg_s ? starts.front().unit : std::cbrt(std::fabs(a->determinant()));
    starts.push_back(StateWith(chain, accel, offset, unit, unit * a->inverse()));
  }
  std::optional<HoldState> best;
  double least = std::numeric_limits<double>::infinity();
  for (HoldState& start : starts) {
    const double miss = MedianOfKnown(TurnMisses(chain, start));
    if (!(miss < least)) continue;
    least = miss;
    best = std::move(start);
  }
  return best;
}

RestNoise NoiseWithinRests(const HeldChain& chain, const HoldState& state) {
  double accel = 0.0;
  int degrees = 0;
  std::vector<double> walks, white;
  for (std::size_t k = 0; k < chain.rests.size(); ++k) {
    const HeldRest& rest = chain.rests[k];
    const Batches batches = BatchesOf(EpochsOf(chain, k, rest.epochs), rest, state, state.nodes[k]);
    const double interval_s = chain.recordings[rest.recording]->median_interval_s;
    if (interval_s * kSlowestForWhite_hz <= 1.0) white.push_back(rest.white_density);
    if (batches.rate.size() < 3) continue;
    const double batch_s = batches.length_s / static_cast<double>(batches.rate.size());
    const Scatter a = AboutLine(batches.accel_g), w = AboutLine(batches.rate);
    accel += a.square * batch_s;
    degrees += 3 * a.degrees;
    walks.push_back(std::sqrt(w.square * batch_s / (3.0 * w.degrees)));
  }
  RestNoise out;
  if (degrees == 0) return out;
  out.accel_density_g_sqrt_s = std::sqrt(accel / degrees);
  out.median_angle_random_walk_deg_sqrt_s = kDegPerRad * MedianOfKnown(walks);
  out.white_angle_random_walk_deg_sqrt_s = kDegPerRad * state.unit * MedianOfKnown(white);
  std::sort(walks.begin(), walks.end());
  out.angle_random_walk_deg_sqrt_s = kDegPerRad * walks[walks.size() / 5];
  return out;
}

}  // namespace gyrobench::calibration
