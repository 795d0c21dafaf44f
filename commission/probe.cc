#include "commission/probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/error.h"
#include "commission/delay.h"

namespace gyrobench::commission {
namespace {

constexpr double kFirst_deg = 0.25;  // of the first move
constexpr double kStep_deg = 4.5;    // of the moves after it, as the table turns
constexpr double kSmall_deg = 2.5;   // of those that show directions alone
constexpr double kFirstRate_deg_s = 1.0, kRate_deg_s = 5.0;
constexpr double kSettle_s = 0.25, kPoll_s = 0.005, kRest_s = 0.6;
constexpr double kLongestMove_s = 30.0;
// Within which a first move must have turned a table, as a multiple of what was commanded.
constexpr double kLeastScale = 0.05, kLargestScale = 20.0;

class Prober {
 public:
  Prober(const std::vector<config::AxisConfig>& axes, Devices& devices)
      : axes_(axes),
        devices_(devices),
        scales_(axes.size(), 1.0),
        commanded_deg_(axes.size(), 0.0) {}

  Measurements Measure() {
    for (std::size_t i = 0; i < axes_.size(); ++i) CheckRoom(axes_[i]);
    for (std::size_t i = 0; i < axes_.size(); ++i)
      out_.pulses_per_turn.push_back(devices_.PulsesPerTurn(i));
    devices_.ReadRates(&rates_);
    rates_.clear();
    rest_deg_s_ = Rest_deg_s(kRest_s);
    for (std::size_t i = 0; i < axes_.size(); ++i) MoveFirst(i);
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      MoveOne(i);
      devices_.Progress(static_cast<double>(i + 1) / static_cast<double>(axes_.size()));
    }
    out_.delays = delays_.Found();
    return std::move(out_);
  }

 private:
  static void CheckRoom(const config::AxisConfig& axis) {
    if (axis.min_deg <= -kFarthest_deg && axis.max_deg >= kFarthest_deg) return;
    throw LimitError(
        fmt::format("axis.{}: its soft limits, {:g} .. {:g} deg, leave no {:g} deg both ways, "
                    "which it takes to find "
                    "out how a stand is wired: widen them where nothing is in the way",
                    axis.name, axis.min_deg, axis.max_deg, kFarthest_deg));
  }

  // At rest for so long; the gyro's mean meanwhile is its offset now. Its unit holds what a fraction
  // of a second brings.
  Vector3 Rest_deg_s(double duration_s) {
    const std::size_t first = rates_.size();
    for (const Utime until = devices_.Now() + FromSeconds(duration_s); devices_.Now() < until;) {
      devices_.Wait(kPoll_s);
      devices_.ReadRates(&rates_);
    }
    if (rates_.size() == first)
      throw DataError("no samples came from the gyro while the axes were at rest");
    Vector3 mean = {};
    for (std::size_t i = first; i < rates_.size(); ++i) {
      for (std::size_t a = 0; a < 3; ++a)
        mean[a] += rates_[i].rate_deg_s[a] / static_cast<double>(rates_.size() - first);
    }
    return mean;
  }

  // The integral of the rates of the move, less the offset.
  Vector3 Turned_deg(std::size_t samples, const Vector3& rest_deg_s) const {
    Vector3 turned_deg = {};
    for (std::size_t i = 1; i < samples; ++i) {
      const double duration_s = ToSeconds(rates_[i].utime - rates_[i - 1].utime);
      for (std::size_t a = 0; a < 3; ++a) {
        const double mean = 0.5 * (rates_[i].rate_deg_s[a] + rates_[i - 1].rate_deg_s[a]);
        turned_deg[a] += (mean - rest_deg_s[a]) * duration_s;
      }
    }
    return turned_deg;
  }

  std::vector<Words> ReadEncoders() {
    std::vector<Words> out;
    for (std::size_t j = 0; j < axes_.size(); ++j) out.push_back(devices_.ReadEncoder(j).words);
    return out;
  }

