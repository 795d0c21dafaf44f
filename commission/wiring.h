// How a stand is really wired, told from small moves, and what of its stand file is wrong.
#pragma once

#include <string>
#include <vector>

#include "commission/measurements.h"
#include "config/stand_config.h"

namespace gyrobench::commission {

// A line of the stand file: `value` is to stand there in place of `was`, as TOML writes them.
struct Correction {
  std::string key;  // dotted: axis.inner.encoder.sign
  std::string value;
  std::string was;
};

// Something that is not as the stand file says.
struct Finding {
  std::string what;    // a few words: "exchanged encoders"
  std::string reason;  // a sentence with the figures that tell it, and what to do where no line can
  std::vector<Correction> corrections = {};  // none: nothing in the stand file mends it
};

struct Wiring {
  std::vector<Finding> findings;
  // What was found as it should be, and how large: a sentence each.
  std::vector<std::string> notes;
};

// The simplest wiring that explains what was seen: of all exchanges of drives, senses of rotation
// and mountings that fit the gyro's directions, the one with the fewest mistakes; then encoders by
// which of them follows which axis, their scale, word order and sense, and the gear ratios.
// Directions tell the axes apart since turning one changes, in the sensor frame, the direction of
// those outside it. `stand`: as it was when the moves were made, the axes at their marks at first.
// Throws DataError that names the axis where the moves do not tell what turned.
Wiring FindWiring(const config::StandConfig& stand, const Measurements& measured);

}  // namespace gyrobench::commission
