#include "daemon/fault.h"

#include <nlohmann/json.hpp>

#include "base/json_text.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

const char* Name(DeviceFailure::CodeKind kind) {
  switch (kind) {
    case DeviceFailure::CodeKind::kNone:
      return "";
    case DeviceFailure::CodeKind::kModbusException:
      return "modbus_exception";
    case DeviceFailure::CodeKind::kSystemError:
      return "errno";
    case DeviceFailure::CodeKind::kBadReply:
      return "bad_reply";
    case DeviceFailure::CodeKind::kAlarm:
      return "alarm";
  }
  return "";
}

json ToJson(const LastSamples::Axis& axis) {
  json reference = json::array();
  for (const drivers::AngleReading& reading : axis.reference) {
    reference.push_back({{"utime", reading.utime}, {"angle_deg", Number(reading.angle_deg)}});
  }
  return {{"axis", axis.name},
          {"drive",
           {{"utime", axis.drive.utime},
            {"commanded_deg", Number(axis.drive.commanded_deg)},
            {"enabled", axis.drive.enabled},
            {"moving", axis.drive.moving},
            {"alarm", axis.drive.alarm}}},
          {"reference", std::move(reference)}};
}

json ToJson(const LastSamples& samples) {
  if (samples.axes.empty() && samples.gyro.empty()) return nullptr;
  json object{{"axes", json::array()}, {"gyro", json::array()}};
  for (const LastSamples::Axis& axis : samples.axes) object["axes"].push_back(ToJson(axis));
  for (const drivers::GyroRawSample& sample : samples.gyro) {
    object["gyro"].push_back({{"utime", sample.utime},
                              {"gyro_lsb", sample.gyro_lsb},
                              {"accel_lsb", sample.accel_lsb},
                              {"temperature_degC", Number(sample.temperature_degC)}});
  }
  return object;
}

}  // namespace

void AddTo(Fault& fault, const std::exception& error) {
  const std::string what = error.what();
  if (fault.message.find(what) == std::string::npos)
    fault.message += (fault.message.empty() ? "" : "; ") + what;
  const auto* device = dynamic_cast<const DeviceError*>(&error);
  if (device != nullptr && fault.failure.device.empty()) fault.failure = device->failure();
  const auto* ours = dynamic_cast<const Error*>(&error);
  if (ours != nullptr && !fault.place) fault.place = ours->place();
}

bool HaveSameCause(const Fault& one, const Fault& other) {
  if (one.message == other.message) return true;
  const DeviceFailure &a = one.failure, &b = other.failure;
  return !a.device.empty() && a.device == b.device &&
         a.code_kind != DeviceFailure::CodeKind::kNone && a.code_kind == b.code_kind &&
         a.code == b.code;
}

Fault FaultOf(const std::string& source, const std::exception& error) {
  Fault fault{source, ""};
  AddTo(fault, error);
  return fault;
}

Fault FaultOfDevice(const DeviceError& error) {
  // "axis.inner drive" is known as axis.inner everywhere else.
  const std::string& device = error.failure().device;
  return FaultOf(device.empty() ? "device" : device.substr(0, device.find(' ')), error);
}

json ToJson(const DeviceFailure& failure) {
  if (failure.device.empty()) return nullptr;
  json object{{"name", failure.device},
              {"action", failure.action},
              {"code_kind", nullptr},
              {"code", nullptr},
              {"address", nullptr}};
  if (failure.code_kind != DeviceFailure::CodeKind::kNone) {
    object["code_kind"] = Name(failure.code_kind);
    object["code"] = failure.code;
  }
  if (failure.address) object["address"] = *failure.address;
  return object;
}

json ToJson(const std::optional<ScriptPlace>& place) {
  if (!place) return nullptr;
  return {{"file", place->file}, {"line", place->line}};
}

json ToJson(const Fault& fault) {
  return {{"source", fault.source},
          {"message", fault.message},
          {"device", ToJson(fault.failure)},
          {"script", ToJson(fault.place)},
          {"last_samples", ToJson(fault.samples)},
          {"left", fault.left}};
}

}  // namespace gyrobench::daemon
