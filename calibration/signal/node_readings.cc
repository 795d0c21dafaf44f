#include "calibration/signal/node_readings.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

// The shape of the motion about the readings needs no more than so many of them; of fewer each
// counts, as where a table stops the mean of some is beyond where it stops.
constexpr std::size_t kShapes = 12;

void AddTo(Vector3* sum, const Vector3& value) {
  for (std::size_t c = 0; c < 3; ++c) (*sum)[c] += value[c];
}

Vector3 Over(const Vector3& sum, const Vector3& last, double count) {
  Vector3 out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = (sum[c] + last[c]) / count;
  return out;
}

}  // namespace

void NodeReadings::Add(const Reading& reading) {
  if (readings_ > 0.0) {
    AddTo(&sum_.rotation_deg, newest_.rotation_deg);
    AddTo(&sum_.earth_deg, newest_.earth_deg);
    AddTo(&sum_.table_deg, newest_.table_deg);
    AddTo(&sum_.world_x, newest_.world_x);
    AddTo(&sum_.world_z, newest_.world_z);
    AddTo(&groups_[size_ - 1].rotation_deg, newest_.rotation_deg);
  }
  newest_ = reading;
  readings_ += 1.0;
  Count();
}

void NodeReadings::Count() {
  const double t_s = newest_.t_s;
  Group* last = size_ > 0 ? &groups_[size_ - 1] : nullptr;
  if (last != nullptr && (t_s - last->t_s < kTogether_s || size_ == kMost)) {
    last->t_s += (t_s - last->t_s) / (last->weight + 1.0);
    last->weight += 1.0;
    return;
  }
  groups_[size_++] = {t_s, 1.0, {}};
}

ReadingsMean NodeReadings::Mean() const {
  ReadingsMean mean;
  mean.readings = readings_;
  mean.own_readings = own_readings_;
  for (std::size_t a = 0; a < 3; ++a) mean.own_deg[a] = own_sum_deg_[a] / own_readings_[a];
  if (size_ == 0) return mean;
  mean.rotation_deg = Over(sum_.rotation_deg, newest_.rotation_deg, readings_);
  mean.earth_deg = Over(sum_.earth_deg, newest_.earth_deg, readings_);
  mean.table_deg = Over(sum_.table_deg, newest_.table_deg, readings_);
  mean.world_x = Over(sum_.world_x, newest_.world_x, readings_);
  mean.world_z = Over(sum_.world_z, newest_.world_z, readings_);
  double t_s = 0.0, walk_s = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    t_s += groups_[i].weight * (groups_[i].t_s - groups_[0].t_s);
    for (std::size_t j = 0; j < i; ++j)
      walk_s += groups_[i].weight * groups_[j].weight * (groups_[i].t_s - groups_[j].t_s);
  }
  mean.t_s = groups_[0].t_s + t_s / readings_;
  mean.walk_s = walk_s / (readings_ * readings_);
  // Of even ones whose mean distance is the same.
  const auto steps = static_cast<double>(size_);
  mean.step_s = size_ > 1 ? 6.0 * steps * mean.walk_s / (steps * steps - 1.0) : 0.0;
  mean.steps = size_;
  return mean;
}

bool NodeReadings::AverageOutput(const GyroStream& gyro, ReadingsMean* mean,
                                 std::vector<ReadingWithin>* within) const {
  if (empty()) return false;
  std::array<IntegralMark, kMost> at;
  Vector3 sum = {};
  AsMeans as_means = {}, as_means_later = {};
  for (std::size_t i = 0; i < size_; ++i) {
    if (!gyro.IntegralAt(groups_[i].t_s, &at[i])) return false;
    const AsMeans here = gyro.ring().AsMeansAt(groups_[i].t_s);
    const AsMeans later = gyro.ring().AsMeansHalfAfter(groups_[i].t_s);
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += groups_[i].weight * at[i].z[c];
      as_means[c] += groups_[i].weight * here[c];
      as_means_later[c] += groups_[i].weight * later[c];
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    mean->z[c] = sum[c] / readings_;
    mean->as_means[c] = as_means[c] / readings_;
    mean->as_means_later[c] = as_means_later[c] / readings_;
  }
  mean->output_known = true;
  AppendWithin(at, *mean, within);
  return true;
}

void NodeReadings::AppendWithin(const std::array<IntegralMark, kMost>& at, const ReadingsMean& mean,
                                std::vector<ReadingWithin>* within) const {
  if (size_ < 2) return;
  for (std::size_t i = 0; i < size_; ++i) {
    const Group& group = groups_[i];
    const Vector3 last = i + 1 == size_ ? newest_.rotation_deg : Vector3{};
    ReadingWithin reading;
    reading.after_s = static_cast<float>(group.t_s - mean.t_s);
    for (std::size_t c = 0; c < 3; ++c) {
      const double rotation_deg = (group.rotation_deg[c] + last[c]) / group.weight;
      reading.z[c] = static_cast<float>(at[i].z[c] - mean.z[c]);
      reading.rotation_deg[c] = static_cast<float>(rotation_deg - mean.rotation_deg[c]);
    }
    within->push_back(reading);
  }
}

bool NodeReadings::AverageNear(const GyroStream& gyro, Near* near) const {
  if (empty()) return false;
  const std::size_t shapes = std::min(size_, kShapes);
  const auto group = [&](std::size_t k) { return groups_[(2 * k + 1) * size_ / (2 * shapes)]; };
  std::array<IntegralMark, kShapes> at;
  for (std::size_t k = 0; k < shapes; ++k) {
    if (!gyro.IntegralAt(group(k).t_s, &at[k])) return false;
  }
  IntegralMark mark;
  for (std::size_t n = 0; n < kNear_s.size(); ++n) {
    Vector3 turned = {};
    double weights = 0.0;
    for (std::size_t k = 0; k < shapes; ++k) {
      if (!gyro.IntegralAt(group(k).t_s + kNear_s[n], &mark)) return false;
      for (std::size_t c = 0; c < 3; ++c) turned[c] += group(k).weight * (mark.z[c] - at[k].z[c]);
      weights += group(k).weight;
    }
    for (std::size_t c = 0; c < 3; ++c) (*near)[n][c] = turned[c] / weights;
  }
  return true;
}

}  // namespace gyrobench::calibration
