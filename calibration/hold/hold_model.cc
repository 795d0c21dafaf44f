#include "calibration/hold/hold_model.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "base/geometry.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Matrix32 = Eigen::Matrix<double, 3, 2>;

constexpr Index kNode = ArrowSystem::kNode;
// Within a node.
constexpr Index kEta = 0, kDelta = 2, kBetaBegin = 5, kBetaEnd = 8;
// Earth's rotation, 15.041 deg/h (IERS 2010: 7.292115e-5 rad/s).
constexpr double kEarth_rad_s = 7.292115e-5;

Matrix3d Cross(const Vector3d& v) {
  Matrix3d out;
  out << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return out;
}

// Two directions square to `g`: how gravity can move.
Matrix32 Tangent(const Vector3d& g) {
  Index least = 0;
  g.cwiseAbs().minCoeff(&least);
  Matrix32 out;
  out.col(0) = g.cross(Vector3d::Unit(least)).normalized();
  out.col(1) = g.cross(out.col(0));
  return out;
}

// J and r of one factor.
class Rows {
 public:
  Rows(Index rows, bool pair, Index parameters)
      : j_(MatrixXd::Zero(rows, (pair ? 2 : 1) * kNode + parameters + 1)),
        shared_((pair ? 2 : 1) * kNode) {}
  auto Node(Index at, Index count) { return j_.middleCols(at, count); }
  auto Next(Index at, Index count) { return j_.middleCols(kNode + at, count); }
  auto Parameters(Index at, Index count) {
    feels_parameters_ = true;
    return j_.middleCols(shared_ + at, count);
  }
  auto Residual() { return j_.col(j_.cols() - 1); }
  ArrowSystem::Products Products() const {
    if (feels_parameters_) return j_.transpose() * j_;
    MatrixXd own(j_.rows(), shared_ + 1);
    own << j_.leftCols(shared_), j_.rightCols(1);
    return own.transpose() * own;
  }

 private:
  MatrixXd j_;
  Index shared_;
  bool feels_parameters_ = false;
};

Matrix3d LevelFrame(const Vector3d& gravity) {
  return Eigen::Quaterniond::FromTwoVectors(gravity, Vector3d::UnitZ()).toRotationMatrix();
}

class Linearizer {
 public:
  Linearizer(const HeldChain& chain, const HoldState& state, const ModelExtent& extent)
      : chain_(chain), state_(state), extent_(extent), gyro_(state.Gyro()) {
    out_.extent = extent;
    out_.nodes = static_cast<Index>(chain.rests.size());
  }

  LinearModel Run(double latitude_rad) {
    PriorOfEarth(latitude_rad);
    Matrix3d world = LevelFrame(state_.nodes.front().gravity);
    for (std::size_t k = 0; k < chain_.rests.size(); ++k) {
      world = LevelFrame(world * state_.nodes[k].gravity) * world;
      AddRest(k, world);
      if (k + 1 == chain_.rests.size()) break;
      world = world * RotationOf(state_.nodes[k].delta);
      world = world * AddLink(k, world);
    }
    return std::move(out_);
  }

 private:
  // Unknown by direction, known by size; what is known goes in as the mean.
  void PriorOfEarth(double latitude_rad) {
    const bool known = std::isfinite(latitude_rad);
    const double level = known ? kEarth_rad_s * std::cos(latitude_rad) : kEarth_rad_s;
    const double up = known ? kEarth_rad_s * std::sin(latitude_rad) : 0.0;
    // A thousandth, so that a latitude to a tenth of a degree is good enough.
    const double up_error = known ? 1e-3 * kEarth_rad_s : kEarth_rad_s;
    out_.earth_value = {-state_.earth[0], -state_.earth[1], up - state_.earth[2]};
    const double flat = 1.0 / (level * level / 2.0 + 1e-6 * kEarth_rad_s * kEarth_rad_s);
    out_.earth_weight = {flat, flat, 1.0 / (up_error * up_error)};
  }

  HoldFactor Make(FactorKind kind, std::size_t k, double duration_s, Rows* rows) const {
    HoldFactor factor;
    factor.kind = kind;
    factor.node = static_cast<Index>(k);
    factor.rows = rows->Residual().size();
    factor.duration_s = duration_s;
    factor.products = rows->Products();
    return factor;
  }
  Rows Empty(Index rows, bool pair) const { return {rows, pair, extent_.Parameters()}; }

