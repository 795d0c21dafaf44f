#include "commission/axis_seen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/error.h"
#include "config/words.h"

namespace gyrobench::commission {
namespace {

// Noise of a gyro in a move of some seconds is a hundredth of it.
constexpr double kLeastTurn_deg = 0.1;
// Of which a direction is known to a degree.
constexpr double kLeastForDirection_deg = 1.5;
// An encoder that moves by less is noise: of its counts, and of its table's angle.
constexpr std::int64_t kLeastCounts = 3;
constexpr double kLeastShare = 0.01;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::vector<const Move*> Large(const Measurements& measured, std::size_t drive) {
  std::vector<const Move*> out;
  for (const Move& move : measured.moves)
    if (move.drive == drive && move.kind == Move::Kind::kLarge) out.push_back(&move);
  return out;
}

class Looking {
 public:
  Looking(const std::vector<config::AxisConfig>& axes, const Measurements& measured)
      : axes_(axes), measured_(measured) {}

  Seen Look() {
    for (std::size_t i = 0; i < axes_.size(); ++i)
      seen_.drives.push_back({.scale = Scale(i), .turn_deg = 0.0});
    for (const Move& move : measured_.moves) {
      if (Length(move.turned_deg) > kLeastForDirection_deg) seen_.with_direction.push_back(&move);
    }
    for (std::size_t j = 0; j < axes_.size(); ++j) seen_.encoders.push_back(LookAtEncoder(j));
    for (std::size_t i = 0; i < axes_.size(); ++i) LookAtMoves(i);
    return std::move(seen_);
  }

 private:
  double Scale(std::size_t drive) const {
    std::vector<double> scales;
    for (const Move* move : Large(measured_, drive)) {
      const double turned_deg = Length(move->turned_deg);
      if (turned_deg > kLeastTurn_deg)
        scales.push_back(turned_deg / std::fabs(move->commanded_deg));
    }
    if (!scales.empty()) return Median(std::move(scales));
    throw DataError(fmt::format(
        "axis.{}: the gyro felt nothing while its drive was turning: is the motor connected, the "
        "shaft free and the gyro on the table?",
        axes_[drive].name));
  }

  double Angle_deg(std::size_t encoder, const EncoderSeen& as, const Move& move) const {
    return static_cast<double>(Step(axes_[encoder].encoder.map, as.word_order, move.before[encoder],
                                    move.after[encoder])) *
           kFullTurn_deg / as.counts_per_turn;
  }

  // Over the drive's moves; 0 where it stood still, or moves now so and now so.
  double Ratio(std::size_t encoder, std::size_t drive, config::WordOrder order) const {
    const config::EncoderMap& map = axes_[encoder].encoder.map;
    // The smallest over the largest: it may slip, and have play. In the other order than that of its
    // map a count that flickers is thousands of them.
    const double alike = order == map.word_order ? 0.2 : 0.6;
    const EncoderSeen as{
        .drive = drive, .word_order = order, .counts_per_turn = map.counts_per_turn};
    std::vector<double> ratios;
    for (const Move* move : Large(measured_, drive)) {
      const std::int64_t counts =
          std::abs(Step(map, order, move->before[encoder], move->after[encoder]));
      const double ratio =
          Angle_deg(encoder, as, *move) / (seen_.drives[drive].scale * move->commanded_deg);
      const bool stood = counts <= kLeastCounts || std::fabs(ratio) < kLeastShare;
      ratios.push_back(stood ? 0.0 : ratio);
    }
    const auto [least, most] = std::ranges::minmax(ratios);
    if (!(least * most > 0.0)) return 0.0;
    const double share =
        std::min(std::fabs(least), std::fabs(most)) / std::max(std::fabs(least), std::fabs(most));
    if (share < alike) return 0.0;
    // Of those that go on as the one before: in the others the table has play, and the encoder.
    std::vector<double> going_on;
    for (std::size_t k = 1; k < ratios.size(); k += 2) going_on.push_back(ratios[k]);
    return going_on.empty() ? Median(std::move(ratios)) : Mean(going_on);
  }

