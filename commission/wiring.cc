#include "commission/wiring.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "base/error.h"
#include "commission/axis_seen.h"
#include "commission/directions.h"

namespace gyrobench::commission {
namespace {

// A sensor is glued on, and a stand built, to a degree or two.
constexpr double kMountingKnown_deg = 5.0;
// Better than one reversed drive by nothing, worse than two: as likely as a mistake and a half.
constexpr double kCostOfMounting = 1.5;
// Of a gear ratio: by an encoder that counts finely, and by the gyro, whose scale is known to a few
// percent.
constexpr double kGearByEncoder = 0.01, kGearByGyro = 0.06;
// What a coarse encoder adds to any difference of its angles [counts].
constexpr double kRounding_counts = 2.0;
// Of a worm that wants to be set.
constexpr double kLargestPlay_deg = 0.1;
// What a table or an encoder may end beside where it began.
constexpr double kLargestOff_deg = 0.15;
// Turns one way over those the other way.
constexpr double kSameBothWays = 0.05;
constexpr double kLeastDelay_s = 0.002, kSureOfDelay = 4.0;

std::size_t StandAxis(const std::string& name) {
  return name == "outer" ? 0 : (name == "middle" ? 1 : 2);
}

// Of a permutation: how many pairs are to be exchanged.
std::size_t Exchanges(const std::vector<std::size_t>& places) {
  std::vector<bool> seen(places.size(), false);
  std::size_t cycles = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (seen[i]) continue;
    ++cycles;
    for (std::size_t j = i; !seen[j]; j = places[j]) seen[j] = true;
  }
  return places.size() - cycles;
}

std::string Quoted(const std::string& text) { return fmt::format("\"{}\"", text); }

class Judgement {
 public:
  Judgement(const config::StandConfig& stand, const Measurements& measured)
      : stand_(stand), measured_(measured), seen_(LookAt(stand.axes, measured)) {
    std::vector<std::size_t> stand_axes;
    std::vector<double> scales;
    for (const config::AxisConfig& axis : stand.axes) stand_axes.push_back(StandAxis(axis.name));
    for (const DriveSeen& drive : seen_.drives) scales.push_back(drive.scale);
    ChooseAssignment(FittingAssignments(stand.geometry, stand_axes, seen_.with_direction, scales));
  }

  Wiring Judge() {
    JudgeDrives();
    JudgeEncoders();
    for (std::size_t drive = 0; drive < stand_.axes.size(); ++drive) {
      JudgePulses(drive);
      JudgeGear(drive);
      JudgeReturn(drive);
    }
    for (std::size_t j = 0; j < stand_.axes.size(); ++j) JudgeScale(j);
    JudgeMounting();
    JudgeDelay();
    return std::move(out_);
  }

 private:
  // The axis that an encoder follows, as wired.
  std::optional<std::size_t> AxisOfEncoder(const Assignment& wired, std::size_t encoder) const {
    const std::optional<std::size_t> drive = seen_.encoders[encoder].drive;
    return drive ? std::optional(wired.axis_of_drive[*drive]) : std::nullopt;
  }
  // That its counts go the other way than its sign says.
  bool CountsBackwards(const Assignment& wired, std::size_t encoder) const {
    const EncoderSeen& seen = seen_.encoders[encoder];
    return seen.drive &&
           seen.ratio * wired.sense_of_drive[*seen.drive] * stand_.axes[encoder].encoder.sign < 0.0;
  }

  double Cost(const Assignment& wired) const {
    double cost = static_cast<double>(Exchanges(wired.axis_of_drive));
    std::vector<std::size_t> places;
    for (const int sense : wired.sense_of_drive) cost += sense < 0 ? 1.0 : 0.0;
    for (std::size_t j = 0; j < seen_.encoders.size(); ++j) {
      cost += CountsBackwards(wired, j) ? 1.0 : 0.0;
      if (const auto axis = AxisOfEncoder(wired, j)) places.push_back(*axis);
    }
    std::vector<std::size_t> each = places;
    std::ranges::sort(each);
    const bool all_differ = std::ranges::adjacent_find(each) == each.end();
    if (all_differ && places.size() == seen_.encoders.size())
      cost += static_cast<double>(Exchanges(places));
    return cost + (wired.mounting_off_deg > kMountingKnown_deg ? kCostOfMounting : 0.0);
  }

