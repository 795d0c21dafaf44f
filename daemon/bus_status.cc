#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/clock.h"
#include "base/json_text.h"
#include "config/bus_load.h"
#include "daemon/control_api.h"

namespace gyrobench::daemon {
namespace {

using drivers::LineFigures;
using drivers::UnitFigures;
using nlohmann::json;

// null where no time has passed yet.
json Share(Utime busy_us, Utime span_us) {
  if (span_us <= 0) return nullptr;
  return static_cast<double>(busy_us) / static_cast<double>(span_us);
}

json ToJson(const UnitFigures& unit, Utime span_us) {
  return {{"device", unit.device},
          {"unit", unit.unit},
          {"transactions", unit.transactions},
          {"retries", unit.retries},
          {"given_up", unit.given_up},
          {"silent", unit.silent},
          {"unreadable", unit.unreadable},
          {"refused", unit.refused},
          {"line_lost", unit.line_lost},
          {"load", Share(unit.busy_us, span_us)},
          {"latency_median_s", Number(unit.latencies.Quantile_s(0.5))},
          {"latency_99_s", Number(unit.latencies.Quantile_s(0.99))}};
}

json SpanJson(const std::vector<UnitFigures>& units, Utime span_us) {
  json list = json::array();
  Utime busy_us = 0;
  for (const UnitFigures& unit : units) {
    list.push_back(ToJson(unit, span_us));
    busy_us += unit.busy_us;
  }
  return {{"seconds", ToSeconds(span_us)}, {"load", Share(busy_us, span_us)}, {"units", list}};
}

// null where the wire's time is not ours to know.
json ExpectedLoad(const config::StandConfig& stand, const std::string& name) {
  const auto bus = std::ranges::find(stand.buses, name, &config::BusConfig::name);
  if (bus == stand.buses.end()) return nullptr;
  const std::vector<config::DeviceLoad> loads = config::BusLoad(stand, *bus);
  if (loads.empty()) return nullptr;
  double sum = 0.0;
  for (const config::DeviceLoad& load : loads) sum += load.share;
  return sum;
}

}  // namespace

json BusStatus(const config::StandConfig& stand, const std::vector<LineFigures>& lines) {
  json buses = json::array();
  for (const LineFigures& line : lines) {
    json bus = {{"name", line.bus},
                {"line", line.description},
                {"expected_load", ExpectedLoad(stand, line.bus)},
                {"all", SpanJson(line.all, line.utime_now - line.utime_begin)},
                {"recent", SpanJson(line.recent, line.utime_now - line.utime_recent)}};
    buses.push_back(std::move(bus));
  }
  return {{"buses", std::move(buses)}};
}

}  // namespace gyrobench::daemon
