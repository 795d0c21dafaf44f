#include "commission/probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/error.h"
#include "commission/delay.h"
#include "config/drive_rates.h"

namespace gyrobench::commission {
namespace {

constexpr double kFirst_deg = 0.25;  // of the first move
constexpr double kStep_deg = 4.5;    // of the moves after it, as the table turns
constexpr double kSmall_deg = 2.5;   // of those that show directions alone
constexpr double kFirstRate_deg_s = 1.0, kRate_deg_s = 5.0;
constexpr double kSettle_s = 0.25, kPoll_s = 0.005, kRest_s = 0.6;
constexpr double kSlack_s = 5.0;  // beyond twice the time that a move takes
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
    out_.specific_force_g = MeanOverRest(kRest_s, &Devices::Rate::specific_force_g);
    rest_deg_s_ = Rest_deg_s(kRest_s);
    for (std::size_t i = 0; i < axes_.size(); ++i) MoveFirst(i);
    for (std::size_t i = 0; i < axes_.size(); ++i) MoveOne(i);
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
    return MeanOverRest(duration_s, &Devices::Rate::rate_deg_s);
  }

  Vector3 MeanOverRest(double duration_s, Vector3 Devices::Rate::*of) {
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
        mean[a] += (rates_[i].*of)[a] / static_cast<double>(rates_.size() - first);
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
  const Move& MoveBy(Move::Kind kind, std::size_t drive, double commanded_deg, double rate_deg_s) {
    const config::AxisConfig& axis = axes_[drive];
    rate_deg_s = std::clamp(rate_deg_s, LeastRate_deg_s(axis), axis.max_rate_deg_s);
    rates_.erase(rates_.begin(), rates_.end() - 1);
    Move move{.kind = kind,
              .drive = drive,
              .commanded_deg = commanded_deg,
              .begin_deg = commanded_deg_,
              .before = ReadEncoders()};
    delays_.Begin(axes_.size());
    devices_.Progress(Done(), drive);
    devices_.StartMove(drive, commanded_deg, rate_deg_s, Acceleration_deg_s2(axis, rate_deg_s));
    commanded_deg_[drive] += commanded_deg;
    const double longest_s = 2.0 * std::fabs(commanded_deg) / rate_deg_s + kSlack_s;
    const Utime deadline = devices_.Now() + FromSeconds(longest_s);
    do {
      if (devices_.Now() > deadline) {
        throw DataError(
            fmt::format("axis.{}: its drive has not ended a move of {:g} deg within {:.1f} s",
                        axis.name, commanded_deg, longest_s));
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

  // Some four to learn how far each table turns, four large ones of it, and two of each of the
  // others.
  double Done() const {
    const std::size_t n = axes_.size();
    return std::min(0.99, static_cast<double>(out_.moves.size()) /
                              static_cast<double>(n * (4 + 4 + 2 * (n - 1))));
  }

  // A drive turns its shaft at whole rpm.
  static double LeastRate_deg_s(const config::AxisConfig& axis) {
    return std::min(axis.max_rate_deg_s, config::SlowestRate_deg_s(axis));
  }

  // Up to speed within a quarter of a second, or as slowly as the drive can.
  static double Acceleration_deg_s2(const config::AxisConfig& axis, double rate_deg_s) {
    constexpr double kRampUp_s = 0.25, kRounding = 1.01;
    const double slowest = kRounding * config::SlowestAcceleration_deg_s2(axis);
    return std::clamp(rate_deg_s / kRampUp_s, std::min(slowest, axis.max_acceleration_deg_s2),
                      axis.max_acceleration_deg_s2);
  }

  void Follow() {
    devices_.Wait(kPoll_s);
    devices_.ReadRates(&rates_);
    for (std::size_t j = 0; j < axes_.size(); ++j) delays_.Add(j, devices_.ReadEncoder(j));
  }

  // Small moves one way until two on end turn the table alike: play may take all of the first ones.
  // Where nothing is felt the next is twice as large, so that a ratio that is far off, or a worm with
  // much play, is felt before anything goes far. Back before anything is said of it.
  void MoveFirst(std::size_t drive) {
    constexpr int kMost = 10;
    constexpr double kAlike = 0.3, kFelt_deg = 0.08, kLargestStep_deg = 2.0;
    double step_deg = kFirst_deg, before = 0.0, scale = 0.0, felt_deg = 0.0;
    for (int k = 0; k < kMost && scale == 0.0 && felt_deg < 0.5 * kFarthest_deg; ++k) {
      const double turned_deg =
          Length(MoveBy(Move::Kind::kFirst, drive, step_deg, kFirstRate_deg_s).turned_deg);
      felt_deg += turned_deg;
      const double here = turned_deg / step_deg;
      if (turned_deg < kFelt_deg) {
        step_deg = std::min(2.0 * step_deg, kLargestStep_deg);
      } else if (before > 0.0 && std::fabs(here / before - 1.0) < kAlike) {
        scale = here;
      } else {
        before = here;
      }
    }
    MoveBy(Move::Kind::kFirst, drive, -commanded_deg_[drive], kFirstRate_deg_s);
    if (!(scale >= kLeastScale && scale <= kLargestScale)) {
      throw DataError(fmt::format(
          "axis.{}: its drive was told small moves, up to {:g} deg, and the gyro felt {:.3f} deg "
          "in "
          "all: is the motor connected, the shaft free and its coupling tight, the gyro on the "
          "table, and the gear ratio right within a factor of {:g}?",
          axes_[drive].name, step_deg, felt_deg, kLargestScale));
    }
    // Of so small a move the scale is known to some percent.
    constexpr double kNear = 0.2;
    scales_[drive] = std::fabs(scale - 1.0) < kNear ? 1.0 : scale;
  }

  void MoveOne(std::size_t drive) {
    Turn(Move::Kind::kLarge, drive, kStep_deg);
    Turn(Move::Kind::kLarge, drive, kStep_deg);
    for (std::size_t other = 0; other < axes_.size(); ++other) {
      if (other == drive) continue;
      Turn(Move::Kind::kSmall, other, kSmall_deg);
      Turn(Move::Kind::kSmall, other, -kSmall_deg);
    }
    Turn(Move::Kind::kLarge, drive, -kStep_deg);
    Turn(Move::Kind::kLarge, drive, -kStep_deg);
  }

  // The table by about this. One that turns much farther than the moves before it is not turned
  // again.
  void Turn(Move::Kind kind, std::size_t drive, double table_deg) {
    constexpr double kMuchFarther = 1.35;
    const double turned_deg = Length(
        MoveBy(kind, drive, table_deg / scales_[drive], kRate_deg_s / scales_[drive]).turned_deg);
    if (turned_deg <= kMuchFarther * std::fabs(table_deg)) return;
    throw DataError(
        fmt::format("axis.{}: its table turned by {:.2f} deg where the moves before let expect "
                    "{:.2f} deg: does "
                    "its shaft slip now and then? It stands where this move ended",
                    axes_[drive].name, turned_deg, std::fabs(table_deg)));
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