  // In the order of words in which it moves as far as a table does.
  EncoderSeen LookAtEncoder(std::size_t encoder) const {
    const config::EncoderMap& map = axes_[encoder].encoder.map;
    EncoderSeen best{.word_order = map.word_order, .counts_per_turn = map.counts_per_turn};
    double least_off = 0.0;
    for (const config::WordOrder order : {map.word_order, Other(map.word_order)}) {
      EncoderSeen here{.word_order = order, .counts_per_turn = map.counts_per_turn};
      for (std::size_t drive = 0; drive < axes_.size(); ++drive) {
        const double ratio = Ratio(encoder, drive, order);
        if (std::fabs(ratio) <= std::fabs(here.ratio)) continue;
        here.ratio = ratio;
        here.drive = drive;
      }
      if (!here.drive) continue;
      const double off = std::fabs(std::log(std::fabs(here.ratio)));
      if (!best.drive || off < least_off) {
        best = here;
        least_off = off;
      }
      if (map.words == 1) break;
    }
    best.at_mark = Value(map, best.word_order, measured_.moves.front().before[encoder]);
    if (best.drive && std::fabs(std::fabs(best.ratio) - 1.0) > kScaleKnown) {
      const double about = map.counts_per_turn * std::fabs(best.ratio);
      const std::optional<double> likely = LikelyCounts(about);
      best.counts_known = likely.has_value();
      best.counts_per_turn = likely.value_or(about);
    }
    return best;
  }

  // There, on, back, on: the second and the fourth go on as the one before.
  void LookAtMoves(std::size_t drive) {
    DriveSeen& seen = seen_.drives[drive];
    for (std::size_t j = 0; j < axes_.size(); ++j) {
      if (seen_.encoders[j].drive == drive && !seen.encoder) seen.encoder = j;
    }
    const std::vector<const Move*> moves = Large(measured_, drive);
    const Move& first = *moves.front();
    seen.turn_deg = seen.scale * std::fabs(first.commanded_deg);
    const double unit = Length(first.turned_deg) > 0.0 ? Length(first.turned_deg) : 1.0;
    std::vector<double> going_on, after_turn, encoder_scales;
    for (std::size_t k = 0; k < moves.size(); ++k) {
      const Move& move = *moves[k];
      // Along the first: the sense of the drive.
      double along_deg = 0.0;
      for (std::size_t a = 0; a < 3; ++a)
        along_deg += move.turned_deg[a] * first.turned_deg[a] / unit;
      seen.table_off_deg += along_deg;
      const double encoder_deg =
          seen.encoder ? Angle_deg(*seen.encoder, seen_.encoders[*seen.encoder], move) : along_deg;
      seen.encoder_off_deg += encoder_deg;
      (k % 2 == 1 ? going_on : after_turn).push_back(std::fabs(encoder_deg));
      if (k % 2 == 1 && seen.encoder)
        encoder_scales.push_back(std::fabs(encoder_deg / move.commanded_deg));
    }
    if (!encoder_scales.empty()) seen.encoder_scale = Mean(encoder_scales);
    if (going_on.size() < 2) return;
    seen.there_over_back = going_on[0] / going_on[1];
    seen.play_deg = Mean(going_on) - Mean(after_turn);
  }

  static double Mean(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }

  // Within which a gyro's nominal scale (MPU-6050: 3 %) and its alignment are right.
  static constexpr double kScaleKnown = 0.05;

  const std::vector<config::AxisConfig>& axes_;
  const Measurements& measured_;
  Seen seen_;
};

}  // namespace

std::int64_t Value(const config::EncoderMap& map, config::WordOrder order, const Words& words) {
  return map.words == 1 ? words[0] : config::FromWords(words[0], words[1], order);
}

// Values beyond the range of the map wrap where their registers do.
std::int64_t Step(const config::EncoderMap& map, config::WordOrder order, const Words& before,
                  const Words& after) {
  const auto from = static_cast<std::uint64_t>(Value(map, order, before));
  const auto to = static_cast<std::uint64_t>(Value(map, order, after));
  const bool within = from < map.range_counts && to < map.range_counts;
  return config::WrappedStep(from, to,
                             within ? map.range_counts : std::uint64_t{1} << (16 * map.words));
}

std::optional<double> LikelyCounts(double about) {
  // The gyro's scale is known to 3 %.
  constexpr double kNear = 0.04;
  const double decade = std::pow(10.0, std::floor(std::log10(about)));
  std::vector<double> usual = {std::exp2(std::round(std::log2(about)))};
  for (const double digits : {1.0, 2.0, 2.5, 3.6, 5.0, 7.2, 9.0, 10.0})
    usual.push_back(digits * decade);
  std::optional<double> likely;
  for (const double counts : usual) {
    if (std::fabs(about / counts - 1.0) > kNear || counts == likely) continue;
    if (likely) return std::nullopt;
    likely = counts;
  }
  return likely;
}

std::uint64_t RangeWith(const config::EncoderMap& map, double counts_per_turn) {
  const double turns = static_cast<double>(map.range_counts) / map.counts_per_turn;
  const double most = std::exp2(16.0 * map.words);
  return static_cast<std::uint64_t>(std::min(most, std::round(turns * counts_per_turn)));
}

Seen LookAt(const std::vector<config::AxisConfig>& axes, const Measurements& measured) {
  return Looking(axes, measured).Look();
}

}  // namespace gyrobench::commission