  void ChooseAssignment(std::vector<Assignment> fitting) {
    std::ranges::stable_sort(fitting, {}, [this](const Assignment& one) {
      return std::pair(Cost(one), one.misfit_deg);
    });
    constexpr double kFits_deg = 6.0;
    wired_ = std::move(fitting.front());
    if (wired_.misfit_deg <= kFits_deg) return;
    throw DataError(fmt::format(
        "the directions in which the gyro feels the axes are {:.0f} deg off those of any stand of "
        "this kind: are the axes at their marks, and outer_middle_deg and middle_inner_deg right?",
        wired_.misfit_deg));
  }

  const std::string& AxisName(std::size_t axis) const { return stand_.axes[axis].name; }

  void Find(std::string what, std::string reason, std::vector<Correction> corrections = {}) {
    out_.findings.push_back({std::move(what), std::move(reason), std::move(corrections)});
  }

  // Bus and unit of one device in place of another's.
  template <typename Device>
  static void AddAddress(const std::string& key, const Device& now, const Device& was,
                         std::vector<Correction>* out) {
    if (now.bus != was.bus) out->push_back({key + ".bus", Quoted(now.bus), Quoted(was.bus)});
    if (now.unit != was.unit)
      out->push_back({key + ".unit", fmt::format("{}", now.unit), fmt::format("{}", was.unit)});
  }

  void JudgeDrives() {
    std::vector<Correction> exchanged, reversed;
    std::string moves, turns;
    for (std::size_t i = 0; i < stand_.axes.size(); ++i) {
      const std::size_t axis = wired_.axis_of_drive[i];
      const config::DriveConfig &own = stand_.axes[i].drive, &was = stand_.axes[axis].drive;
      const std::string key = fmt::format("axis.{}.drive", AxisName(axis));
      if (axis != i) {
        AddAddress(key, own, was, &exchanged);
        moves += fmt::format("{}the drive of {} (unit {}) turns axis.{}", moves.empty() ? "" : ", ",
                             AxisName(i), own.unit, AxisName(axis));
      }
      const int sign = own.sign * wired_.sense_of_drive[i];
      if (sign != was.sign)
        reversed.push_back({key + ".sign", fmt::format("{}", sign), fmt::format("{}", was.sign)});
      if (wired_.sense_of_drive[i] < 0)
        turns += fmt::format("{}axis.{} turns the other way than it is told",
                             turns.empty() ? "" : ", ", AxisName(axis));
    }
    if (!moves.empty())
      Find("exchanged drives", fmt::format("By the directions that the gyro feels, {}.", moves),
           exchanged);
    if (!turns.empty()) {
      Find("reversed drive", fmt::format("By the sense that the gyro feels, {}.", turns), reversed);
    }
  }

  void JudgeEncoders() {
    std::vector<Correction> exchanged, reversed;
    std::string follow, backwards;
    for (std::size_t j = 0; j < stand_.axes.size(); ++j) {
      const config::EncoderConfig& own = stand_.axes[j].encoder;
      const std::optional<std::size_t> axis = AxisOfEncoder(wired_, j);
      if (!axis) {
        Find("encoder that stands still",
             fmt::format("The encoder of {} (unit {}) follows no axis: is its coupling tight, and "
                         "its address in the map right?",
                         AxisName(j), own.unit));
        continue;
      }
      const config::EncoderConfig& was = stand_.axes[*axis].encoder;
      const std::string key = fmt::format("axis.{}.encoder", AxisName(*axis));
      if (*axis != j) {
        AddAddress(key, own, was, &exchanged);
        follow += fmt::format("{}that of {} (unit {}) follows axis.{}", follow.empty() ? "" : ", ",
                              AxisName(j), own.unit, AxisName(*axis));
      }
      const bool other_way = CountsBackwards(wired_, j);
      const int sign = other_way ? -own.sign : own.sign;
      if (sign != was.sign)
        reversed.push_back({key + ".sign", fmt::format("{}", sign), fmt::format("{}", was.sign)});
      if (other_way)
        backwards +=
            fmt::format("{}that of axis.{}", backwards.empty() ? "" : ", ", AxisName(*axis));
    }
    if (!follow.empty())
      Find("exchanged encoders", fmt::format("Of the encoders, {}.", follow), exchanged);
    if (!backwards.empty())
      Find("reversed encoder",
           fmt::format("Encoders that fall while the table turns right-handed about its axis: {}.",
                       backwards),
           reversed);
  }

  // Against what is said of the axis that it is to be the drive of.
  void JudgePulses(std::size_t drive) {
    const config::AxisConfig& axis = stand_.axes[wired_.axis_of_drive[drive]];
    const int found = measured_.pulses_per_turn[drive], said = axis.drive.map.pulses_per_turn;
    if (found == said) return;
    Find("pulses per turn",
         fmt::format("The drive of axis.{} is set to {} pulses a turn of the shaft, not to {}.",
                     axis.name, found, said),
         {{fmt::format("axis.{}.drive.pulses_per_turn", axis.name), fmt::format("{}", found),
           fmt::format("{}", said)}});
  }

