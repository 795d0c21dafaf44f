#include "commission/wiring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "commission/axis_seen.h"
#include "commission/choice.h"

namespace gyrobench::commission {
namespace {

// Within which a ratio that was measured is taken for a whole number.
constexpr double kWhole = 0.004;
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

std::string Quoted(const std::string& text) { return fmt::format("\"{}\"", text); }

class Judgement {
 public:
  Judgement(const config::StandConfig& stand, const Measurements& measured, const Seen& seen,
            Choice choice)
      : stand_(stand),
        measured_(measured),
        seen_(seen),
        wired_(std::move(choice.wired)),
        rivals_(std::move(choice.rivals)) {}

  Wiring Judge() {
    JudgeDrives();
    JudgeEncoders();
    for (std::size_t drive = 0; drive < stand_.axes.size(); ++drive) {
      JudgePulses(drive);
      JudgeGear(drive);
      JudgeReturn(drive);
    }
    for (std::size_t j = 0; j < stand_.axes.size(); ++j) {
      JudgeScale(j);
      JudgeOffset(j);
    }
    JudgeMounting();
    JudgeDelay();
    TellRivals();
    return std::move(out_);
  }

 private:
  // What explains the same by as many mistakes.
  void TellRivals() {
    if (rivals_.empty() || out_.findings.empty()) return;
    std::string text;
    for (const Assignment& rival : rivals_) {
      std::string lines;
      for (const Finding& finding :
           Judgement(stand_, measured_, seen_, {rival, {}}).Judge().findings) {
        for (const Correction& line : finding.corrections)
          lines += fmt::format("{}{} = {}", lines.empty() ? "" : ", ", line.key, line.value);
      }
      text += fmt::format(" As likely, by all that was felt: {}.", lines);
    }
    out_.findings.back().reason += text + " Look which of them it is before a cable is changed.";
  }

  const std::string& AxisName(std::size_t axis) const { return stand_.axes[axis].name; }

  void Find(std::string what, std::string reason, std::vector<Correction> corrections = {}) {
    out_.findings.push_back({std::move(what), std::move(reason), std::move(corrections)});
  }

