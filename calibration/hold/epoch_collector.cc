#include "calibration/hold/epoch_collector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/unsigned_counts.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kLongestWait = 4096;  // samples beside the gyro's, of a gyro that stays away

Vector3d Vector(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

bool Overlaps(const BadStretch& bad, const Epoch& epoch) {
  return bad.begin_s < epoch.end_s && bad.end_s > epoch.begin_s;
}

void MarkUnusable(const std::vector<BadStretch>& bad, std::vector<Epoch>* epochs) {
  for (const BadStretch& stretch : bad) {
    auto epoch = std::lower_bound(epochs->begin(), epochs->end(), stretch.begin_s,
                                  [](const Epoch& e, double t_s) { return e.end_s <= t_s; });
    for (; epoch != epochs->end() && Overlaps(stretch, *epoch); ++epoch) epoch->usable = false;
  }
}

// An accelerometer slower than the epochs: within kLongestBridge_s its value goes straight on from
// one epoch that has one to the next.
void BridgeAccelerometer(std::vector<Epoch>* epochs) {
  constexpr double kLongestBridge_s = 0.25;
  std::size_t last = epochs->size();
  for (std::size_t i = 0; i < epochs->size(); ++i) {
    const Epoch& to = (*epochs)[i];
    if (!to.accel_g.allFinite()) continue;
    const std::size_t first = std::exchange(last, i);
    if (first + 1 >= i || to.begin_s - (*epochs)[first].end_s > kLongestBridge_s) continue;
    const Epoch& from = (*epochs)[first];
    for (std::size_t k = first + 1; k < i; ++k) {
      const double part = ((*epochs)[k].end_s - from.end_s) / (to.end_s - from.end_s);
      (*epochs)[k].accel_g = (1.0 - part) * from.accel_g + part * to.accel_g;
    }
  }
}

// All samples together say whether the converter is an unsigned one, so that this comes last. Gaps
// hold nothing that a zero could be taken off.
void TakeZeroOff(std::vector<Epoch>* epochs) {
  const Vector3d zero = Vector3d::Constant(UnsignedCounts::kZero);
  for (Epoch& epoch : *epochs)
    if (!epoch.angle.isZero(0.0)) Detrend(zero, &epoch);
}

}  // namespace

void EpochCollector::OnInfo(const MeasurementInfo& info) {
  info_ = info;
  gyro_.Start(info);
  epochs_.reserve(8192);
}

void EpochCollector::OnGyro(const GyroSample& sample) {
  gyro_.Add(sample);
  const Vector3d accel_g = Vector(sample.accel_g);
  if (accel_g.allFinite()) ++accel_samples_;
  if (beside_.size() < kLongestWait && std::isfinite(sample.t_s))
    beside_.push_back({sample.t_s, accel_g, sample.temperature_degC});
  TakeSettled();
}

void EpochCollector::OnDefect(const Defect& defect) {
  reported_.Add(defect.kind, defect.where, defect.first_t_s, defect.count);
}

std::optional<double> EpochCollector::HighDifference::Next(const Vector3d& xi) {
  Vector3d difference = xi;
  for (std::size_t k = 0; k < kOrder; ++k) {
    const Vector3d before = std::exchange(last_[k], difference);
    if (k == samples_) {
      ++samples_;
      return std::nullopt;
    }
    difference -= before;
  }
  return difference.squaredNorm() / kGain;
}

// Intervals between samples that nothing changes any more.
void EpochCollector::TakeSettled() {
  const GyroRing& ring = gyro_.ring();
  next_ = std::max(next_, ring.oldest() + 1);
  for (; next_ < ring.count() - 2; ++next_) AddInterval(ring.at(next_ - 1), ring.at(next_));
}

// Rotations compose by exp(a) exp(b) = exp(a + b + a x b / 2 + ...). Within one interval the rate
// goes straight from one sample to the next, which adds h^2 / 12 xi_0 x xi_1 to the coning and
// takes h^2 / 12 (xi_1 - xi_0) off the first moment, so that an offset can be taken off exactly;
// its integral is the spline's (gyro_ring.h).
void EpochCollector::AddInterval(const GyroRing::Point& from, const GyroRing::Point& to) {
  const double h = to.t_s - from.t_s;
  if (to.gap) {
    if (is_open_) Close();
    high_.Restart();
    Epoch gap;
    gap.begin_s = from.t_s;
    gap.end_s = to.t_s;
    gap.usable = false;
    MeansUntil(to.t_s, &gap);
    epochs_.push_back(gap);
    return;
  }
  if (!is_open_) {
    open_ = Epoch{};
    open_.begin_s = open_.end_s = from.t_s;
    is_open_ = true;
  }
  const Vector3d step = Vector(to.z) - Vector(from.z);
  open_.coning +=
      0.5 * open_.angle.cross(step) + h * h / 12.0 * Vector(from.xi).cross(Vector(to.xi));
  open_.moment += h * (open_.angle + 0.5 * step) - h * h / 12.0 * (Vector(to.xi) - Vector(from.xi));
  open_.angle += step;
  open_.end_s = to.t_s;
  if (const std::optional<double> square = high_.Next(Vector(to.xi))) {
    open_.white_square += *square * h;
    ++open_.white_samples;
  }
  // Half an interval of tolerance, so that epochs of equal samples have equally many.
  if (open_.duration_s() > kEpoch_s - 0.5 * h) Close();
}

void EpochCollector::Close() {
  MeansUntil(open_.end_s, &open_);
  epochs_.push_back(open_);
  is_open_ = false;
}

void EpochCollector::MeansUntil(double end_s, Epoch* epoch) {
  Vector3d accel = Vector3d::Zero();
  double temperature = 0.0;
  int accels = 0, temperatures = 0;
  while (!beside_.empty() && beside_.front().t_s <= end_s) {
    const Beside& beside = beside_.front();
    if (beside.accel_g.allFinite()) {
      accel += beside.accel_g;
      ++accels;
    }
    if (std::isfinite(beside.temperature_degC)) {
      temperature += beside.temperature_degC;
      ++temperatures;
    }
    beside_.pop_front();
  }
  if (accels > 0) epoch->accel_g = accel / accels;
  if (temperatures > 0) epoch->temperature_degC = temperature / temperatures;
}

HoldRecording EpochCollector::Take() const {
  EpochCollector rest = *this;  // with the epoch that is still open
  if (rest.is_open_) rest.Close();
  HoldRecording out;
  out.info = info_;
  out.epochs = std::move(rest.epochs_);
  out.bad = rest.gyro_.bad();
  MarkUnusable(out.bad, &out.epochs);
  BridgeAccelerometer(&out.epochs);
  out.samples = rest.gyro_.samples();
  out.valid_samples = rest.gyro_.valid_samples();
  out.accel_samples = rest.accel_samples_;
  if (rest.gyro_.started()) {
    out.first_time_s = rest.gyro_.first_time_s();
    out.last_time_s = rest.gyro_.last_time_s();
  }
  out.median_interval_s = rest.gyro_.median_interval_s();
  DefectLog all = reported_;
  for (const Defect& defect : rest.gyro_.defects())
    all.Add(defect.kind, defect.where, defect.first_t_s, defect.count);
  out.defects = all.defects();
  if (info_.gyro_unit == RateUnit::kLsb) {
    const bool found = rest.gyro_.unsigned_counts();
    out.gyro_lsb_zero = found ? UnsignedCounts::kZero : info_.gyro_lsb_zero.value_or(0.0);
    if (found) TakeZeroOff(&out.epochs);
  }
  return out;
}

}  // namespace gyrobench::calibration