  void AddRest(std::size_t k, const Matrix3d& world) {
    AddAccel(k);
    AddGyro(k, world);
    const HeldRest& rest = chain_.rests[k];
    const NodeState& node = state_.nodes[k];
    Rows still = Empty(3, false);
    still.Node(kDelta, 3) = Matrix3d::Identity();
    still.Residual() = node.delta;
    HoldFactor factor = Make(FactorKind::kStill, k, rest.duration_s(), &still);
    factor.path = rest.path_rms * state_.unit;
    out_.factors.push_back(std::move(factor));
    Rows walk = Empty(3, false);
    walk.Node(kBetaEnd, 3) = Matrix3d::Identity();
    walk.Node(kBetaBegin, 3) = -Matrix3d::Identity();
    walk.Residual() = node.beta_end - node.beta_begin;
    out_.factors.push_back(Make(FactorKind::kRestWalk, k, rest.duration_s(), &walk));
  }

  // Mean of the accelerometer: predicted less measured.
  void AddAccel(std::size_t k) {
    const HeldRest& rest = chain_.rests[k];
    const NodeState& node = state_.nodes[k];
    const Vector3d mean_turn = 0.5 * node.delta + state_.unit * gyro_.m.inverse() * rest.path_mean;
    const Matrix3d to_mean = RotationOf(-mean_turn);
    const Vector3d g = to_mean * node.gravity;
    const Matrix3d t = state_.accel.Matrix(), s = state_.accel.Directions();
    Rows rows = Empty(3, false);
    rows.Residual() = t * g + state_.accel.offset_g - rest.accel_g;
    rows.Node(kEta, 2) = t * to_mean * Tangent(node.gravity);
    rows.Node(kDelta, 3) = 0.5 * t * Cross(g);
    rows.Parameters(kAtScale, 3) = (s * g).asDiagonal();
    rows.Parameters(kAtOffset, 3) = Matrix3d::Identity();
    for (std::size_t p = 0; p < 3; ++p) {
      const auto [i, j] = kAxisPairs[p];
      const auto at = kAtShear + static_cast<Index>(p);
      const double shear = state_.accel.shear[static_cast<Index>(p)];
      rows.Parameters(at, 1)(i, 0) = state_.accel.scale[i] * (g[j] - shear / s(i, i) * g[i]);
      rows.Parameters(at, 1)(j, 0) = state_.accel.scale[j] * (g[i] - shear / s(j, j) * g[j]);
    }
    if (extent_.bent_accel) {
      rows.Parameters(extent_.AtBentAccel(), 3) = g.cwiseAbs2().asDiagonal();
      rows.Parameters(extent_.AtBentAccel() + 3, 3) = g.cwiseAbs2().cwiseProduct(g).asDiagonal();
    }
    out_.factors.push_back(Make(FactorKind::kAccel, k, rest.duration_s(), &rows));
  }

  void AddGyro(std::size_t k, const Matrix3d& world) {
    const HeldRest& rest = chain_.rests[k];
    const NodeState& node = state_.nodes[k];
    const double t_s = rest.duration_s();
    const Vector3d earth = world.transpose() * state_.earth;
    Rows rows = Empty(3, false);
    rows.Residual() = gyro_.m * (node.delta + earth * t_s) +
                      0.5 * t_s * (node.beta_begin + node.beta_end) +
                      t_s * gyro_.g_sensitivity * node.gravity - state_.unit * rest.angle;
    rows.Node(kDelta, 3) = gyro_.m;
    rows.Node(kBetaBegin, 3) = 0.5 * t_s * Matrix3d::Identity();
    rows.Node(kBetaEnd, 3) = 0.5 * t_s * Matrix3d::Identity();
    rows.Parameters(kAtEarth, 3) = t_s * gyro_.m * world.transpose();
    if (extent_.g_sensitivity) {
      for (Index i = 0; i < 3; ++i)
        rows.Parameters(extent_.AtGSensitivity() + 3 * i, 3).row(i) =
            t_s * node.gravity.transpose();
    }
    out_.factors.push_back(Make(FactorKind::kGyro, k, t_s, &rows));
  }

