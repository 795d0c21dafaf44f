#include "daemon/run_record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "config/stand_config.h"
#include "procedures/engine/procedure.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {

using nlohmann::json;

std::string IsoTime(Utime utime) {
  const std::chrono::sys_time<std::chrono::milliseconds> time{
      std::chrono::milliseconds(utime / 1000)};
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", time);
}

json ToJson(const procedures::Parameters& parameters) {
  json object = json::object();
  for (const auto& [name, value] : parameters) {
    std::visit([&, &key = name](const auto& v) { object[key] = v; }, value);
  }
  return object;
}

procedures::Parameters ParametersFrom(const json& object) {
  procedures::Parameters parameters;
  for (const auto& [name, value] : object.items()) {
    if (value.is_boolean()) {
      parameters[name] = value.get<bool>();
    } else if (value.is_number()) {
      parameters[name] = value.get<double>();
    } else if (value.is_string()) {
      parameters[name] = value.get<std::string>();
    } else {
      throw Error("parameter '" + name + "' must be a number, a text or true/false");
    }
  }
  return parameters;
}

json DescribeRun(const std::string& run_id, const procedures::Procedure& procedure,
                 const procedures::Parameters& parameters, const config::StandConfig& stand,
                 const MeasurementInfo& info, Utime start) {
  return {{"format", "gyrobench.run/1"},
          {recording::kRunIdKey, run_id},
          {recording::kStartUtimeKey, start},
          {"started", IsoTime(start)},
          {"procedure", procedure.info().name},
          {"parameters", ToJson(parameters)},
          {"script", procedure.source()},
          {"measures", procedure.info().measures},
          {"stand", config::ToJson(stand)},
          {recording::kMeasurementKey, recording::ToJson(info)},
          {"version", kVersion},
          {"outcome", kRunningOutcome}};
}

namespace {

json ToJson(const commission::Wiring& wiring) {
  json findings = json::array();
  for (const commission::Finding& finding : wiring.findings) {
    json lines = json::array();
    for (const commission::Correction& line : finding.corrections)
      lines.push_back({{"key", line.key}, {"value", line.value}, {"was", line.was}});
    findings.push_back(
        {{"what", finding.what}, {"reason", finding.reason}, {"corrections", std::move(lines)}});
  }
  return {{"findings", std::move(findings)}, {"notes", wiring.notes}};
}

}  // namespace

void DescribeEnd(json& run, Outcome outcome, const std::string& message,
                 const std::vector<Fault>& failures, const LiveBench* bench, Utime end) {
  run["ended"] = IsoTime(end);
  run["end_utime"] = end;
  run["outcome"] = Name(outcome);
  run["message"] = message;
  json& failed = run["failures"] = json::array();
  for (const Fault& failure : failures) failed.push_back(ToJson(failure));
  json& list = run["limits"] = json::array();
  json& said = run[recording::kSaidKey] = json::array();
  if (bench == nullptr) return;
  if (bench->wiring()) run[recording::kWiringKey] = ToJson(*bench->wiring());
  for (const LiveBench::Said& one : bench->said())
    said.push_back({{"t_s", one.t_s}, {"text", one.text}});
  for (const procedures::LimitCheck& check : bench->limits()) {
    list.push_back({{"name", check.name},
                    {"value", check.value},
                    {"min", check.min},
                    {"max", check.max},
                    {"unit", check.unit},
                    {"passed", check.passed}});
  }
}

void DescribeInterruption(json& run, Utime last) {
  run["outcome"] = kInterruptedOutcome;
  run[kAcknowledgedKey] = false;
  run["message"] = "the daemon ended before the run did (killed, or without power)";
  run["failures"] = json::array();
  if (last == 0) return;
  run["ended"] = IsoTime(last);
  run["end_utime"] = last;
}

void DescribePowerOnAtEnd(json& run, const std::string& power_on) {
  json& name = run[recording::kMeasurementKey]["power_on"];
  if (name != power_on) name = "";
}

}  // namespace gyrobench::daemon
