#include "tests/commission/plain_stand.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobench::commission {
namespace {

constexpr Utime kSample_us = 5000;
constexpr double kRad = 3.14159265358979323846 / 180.0;

}  // namespace

void PlainStand::StartMove(std::size_t drive, double angle_deg, double rate_deg_s, double) {
  on_move();
  const std::size_t axis = wired_.drive_axis[drive];
  shaft_deg_[axis] += (1.0 - slip) * angle_deg * wired_.turned_per_commanded[drive];
  const double half = 0.5 * wired_.play_deg;
  const double from = angle_deg_[axis];
  const double to = std::clamp(from, shaft_deg_[axis] - half, shaft_deg_[axis] + half);
  const double duration_s = std::fabs(angle_deg) / rate_deg_s;
  const double loosened = axis == 1 ? wired_.loose * std::max(0.0, to - from) : 0.0;
  move_ = {axis, now_, now_ + FromSeconds(duration_s), from, to, loosened};
  behind_deg_ += loosened;
  angle_deg_[axis] = to;
  farthest_deg_ = std::max(farthest_deg_, std::fabs(to));
}

// The play is taken up at the begin of a move.
double PlainStand::AngleAt(std::size_t axis, Utime at) const {
  if (axis != move_.axis || at >= move_.end) return angle_deg_[axis];
  if (at <= move_.begin) return move_.from_deg;
  const double share = ToSeconds(at - move_.begin) / ToSeconds(move_.end - move_.begin);
  return move_.from_deg + share * (move_.to_deg - move_.from_deg);
}

Devices::Angle PlainStand::ReadEncoder(std::size_t encoder) {
  const std::size_t axis = wired_.encoder_axis[encoder];
  const double angle_deg = AngleAt(axis, now_ - FromSeconds(wired_.delay_s));
  const double behind = axis == 1 ? behind_deg_ : 0.0;
  const double counts = std::round((angle_deg - behind) * wired_.counts_per_deg[encoder]);
  const std::int64_t flicker = wired_.flickers ? ++readings_ / 3 % 2 : 0;
  const auto value = static_cast<std::uint32_t>(
      (static_cast<std::int64_t>(counts) + wired_.counts_at_mark[encoder] + flicker) & 0x1FFFFFFF);
  const auto high = static_cast<std::uint16_t>(value >> 16);
  const auto low = static_cast<std::uint16_t>(value & 0xFFFF);
  if (wired_.low_word_first[encoder]) return {now_, {low, high}};
  return {now_, {high, low}};
}

void PlainStand::ReadRates(std::vector<Rate>* rates) {
  for (; read_until_ + kSample_us <= now_; read_until_ += kSample_us) {
    const Utime at = read_until_ + kSample_us / 2;
    const double rate_deg_s =
        (AngleAt(move_.axis, read_until_ + kSample_us) - AngleAt(move_.axis, read_until_)) /
        ToSeconds(kSample_us);
    const Eigen::AngleAxisd middle(AngleAt(1, at) * kRad, Eigen::Vector3d::UnitX()),
        inner(AngleAt(2, at) * kRad, Eigen::Vector3d::UnitZ());
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    if (move_.axis == 0) axis = middle.inverse() * axis;
    if (move_.axis == 1) axis = Eigen::Vector3d::UnitX();
    if (move_.axis != 2) axis = inner.inverse() * axis;
    const Eigen::Vector3d felt = wired_.mount.transpose() * axis * rate_deg_s;
    Eigen::Vector3d up = Eigen::Vector3d::Zero();
    if (wired_.accelerometer)
      up = wired_.mount.transpose() *
           (inner.inverse() * (middle.inverse() * Eigen::Vector3d::UnitZ()));
    // An offset that is no rotation.
    rates->push_back(
        {at, {felt.x() + 1.5, felt.y() - 0.7, felt.z() + 0.2}, {up.x(), up.y(), up.z()}});
  }
}

std::vector<config::AxisConfig> PlainAxes() {
  std::vector<config::AxisConfig> axes(3);
  const std::array<const char*, 3> names = {"outer", "middle", "inner"};
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i].name = names[i];
    axes[i].drive.bus = axes[i].encoder.bus = "a";
    axes[i].drive.unit = static_cast<int>(i) + 1;
    axes[i].encoder.unit = static_cast<int>(i) + 11;
    axes[i].encoder.map.words = 2;
    axes[i].encoder.map.counts_per_turn = 131072;
    axes[i].encoder.map.range_counts = 0x20000000;
  }
  return axes;
}

}  // namespace gyrobench::commission