  // Gives the rotation over the link.
  Matrix3d AddLink(std::size_t k, const Matrix3d& world) {
    const HeldLink& link = chain_.links[k];
    if (link.kind != LinkKind::kApart) {
      Rows walk = Empty(3, true);
      walk.Next(kBetaBegin, 3) = Matrix3d::Identity();
      walk.Node(kBetaEnd, 3) = -Matrix3d::Identity();
      walk.Residual() = state_.nodes[k + 1].beta_begin - state_.nodes[k].beta_end;
      out_.factors.push_back(Make(FactorKind::kLinkWalk, k, link.duration_s(), &walk));
    }
    if (link.kind != LinkKind::kTurn) return Matrix3d::Identity();
    return AddTurn(k, world);
  }

  Matrix3d AddTurn(std::size_t k, const Matrix3d& world) {
    const HeldLink& link = chain_.links[k];
    const NodeState &from = state_.nodes[k], &to = state_.nodes[k + 1];
    const HoldRecording& recording = *chain_.recordings[chain_.rests[k].recording];
    const TurnRotation turn =
        IntegrateTurn(std::span(recording.epochs)
                          .subspan(link.epochs.first, link.epochs.last - link.epochs.first),
                      gyro_, from.beta_end, to.beta_begin);
    const Matrix3d in_rest = RotationOf(-from.delta);
    const Vector3d g = in_rest * from.gravity;
    const Matrix32 across = Tangent(to.gravity);
    // Earth turns the sensor by -R_SW e t more than the gyro says.
    const Matrix3d by_earth = -link.duration_s() * world.transpose();
    const Vector3d predicted = turn.r.transpose() * (g + g.cross(by_earth * state_.earth));
    const Eigen::Matrix<double, 2, 3> to_end = across.transpose() * turn.r.transpose();
    const Eigen::Matrix<double, 2, 3> by_phi = to_end * Cross(g);
    Rows rows = Empty(2, true);
    rows.Residual() = across.transpose() * (predicted - to.gravity);
    rows.Node(kEta, 2) = to_end * in_rest * Tangent(from.gravity);
    rows.Node(kDelta, 3) = by_phi;
    rows.Node(kBetaEnd, 3) = by_phi * turn.by_beta_begin;
    rows.Next(kEta, 2) = -Eigen::Matrix2d::Identity();
    rows.Next(kBetaBegin, 3) = by_phi * turn.by_beta_end;
    rows.Parameters(kAtM, 9) = by_phi * turn.by_m;
    rows.Parameters(kAtEarth, 3) = by_phi * by_earth;
    if (extent_.g_sensitivity)
      rows.Parameters(extent_.AtGSensitivity(), 9) = by_phi * turn.by_g_sensitivity;
    if (extent_.bent_gyro) rows.Parameters(extent_.AtBentGyro(), 9) = by_phi * turn.by_bent_scale;
    out_.factors.push_back(Make(FactorKind::kTurn, k, link.duration_s(), &rows));
    return turn.r;
  }

  const HeldChain& chain_;
  const HoldState& state_;
  ModelExtent extent_;
  GyroParameters gyro_;
  LinearModel out_;
};

}  // namespace

Matrix3d AccelParameters::Directions() const {
  Matrix3d s = Matrix3d::Zero();
  for (std::size_t p = 0; p < 3; ++p) {
    const auto [i, j] = kAxisPairs[p];
    s(i, j) = s(j, i) = shear[static_cast<Index>(p)];
  }
  for (Index i = 0; i < 3; ++i) s(i, i) = std::sqrt(1.0 - s.row(i).squaredNorm());
  return s;
}

GyroParameters HoldState::Gyro() const {
  return {unit, m, g_sensitivity, accel.Matrix().inverse(), accel.offset_g};
}

LinearModel Linearize(const HeldChain& chain, const HoldState& state, const ModelExtent& extent,
                      double latitude_rad) {
  return Linearizer(chain, state, extent).Run(latitude_rad);
}

