// What the moves of each drive come to: how far its table turned, and which encoder followed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "commission/measurements.h"
#include "config/stand_config.h"

namespace gyrobench::commission {

// What registers hold, read in an order of their words.
std::int64_t Value(const config::EncoderMap& map, config::WordOrder order, const Words& words);
// From one value to the next, the shorter way round [counts].
std::int64_t Step(const config::EncoderMap& map, config::WordOrder order, const Words& before,
                  const Words& after);
inline config::WordOrder Other(config::WordOrder order) {
  return order == config::WordOrder::kHighFirst ? config::WordOrder::kLowFirst
                                                : config::WordOrder::kHighFirst;
}
// The number of counts a turn, of those that are usual, that is within the gyro's scale of `about`:
// a power of two, or a round number. None where there is no such one, or more than one.
std::optional<double> LikelyCounts(double about);
// The values of its range, with as many turns as before.
std::uint64_t RangeWith(const config::EncoderMap& map, double counts_per_turn);

// Of one encoder.
struct EncoderSeen {
  std::optional<std::size_t> drive = {};  // that turns it; none where it stood still
  config::WordOrder word_order = config::WordOrder::kHighFirst;
  // Its angle, without its sign, over what was commanded of the drive times the drive's scale:
  // negative where it counts the other way.
  double ratio = 0.0;
  double counts_per_turn = 0.0;  // that it has
  bool counts_known = true;      // else they are what the gyro makes of them, to a few percent
  std::int64_t at_mark = 0;      // its value, with the axes at their marks
};

struct DriveSeen {
  double scale = 0.0;     // the table's angle, by the gyro, over the commanded one; above 0
  double turn_deg = 0.0;  // of the table in one of the large moves
  std::optional<std::size_t> encoder = {};
  // Scale by the encoder, with the counts that it has: in moves that went on as the one before.
  std::optional<double> encoder_scale = {};
  // Of a move after one the other way, how much less the table turned [deg].
  std::optional<double> play_deg = {};
  // Where the table, and the encoder, ended beside where they began, after moves there and back.
  double table_off_deg = 0.0, encoder_off_deg = 0.0;
  // The encoder's turns one way over those the other way.
  double there_over_back = 1.0;
};

struct Seen {
  std::vector<DriveSeen> drives;
  std::vector<EncoderSeen> encoders;
  std::vector<const Move*> with_direction;  // that turned enough to have one
};

// `axes` of the stand file. Throws DataError where the gyro felt nothing of a drive.
Seen LookAt(const std::vector<config::AxisConfig>& axes, const Measurements& measured);

}  // namespace gyrobench::commission
