// The narrow interface of what switches fans and heaters.
#pragma once

#include <string>

namespace gyrobench::drivers {

// Outputs go by what they switch: "fan", "heater". Calls throw DeviceError and belong to the thread
// of the bus.
class Relays {
 public:
  virtual ~Relays() = default;
  // Switches every output off.
  virtual void Open() = 0;
  // Switches, reads back, and tries again where nothing answers. Throws LimitError for an output
  // that the configuration does not name.
  virtual void Switch(const std::string& output, bool on) = 0;
  // DeviceError also where an output is not as it was switched last (the unit was restarted,
  // somebody else writes to it).
  virtual void Check() = 0;
};

}  // namespace gyrobench::drivers