double VarianceOf(const HoldFactor& factor, const HoldNoise& noise) {
  const double t_s = factor.duration_s;
  const double n2 = std::pow(kRadPerDeg * noise.angle_random_walk_deg_sqrt_s, 2);
  const double k2 = std::pow(kRadPerDeg * noise.bias_random_walk_deg_s_sqrt_s, 2);
  switch (factor.kind) {
    case FactorKind::kAccel:
      return noise.accel_density_g_sqrt_s * noise.accel_density_g_sqrt_s / t_s +
             noise.pose_scatter_g * noise.pose_scatter_g;
    case FactorKind::kGyro:
    case FactorKind::kTurn:
      // The walk of the offset about the straight line between its two ends.
      return n2 * t_s + k2 * t_s * t_s * t_s / 12.0;
    case FactorKind::kStill: {
      // Of a sensor that lies still the path is the gyro's own noise: a bridge of three axes has a
      // mean square of N^2 T / 2, and 2.5 times that one time in a hundred.
      const double path2 = factor.path * factor.path;
      const double trembles2 = std::max(path2 - 1.25 * n2 * t_s, 1e-4 * path2 + 1e-16);
      return noise.stillness * noise.stillness * trembles2;
    }
    case FactorKind::kRestWalk:
    case FactorKind::kLinkWalk:
      return k2 * std::max(t_s, 1e-3);
  }
  return 1.0;
}

namespace {

ArrowSystem Assemble(const LinearModel& model, const HoldNoise& noise, Index functionals) {
  ArrowSystem system(model.nodes, model.extent.Parameters(), functionals);
  for (const HoldFactor& factor : model.factors) {
    if (!factor.used) continue;
    const double weight = 1.0 / VarianceOf(factor, noise);
    if (factor.kind == FactorKind::kTurn || factor.kind == FactorKind::kLinkWalk) {
      system.AddPair(factor.node, factor.products, weight);
    } else {
      system.AddNode(factor.node, factor.products, weight);
    }
  }
  for (Index i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    system.AddParameter(kAtEarth + i, model.earth_value[at], model.earth_weight[at]);
  }
  return system;
}

}  // namespace

ArrowSystem::Solution SolveModel(const LinearModel& model, const HoldNoise& noise) {
  return Assemble(model, noise, 0).Solve();
}

ArrowSystem::Solution SolveWithMeanOffset(const LinearModel& model, const HoldNoise& noise) {
  ArrowSystem system = Assemble(model, noise, 3);
  const double share = 0.5 / static_cast<double>(model.nodes);
  for (Index k = 0; k < model.nodes; ++k) {
    for (Index c = 0; c < 3; ++c) {
      system.AddSummand(c, k, kBetaBegin + c, share);
      system.AddSummand(c, k, kBetaEnd + c, share);
    }
  }
  return system.Solve();
}

Vector3d MeanOffsetOf(const ArrowSystem::Solution& step) {
  Vector3d sum = Vector3d::Zero();
  for (const auto& node : step.nodes)
    sum += node.segment<3>(kBetaBegin) + node.segment<3>(kBetaEnd);
  return 0.5 / static_cast<double>(step.nodes.size()) * sum;
}

void Move(const ArrowSystem::Solution& step, const ModelExtent& extent, HoldState* state) {
  const Eigen::VectorXd& p = step.parameters;
  for (Index i = 0; i < 3; ++i) {
    state->m.row(i) += p.segment<3>(kAtM + 3 * i).transpose();
    if (extent.g_sensitivity)
      state->g_sensitivity.row(i) += p.segment<3>(extent.AtGSensitivity() + 3 * i).transpose();
  }
  state->accel.scale += p.segment<3>(kAtScale);
  state->accel.shear += p.segment<3>(kAtShear);
  state->accel.offset_g += p.segment<3>(kAtOffset);
  state->earth += p.segment<3>(kAtEarth);
  for (std::size_t k = 0; k < state->nodes.size(); ++k) {
    NodeState& node = state->nodes[k];
    const auto& d = step.nodes[k];
    node.gravity = (node.gravity + Tangent(node.gravity) * d.segment<2>(kEta)).normalized();
    node.delta += d.segment<3>(kDelta);
    node.beta_begin += d.segment<3>(kBetaBegin);
    node.beta_end += d.segment<3>(kBetaEnd);
  }
}

}  // namespace gyrobench::calibration