  // Of the encoder on a drive; 0 where none follows it.
  double Rounding_deg(const DriveSeen& seen) const {
    return seen.encoder
               ? kRounding_counts * kFullTurn_deg / seen_.encoders[*seen.encoder].counts_per_turn
               : 0.0;
  }
  bool Slips(const DriveSeen& seen) const {
    const double rounding_deg = Rounding_deg(seen);
    return seen.encoder && std::fabs(seen.table_off_deg) < kLargestOff_deg &&
           (std::fabs(seen.encoder_off_deg) > kLargestOff_deg + rounding_deg ||
            std::fabs(seen.there_over_back - 1.0) > kSameBothWays + rounding_deg / seen.turn_deg);
  }

  void JudgeGear(std::size_t drive) {
    const DriveSeen& seen = seen_.drives[drive];
    const std::size_t axis = wired_.axis_of_drive[drive];
    const bool by_encoder = seen.encoder_scale && !Slips(seen);
    const double scale = by_encoder ? *seen.encoder_scale : seen.scale;
    const double known =
        by_encoder ? kGearByEncoder + Rounding_deg(seen) / seen.turn_deg : kGearByGyro;
    const double said = stand_.axes[axis].gear_ratio;
    const double found = stand_.axes[drive].gear_ratio / scale;
    if (std::fabs(found / said - 1.0) <= known) {
      out_.notes.push_back(fmt::format("axis.{}: {:.4g} turns of the shaft are one of the table{}",
                                       AxisName(axis), found,
                                       by_encoder ? "" : ", by the gyro alone"));
      return;
    }
    const double whole = std::round(found);
    const bool is_whole = whole >= 1.0 && std::fabs(found / whole - 1.0) <= known;
    const double ratio = is_whole ? whole : std::round(found * 1000.0) / 1000.0;
    Find("gear ratio",
         fmt::format(
             "The table of axis.{} turns {:.4g} times as far as it is told, by {}: {:.4g} turns "
             "of the shaft are one of the table.",
             AxisName(axis), said / found, by_encoder ? "encoder and gyro" : "the gyro", found),
         {{fmt::format("axis.{}.gear_ratio", AxisName(axis)), fmt::format("{:g}", ratio),
           fmt::format("{:g}", said)}});
  }

  // Whether table and encoder come back to where they were, and how much play there is.
  void JudgeReturn(std::size_t drive) {
    const DriveSeen& seen = seen_.drives[drive];
    const std::string& axis = AxisName(wired_.axis_of_drive[drive]);
    if (std::fabs(seen.table_off_deg) >= kLargestOff_deg)
      return Find(
          "lost steps",
          fmt::format("The table of axis.{} came back {:.2f} deg beside where it began, by the "
                      "gyro: the motor loses steps, or the shaft slips in its coupling. Tighten "
                      "it, lower the acceleration or raise the motor's current.",
                      axis, std::fabs(seen.table_off_deg)));
    if (Slips(seen)) {
      return Find(
          "slipping encoder",
          fmt::format(
              "The encoder of axis.{} came back {:.2f} deg beside where it began, and turned "
              "{:.1f} % more one way than the other, while the gyro came back within {:.2f} "
              "deg: tighten its coupling.",
              axis, std::fabs(seen.encoder_off_deg), 100.0 * std::fabs(seen.there_over_back - 1.0),
              std::fabs(seen.table_off_deg)));
    }
    if (!seen.play_deg) return;
    if (*seen.play_deg > kLargestPlay_deg + Rounding_deg(seen)) {
      return Find("play",
                  fmt::format("The table of axis.{} has a play of {:.2f} deg when the shaft turns "
                              "back: set the worm closer to its wheel.",
                              axis, *seen.play_deg));
    }
    out_.notes.push_back(
        fmt::format("axis.{}: play {:.3f} deg", axis, std::max(0.0, *seen.play_deg)));
  }