  // Bus, unit and map of one device in place of another's.
  template <typename Device>
  static void AddAddress(const std::string& key, const Device& now, const Device& was,
                         std::vector<Correction>* out) {
    if (now.bus != was.bus) out->push_back({key + ".bus", Quoted(now.bus), Quoted(was.bus)});
    if (now.unit != was.unit)
      out->push_back({key + ".unit", fmt::format("{}", now.unit), fmt::format("{}", was.unit)});
    if (now.map_file != was.map_file) {
      out->push_back({key + ".map", Quoted(now.map_file.string()), Quoted(was.map_file.string())});
    }
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
      const std::optional<std::size_t> axis = AxisOfEncoder(seen_, wired_, j);
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
      const bool other_way = CountsBackwards(stand_, seen_, wired_, j);
      const int sign = other_way ? -own.sign : own.sign;
      if (sign != was.sign)
        reversed.push_back({key + ".sign", fmt::format("{}", sign), fmt::format("{}", was.sign)});
      if (other_way)
        backwards +=
            fmt::format("{}that of axis.{}", backwards.empty() ? "" : ", ", AxisName(*axis));
    }
    if (!follow.empty()) {
      Find("exchanged encoders",
           fmt::format("Of the encoders, {}.{}", follow,
                       EachFollowsItsOwn(seen_, wired_)
                           ? ""
                           : " Some follow the same axis: look at their couplings."),
           EachFollowsItsOwn(seen_, wired_) ? exchanged : std::vector<Correction>());
    }
    if (!backwards.empty())
      Find("reversed encoder",
           fmt::format(
               "Encoders whose counts fall while the table turns right-handed about its axis: "
               "{}.",
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
    const double said = stand_.axes[axis].gear_ratio, here = stand_.axes[drive].gear_ratio;
    const double by_gyro = here / seen.scale;
    if (!seen.encoder || !seen.encoder_scale || Slips(seen))
      return JudgeGearByGyro(axis, by_gyro, said);
    const EncoderSeen& encoder = seen_.encoders[*seen.encoder];
    if (!encoder.counts_known) return JudgeGearByGyro(axis, by_gyro, said);
    const double found = here / *seen.encoder_scale;
    const double rounding = Rounding_deg(seen) / seen.turn_deg;
    if (std::fabs(found / said - 1.0) <= kGearByEncoder + rounding) {
      out_.notes.push_back(fmt::format("axis.{}: {:.4g} turns of the shaft are one of the table",
                                       AxisName(axis), found));
      return;
    }
    if (std::fabs(by_gyro / said - 1.0) <= kGearByGyro) {
      return Find(
          "gear ratio or counts per turn",
          fmt::format("By its encoder the table of axis.{} turns {:.1f} % {} than it is told, "
                      "which is less than the gyro's scale is known to: either {:.4g} turns "
                      "of the shaft are one of the table, or the encoder has {:.0f} counts a "
                      "turn. Read both off their labels.",
                      AxisName(axis), 100.0 * std::fabs(said / found - 1.0),
                      said > found ? "more" : "less", found,
                      encoder.counts_per_turn * said / found));
    }
    const double whole = std::round(found);
    const bool is_whole =
        whole >= 1.0 && std::fabs(found / whole - 1.0) <= std::max(kWhole, rounding);
    Find("gear ratio",
         fmt::format("The table of axis.{} turns {:.4g} times as far as it is told, by encoder and "
                     "gyro: {:.4g} turns of the shaft are one of the table, unless the shaft slips "
                     "by a constant share.",
                     AxisName(axis), said / found, found),
         {{fmt::format("axis.{}.gear_ratio", AxisName(axis)),
           is_whole ? fmt::format("{:g}", whole) : fmt::format("{:.4g}", found),
           fmt::format("{:g}", said)}});
  }

  // No line is written by the gyro alone: its scale is what the stand is to calibrate.
  void JudgeGearByGyro(std::size_t axis, double found, double said) {
    if (std::fabs(found / said - 1.0) <= kGearByGyro) {
      out_.notes.push_back(fmt::format(
          "axis.{}: {:.3g} turns of the shaft are one of the table, by the gyro to a few percent",
          AxisName(axis), found));
      return;
    }
    Find("gear ratio",
         fmt::format(
             "The table of axis.{} turns {:.3g} times as far as it is told, by the gyro to a "
             "few percent: about {:.3g} turns of the shaft are one of the table. Correct "
             "gear_ratio by the label of the worm.",
             AxisName(axis), said / found, found));
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
    const EncoderSeen& seen = seen_.encoders[encoder];
    const std::optional<std::size_t> axis = AxisOfEncoder(seen_, wired_, encoder);
    if (!axis || !seen.drive) return;
    const config::EncoderMap& said = stand_.axes[*axis].encoder.map;
    const std::string key = fmt::format("axis.{}.encoder", AxisName(*axis));
    if (seen.word_order != said.word_order) {
      Find("word order",
           fmt::format("The encoder of axis.{} moves as far as its table only if the {} of its two "
                       "registers is read as the high word.",
                       AxisName(*axis),
                       seen.word_order == config::WordOrder::kHighFirst ? "first" : "second"),
           {{key + ".word_order", Quoted(NameOf(seen.word_order)),
             Quoted(NameOf(said.word_order))}});
    }
    if (seen.counts_per_turn == said.counts_per_turn || Slips(seen_.drives[*seen.drive])) return;
    if (!seen.counts_known) {
      return Find("counts per turn",
                  fmt::format("By the angle that the gyro felt, the encoder of axis.{} has about "
                              "{:.3g} counts a turn, to a few percent, and not {:.0f}. Correct "
                              "counts_per_turn by its label.",
                              AxisName(*axis), seen.counts_per_turn, said.counts_per_turn));
    }
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

  // What an encoder of the axis reads at its mark, with all that is corrected of it.
  void JudgeOffset(std::size_t encoder) {
    constexpr double kAtMark_deg = 1.0, kLargest_deg = 360.0;
    const std::optional<std::size_t> axis = AxisOfEncoder(seen_, wired_, encoder);
    const EncoderSeen& seen = seen_.encoders[encoder];
    if (!axis || !seen.counts_known) return;
    const config::EncoderConfig& own = stand_.axes[encoder].encoder;
    const config::EncoderConfig& said = stand_.axes[*axis].encoder;
    const int sign = CountsBackwards(stand_, seen_, wired_, encoder) ? -own.sign : own.sign;
    const double range_deg = static_cast<double>(RangeWith(said.map, seen.counts_per_turn)) *
                             kFullTurn_deg / seen.counts_per_turn;
    // The driver takes the first reading in the range's repetition that is nearest to 0.
    const double counts_deg =
        sign * static_cast<double>(seen.at_mark) * kFullTurn_deg / seen.counts_per_turn;
    const double reads_deg = std::remainder(counts_deg + said.offset_deg, range_deg);
    if (std::fabs(reads_deg) <= kAtMark_deg) return;
    const double offset_deg = std::remainder(-counts_deg, range_deg);
    std::string reason = fmt::format("At its mark the encoder of axis.{} reads {:.3f} deg.",
                                     AxisName(*axis), reads_deg);
    if (std::fabs(offset_deg) > kLargest_deg) {
      return Find("offset of the encoder",
                  reason + " Set its own zero there, or turn it until it reads less than a turn.");
    }
    Find("offset of the encoder", std::move(reason),
         {{fmt::format("axis.{}.encoder.offset_deg", AxisName(*axis)),
           fmt::format("{:.3f}", offset_deg), fmt::format("{:g}", said.offset_deg)}});
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
    if (!(weights > 0.0)) {
      out_.notes.push_back(
          "the delay of the encoders could not be told: too few readings came while they moved");
      return;
    }
    const double found_s = sum / weights, error_s = 1.0 / std::sqrt(weights);
    const double said_s = stand_.axes.front().encoder.map.delay_s;
    if (std::fabs(found_s - said_s) <= std::max(kLeastDelay_s, kSureOfDelay * error_s)) {
      out_.notes.push_back(
          fmt::format("the encoders' values are {:.1f} ± {:.1f} ms older than the gyro's",
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
             "The encoders' values are {:.1f} ± {:.1f} ms older than the gyro's, not {:.1f} ms.",
             1e3 * found_s, 1e3 * error_s, 1e3 * said_s),
         found_s > 0.0 ? std::move(lines) : std::vector<Correction>());
  }

  const config::StandConfig& stand_;
  const Measurements& measured_;
  const Seen& seen_;
  const Assignment wired_;
  const std::vector<Assignment> rivals_;  // that cost as much
  Wiring out_;
};

}  // namespace

Wiring FindWiring(const config::StandConfig& stand, const Measurements& measured) {
  const Seen seen = LookAt(stand.axes, measured);
  return Judgement(stand, measured, seen, Choose(stand, measured, seen)).Judge();
}

}  // namespace gyrobench::commission