  // From rest to rest. The offset of a gyro that warms up is that before and after.
  const Move& MoveBy(std::size_t drive, double commanded_deg, double rate_deg_s) {
    const config::AxisConfig& axis = axes_[drive];
    rates_.erase(rates_.begin(), rates_.end() - 1);
    Move move{.drive = drive,
              .commanded_deg = commanded_deg,
              .begin_deg = commanded_deg_,
              .before = ReadEncoders()};
    delays_.Begin(axes_.size());
    devices_.StartMove(drive, commanded_deg, std::min(rate_deg_s, axis.max_rate_deg_s),
                       Acceleration_deg_s2(axis, rate_deg_s));
    commanded_deg_[drive] += commanded_deg;
    const Utime deadline = devices_.Now() + FromSeconds(kLongestMove_s);
    do {
      if (devices_.Now() > deadline) {
        throw DataError(
            fmt::format("axis.{}: its drive has not ended a move of {:g} deg within {:g} s",
                        axis.name, commanded_deg, kLongestMove_s));
      }
      Follow();
    } while (devices_.IsMoving(drive));
    for (const Utime until = devices_.Now() + FromSeconds(kSettle_s); devices_.Now() < until;)
      Follow();
    const std::size_t samples = rates_.size();
    const Vector3 after_deg_s = Rest_deg_s(kRest_s);
    Vector3 rest_deg_s = {};
    for (std::size_t a = 0; a < 3; ++a) rest_deg_s[a] = 0.5 * (rest_deg_s_[a] + after_deg_s[a]);
    rest_deg_s_ = after_deg_s;
    move.after = ReadEncoders();
    delays_.End(std::span(rates_).first(samples), rest_deg_s);
    move.turned_deg = Turned_deg(samples, rest_deg_s);
    out_.moves.push_back(std::move(move));
    return out_.moves.back();
  }

  // Up to speed within a quarter of a second, or as slowly as the drive can.
  static double Acceleration_deg_s2(const config::AxisConfig& axis, double rate_deg_s) {
    constexpr double kRampUp_s = 0.25, kDegSPerRpm = 6.0, kRounding = 1.01;
    const double slowest =
        kRounding * 1e6 * kDegSPerRpm / (axis.drive.map.max_ramp_ms_per_1000rpm * axis.gear_ratio);
    return std::clamp(rate_deg_s / kRampUp_s, std::min(slowest, axis.max_acceleration_deg_s2),
                      axis.max_acceleration_deg_s2);
  }

  void Follow() {
    devices_.Wait(kPoll_s);
    devices_.ReadRates(&rates_);
    for (std::size_t j = 0; j < axes_.size(); ++j) delays_.Add(j, devices_.ReadEncoder(j));
  }

  // Twice, since play may take all of the first; back before anything is said of it.
  void MoveFirst(std::size_t drive) {
    const double first_deg = Length(MoveBy(drive, kFirst_deg, kFirstRate_deg_s).turned_deg);
    const double second_deg = 2.0 * kFirst_deg / std::max(1.0, first_deg / kFirst_deg);
    const double turned_deg = Length(MoveBy(drive, second_deg, kFirstRate_deg_s).turned_deg);
    MoveBy(drive, -commanded_deg_[drive], kFirstRate_deg_s);
    const double scale = turned_deg / second_deg;
    if (scale < kLeastScale || scale > kLargestScale) {
      throw DataError(fmt::format(
          "axis.{}: its drive was told {:g} deg, and the gyro felt {:.3f} deg: is the motor "
          "connected, the "
          "shaft free, the gyro on the table, and the gear ratio right within a factor of {:g}?",
          axes_[drive].name, second_deg, turned_deg, kLargestScale));
    }
    // Of so small a move the scale is known to some percent.
    constexpr double kNear = 0.2;
    scales_[drive] = std::fabs(scale - 1.0) < kNear ? 1.0 : scale;
  }

  void MoveOne(std::size_t drive) {
    for (const double sense : {1.0, 1.0}) Turn(drive, sense * kStep_deg);
    for (std::size_t other = 0; other < axes_.size(); ++other) {
      if (other == drive) continue;
      Turn(other, kSmall_deg);
      Turn(other, -kSmall_deg);
    }
    for (const double sense : {-1.0, -1.0}) Turn(drive, sense * kStep_deg);
  }

  // The table by about this.
  void Turn(std::size_t drive, double table_deg) {
    MoveBy(drive, table_deg / scales_[drive], kRate_deg_s / scales_[drive]);
  }

  const std::vector<config::AxisConfig>& axes_;
  Devices& devices_;
  std::vector<double> scales_;
  std::vector<double> commanded_deg_;
  Vector3 rest_deg_s_ = {};           // the gyro's offset, at the end of the last move
  std::vector<Devices::Rate> rates_;  // of the move under way, from the last one before it on
  DelaySeen delays_;
  Measurements out_;
};

}  // namespace

Measurements Probe(const std::vector<config::AxisConfig>& axes, Devices& devices) {
  return Prober(axes, devices).Measure();
}

}  // namespace gyrobench::commission