  // Against what is said of the axis that it is to be the encoder of.
  void JudgeScale(std::size_t encoder) {
    const std::optional<std::size_t> axis = AxisOfEncoder(wired_, encoder);
    if (!axis) return;
    const EncoderSeen& seen = seen_.encoders[encoder];
    const config::EncoderMap& said = stand_.axes[*axis].encoder.map;
    const std::string key = fmt::format("axis.{}.encoder", AxisName(*axis));
    if (seen.word_order != said.word_order) {
      Find("word order",
           fmt::format("The encoder of axis.{} turns as its table does only where of its two "
                       "registers the {} one is the high word.",
                       AxisName(*axis),
                       seen.word_order == config::WordOrder::kHighFirst ? "first" : "second"),
           {{key + ".word_order", Quoted(NameOf(seen.word_order)),
             Quoted(NameOf(said.word_order))}});
    }
    if (seen.counts_per_turn == said.counts_per_turn || Slips(seen_.drives[*seen.drive])) return;
    std::vector<Correction> lines = {{key + ".counts_per_turn",
                                      fmt::format("{:.0f}", seen.counts_per_turn),
                                      fmt::format("{:.0f}", said.counts_per_turn)}};
    if (const std::uint64_t range = RangeWith(said, seen.counts_per_turn);
        range != said.range_counts)
      lines.push_back(
          {key + ".range_counts", fmt::format("{}", range), fmt::format("{}", said.range_counts)});
    Find(
        "counts per turn",
        fmt::format("By the angle that the gyro felt, the encoder of axis.{} counts {:.0f} a turn, "
                    "if that is one of the usual numbers, and not {:.0f}.",
                    AxisName(*axis), seen.counts_per_turn, said.counts_per_turn),
        std::move(lines));
  }

  void JudgeMounting() {
    StandGeometry found = wired_.geometry, was = stand_.geometry;
    if (wired_.mounting_off_deg <= kMountingKnown_deg) {
      out_.notes.push_back(
          fmt::format("the sensor sits on its table as geometry.mount_* says, to {:.1f} deg",
                      wired_.mounting_off_deg));
      return;
    }
    std::vector<Correction> lines;
    const auto now = AnglesOf(found), before = AnglesOf(was);
    for (std::size_t k = 0; k < 3; ++k) {
      const double right = 90.0 * std::round(*now[k].value_deg / 90.0);
      double angle = std::fabs(*now[k].value_deg - right) < kMountingKnown_deg
                         ? right
                         : 0.1 * std::round(10.0 * *now[k].value_deg);
      if (angle == -180.0) angle = 180.0;
      if (angle == *before[k].value_deg) continue;
      lines.push_back({fmt::format("geometry.{}", now[k].name), fmt::format("{:g}", angle + 0.0),
                       fmt::format("{:g}", *before[k].value_deg)});
    }
    Find("mounting",
         fmt::format(
             "The gyro feels the axes as one that is turned by {:.0f} deg from geometry.mount_*.",
             wired_.mounting_off_deg),
         std::move(lines));
  }

  // One for all encoders, as the stand file has it.
  void JudgeDelay() {
    double sum = 0.0, weights = 0.0;
    for (const std::optional<Measurements::Delay>& delay : measured_.delays) {
      if (!delay || !(delay->std_error_s > 0.0)) continue;
      const double weight = 1.0 / (delay->std_error_s * delay->std_error_s);
      sum += weight * delay->value_s;
      weights += weight;
    }
    if (!(weights > 0.0)) return;
    const double found_s = sum / weights, error_s = 1.0 / std::sqrt(weights);
    const double said_s = stand_.axes.front().encoder.map.delay_s;
    if (std::fabs(found_s - said_s) <= std::max(kLeastDelay_s, kSureOfDelay * error_s)) {
      out_.notes.push_back(fmt::format("the encoders' values are {:.1f} +- {:.1f} ms old",
                                       1e3 * found_s, 1e3 * error_s));
      return;
    }
    std::vector<Correction> lines;
    for (const config::AxisConfig& axis : stand_.axes) {
      lines.push_back({fmt::format("axis.{}.encoder.delay_s", axis.name),
                       fmt::format("{:.4f}", std::max(0.0, found_s)), fmt::format("{:g}", said_s)});
    }
    Find("delay of the reference",
         fmt::format(
             "Beside the gyro's the encoders' values are {:.1f} +- {:.1f} ms old, not {:.1f} ms.",
             1e3 * found_s, 1e3 * error_s, 1e3 * said_s),
         found_s > 0.0 ? std::move(lines) : std::vector<Correction>());
  }

  const config::StandConfig& stand_;
  const Measurements& measured_;
  const Seen seen_;
  Assignment wired_;
  Wiring out_;
};

}  // namespace

Wiring FindWiring(const config::StandConfig& stand, const Measurements& measured) {
  return Judgement(stand, measured).Judge();
}

}  // namespace gyrobench::commission
