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

// Of the stand file.
LineSetting SettingOf(const config::BusConfig& bus);
// "115200 baud 8N1"
std::string Describe(const LineSetting& setting);

// A unit that answered.
struct FoundUnit {
  int unit = 0;
  LineSetting setting;
  UnitIdentity identity;
  std::string expected = {};  // device of the stand file with this number: "axis.inner drive"
  bool as_expected = false;   // it is that device, as the daemon wants it, at the line's setting
};

// A device of the stand file that did not answer, or was not asked.
struct MissingUnit {
  int unit = 0;
  std::string device;
  UnitKind kind = UnitKind::kUnknown;
};

struct LineReport {
  config::BusConfig bus;
  int asked = 0;         // unit numbers
  bool stopped = false;  // by whoever was told of the progress
  std::vector<FoundUnit> found;
  std::vector<MissingUnit> missing;    // asked, and silent
  std::vector<MissingUnit> not_asked;  // whether they answer is not known
  // Each unit number that was asked gave replies that are none: the line itself is not in order.
  bool all_unreadable = false;
  // Each unit number that was asked gave an answer: whoever answers does not look at the number.
  bool all_answer = false;
  std::string error = {};  // why the line could not be asked, or not to the end; empty: it was

  // Whether a setting is the line's own; of Modbus TCP any is.
  bool IsOwn(const LineSetting& setting) const;
  // It was asked to the end, and everything that was asked for and that the stand file has on this
  // line answers, as it is to.
  bool IsAsExpected() const;
};

struct ScanOptions {
  std::vector<int> units;  // to be asked at each of the settings
  // Empty: that of the stand file, and for its devices among the units that do not answer there the
  // usual ones (9600 to 1000000 baud; 8N1, 8E1, 8O1, 8N2).
  std::vector<LineSetting> settings;
};

// Of 0 to 1, and what is asked at the moment. Where it returns false nothing more is asked.
using ScanProgress = std::function<bool(double fraction, const std::string& doing)>;

// Reads only. Where nothing answers a unit takes twice the bus's response timeout, and
// `participant` waits as long. A line that cannot be opened is told in the report. Throws
// ConfigError for a rate that cannot be set.
LineReport ScanLine(const config::StandConfig& stand, const config::BusConfig& bus,
                    const ScanOptions& options, Clock& clock, Clock::Participant& participant,
                    const ScanProgress& progress);

}  // namespace gyrobench::drivers
