#include <algorithm>

#include "calibration/sensor/accelerometer.h"
#include "calibration/state/state_history.h"

namespace gyrobench::calibration {
namespace {

// Nodes of a rest; those at its edges may have felt the motion.
constexpr std::size_t kLeastNodes = 5;

// An accelerometer that gives the same number again and again is not exact.
constexpr double kLeastVariance_g2 = 1e-10;

using Eigen::Vector3d;

Vector3d ToEigen(const Vector3& v) { return {v[0], v[1], v[2]}; }

class PoseFinder {
 public:
  void Add(const StateHistory& history) {
    const ReferenceKind kind = history.recording->info.reference;
    by_reference_ = kind == ReferenceKind::kStandAngles || kind == ReferenceKind::kOrientation;
    for (std::size_t i = 0; i < history.still.size(); ++i) {
      if (history.still[i]) {
        nodes_.push_back(i + 1);
      } else {
        EndRest(history);
      }
    }
    EndRest(history);
  }

  std::vector<Pose> Take() {
    // Noise of one node's mean, of all rests together.
    const double variance =
        freedom_ > 0.0 ? std::max(squares_ / freedom_, kLeastVariance_g2) : kMissing;
    for (std::size_t k = 0; k < poses_.size(); ++k) poses_[k].variance_g2 = variance / counts_[k];
    return std::move(poses_);
  }

 private:
  void EndRest(const StateHistory& history) {
    if (nodes_.size() >= kLeastNodes + 2) {
      nodes_.erase(nodes_.begin());
      nodes_.pop_back();
      AddRest(history);
    }
    nodes_.clear();
  }

  void AddRest(const StateHistory& history) {
    std::vector<Vector3d> felt;
    Vector3d gravity = Vector3d::Zero();
    for (const std::size_t node : nodes_) {
      const Vector3d accel = ToEigen(history.recording->columns.nodes[node].accel_g);
      if (!accel.allFinite()) continue;
      felt.push_back(accel);
      gravity += ToEigen(history.nodes[node].gravity_g);
    }
    if (felt.size() < kLeastNodes) return;
    Pose pose;
    const auto count = static_cast<double>(felt.size());
    pose.accel_g.setZero();
    for (const Vector3d& accel : felt) pose.accel_g += accel / count;
    for (const Vector3d& accel : felt) squares_ += (accel - pose.accel_g).squaredNorm();
    freedom_ += 3.0 * (count - 1.0);
    if (by_reference_) pose.gravity_g = gravity.normalized();
    poses_.push_back(pose);
    counts_.push_back(count);
  }

  bool by_reference_ = false;
  std::vector<std::size_t> nodes_;
  std::vector<Pose> poses_;
  std::vector<double> counts_;
  double squares_ = 0.0, freedom_ = 0.0;
};

}  // namespace

std::vector<Pose> FindPoses(std::span<const StateHistory> histories) {
  PoseFinder finder;
  for (const StateHistory& history : histories) finder.Add(history);
  return finder.Take();
}

}  // namespace gyrobench::calibration
