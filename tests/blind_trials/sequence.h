// What the stand does during a recording: turns and rests, planned with their times.
#pragma once

#include <array>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "config/scenario.h"

namespace gyrobench::blind_trials {

// One command to a drive. Degrees of the table.
struct Turn {
  double start_s = 0.0;
  std::size_t axis = 2;  // StandAxis
  double target_deg = 0.0;
  double rate_deg_s = 0.0;
  double acceleration_deg_s2 = 0.0;
};

struct Sequence {
  std::vector<Turn> turns;  // in order of time, one after the other
  std::vector<SegmentMark> segments;
  std::vector<config::RoomScenario::Fan> fans;
  double duration_s = 0.0;
};

enum class SequenceKind {
  kFull,         // the full sequence of the catalogue's design
  kOneWay,       // z up, one speed, one way
  kBothWays,     // z up, one speed, both ways
  kThreeSpeeds,  // z up, three speeds, both ways
  kWarmUpOnly,   // z up, at rest
  kUpAndDown,    // z up, z down, turning both ways: of the Earth's rotation its vertical part shows
  kSixPoses,     // still with each axis up and down
  kElsewhere,    // all axes in tilted poses, at other rates than the full sequence
};

// The order of the speeds is drawn. `repeats` times the whole, one after the other.
Sequence MakeSequence(SequenceKind kind, std::mt19937_64& random, int repeats = 1);

}  // namespace gyrobench::blind_trials
