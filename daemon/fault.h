// What broke the bench or a run: words for people, and fields for programs.
#pragma once

#include <exception>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/gyro.h"

namespace gyrobench::daemon {

// Of each device, for the report of a fault: two seconds of a reference that is read at 10 Hz.
inline constexpr std::size_t kLastSamples = 20;

// What was read last, oldest first.
struct LastSamples {
  struct Axis {
    std::string name;
    drivers::AxisState drive;
    std::vector<drivers::AngleReading> reference;
  };
  std::vector<Axis> axes;
  std::vector<drivers::GyroRawSample> gyro;
};

struct Fault {
  std::string source;  // axis.inner, encoder.inner, gyro, relays, record
  std::string message;
  DeviceFailure failure{};             // of the device, where one failed
  std::optional<ScriptPlace> place{};  // of the command that a run was at
  LastSamples samples{};               // up to the fault, where it is the stand's
  // What became of axes and outputs, a line each; of a fault within a run, at the run's end.
  std::vector<std::string> left{};
  bool may_pass = false;  // a device is silent, and may come back as it was
};

using FaultHandler = std::function<void(const Fault&)>;

// With the fields that the error has.
Fault FaultOf(const std::string& source, const std::exception& error);
// The same of the device that the error names; "device" where it names none.
Fault FaultOfDevice(const DeviceError& error);
// One more thing that went wrong by the same cause: its words are added where they are not there
// yet, and the fields of the first error that had any are kept.
void AddTo(Fault& fault, const std::exception& error);

inline std::string TextOf(const Fault& fault) { return WithSource(fault.source, fault.message); }
// Whether one device failed in the same way, at whatever it was asked.
bool HaveSameCause(const Fault& one, const Fault& other);

// {"source", "message", "device", "script", "last_samples", "left"}; device, script and samples are
// null where nothing is known.
nlohmann::json ToJson(const Fault& fault);
// {"name", "action", "code_kind", "code", "address"}; null where no device is named.
nlohmann::json ToJson(const DeviceFailure& failure);
// {"file", "line"}; null without a place.
nlohmann::json ToJson(const std::optional<ScriptPlace>& place);

// The bench is broken: thrown inside a run when a fault was reported.
class FaultError : public Error {
 public:
  explicit FaultError(Fault fault) : Error(TextOf(fault)), fault_(std::move(fault)) {}
  const Fault& fault() const { return fault_; }

 private:
  Fault fault_;
};

}  // namespace gyrobench::daemon
