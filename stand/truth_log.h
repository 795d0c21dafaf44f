// What really happened, for who judges a run afterwards.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "base/clock.h"
#include "stand/mechanics.h"

namespace gyrobench::stand {

// Lines `t_s,what,device,value` behind the line `# power-on at utime N`; t_s counts from there.
//   angle,<axis>,deg    of the table, where it is 0.01 deg away from the line before
//   move,<axis>,deg     the drive takes a move to this angle of its own count
//   stop,<axis>,0       the drive takes a stop, or is disabled
//   heater,relays,0|1
//   fault,<device>,amount   a fault of the scenario begins
// Nothing that acquires or analyses may read it. The file is complete up to the last line of
// another kind than `angle` even when the program is killed.
class TruthLog {
 public:
  // Throws ConfigError when the file cannot be made.
  TruthLog(const std::filesystem::path& file, Utime power_on);
  // Writes the angles up to `t_s`, forwards only.
  void Follow(double t_s, const std::array<AxisMechanics, 3>& axes);
  void Note(double t_s, std::string_view what, std::string_view device, double value);

 private:
  void Look(double t_s, const std::array<AxisMechanics, 3>& axes);
  void Write(double t_s, std::string_view what, std::string_view device, double value);

  std::ofstream out_;
  double t_s_ = 0.0;
  std::array<double, 3> written_deg_ = {};
  bool begun_ = false;
};

}  // namespace gyrobench::stand
