// The narrow interface of what switches fans and heaters.
#pragma once

#include <map>
#include <string>

namespace gyrobench::drivers {

// Outputs go by what they switch: "fan", "heater". Calls throw DeviceError and belong to the thread
// of the bus.
class Relays {
 public:
  virtual ~Relays() = default;
  // Switches every output off, whatever it was left with.
  virtual void Open() = 0;
  // Switches, and reads back what was switched. Throws LimitError for an output that the
  // configuration does not name.
  virtual void Switch(const std::string& output, bool on) = 0;
  // Which are on.
  virtual std::map<std::string, bool> Read() = 0;
};

}  // namespace gyrobench::drivers
