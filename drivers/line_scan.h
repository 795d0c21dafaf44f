// What answers on a Modbus line, unit by unit, held against what the stand file says of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"
#include "drivers/identify.h"

namespace gyrobench::drivers {

// How a serial line is set. Of no meaning for Modbus TCP.
struct LineSetting {
  int baud = 115200;
  char parity = 'N';
  int stop_bits = 1;
  bool operator==(const LineSetting&) const = default;
};

// "115200 baud 8N1"
std::string Describe(const LineSetting& setting);

// A unit that answered.
struct FoundUnit {
  int unit = 0;
  LineSetting setting;
  UnitIdentity identity;
  std::string expected = {};  // device of the stand file with this number: "axis.inner drive"
  bool as_expected = false;   // it is one of that kind; false where the stand file has none
};

// A device of the stand file that did not answer.
struct MissingUnit {
  int unit = 0;
  std::string device;
};

struct LineReport {
  config::BusConfig bus;
  int asked = 0;  // unit numbers
  std::vector<FoundUnit> found;
  std::vector<MissingUnit> missing;
  // Each unit number that was asked gave replies that are none: the line itself is not in order.
  bool all_unreadable = false;

  // Everything that the stand file has on this line answers, as what it is to be.
  bool IsAsExpected() const;
};

struct ScanOptions {
  std::vector<int> units;  // to be asked at each of the settings
  // The first one to begin with. Empty: that of the stand file, and for the devices of the stand
  // file that do not answer there the usual ones (9600 to 1000000 baud; 8N1, 8E1, 8O1, 8N2).
  std::vector<LineSetting> settings;
};

// Of 0 to 1, and what is asked at the moment.
using ScanProgress = std::function<void(double fraction, const std::string& doing)>;

// Reads only. One unit takes a tenth of a second where nothing answers, and `participant` waits as
// long. Throws NoAnswer where the line cannot be opened, as while a daemon has it, and ConfigError
// for a rate that cannot be set.
LineReport ScanLine(const config::StandConfig& stand, const config::BusConfig& bus,
                    const ScanOptions& options, Clock& clock, Clock::Participant& participant,
                    const ScanProgress& progress);

}  // namespace gyrobench::drivers
