#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "daemon/axis_unit.h"
#include "daemon/run_record.h"
#include "gyrobench/reflection.hpp"
#include "recording/event_log.h"
#include "recording/message_decoder.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {
namespace {

// What its log says last.
InterruptedRun ReadLast(const recording::RunDirectory& run, const nlohmann::json& description) {
  InterruptedRun found{run, description.value("procedure", ""), 0, {}};
  if (!std::filesystem::exists(run.EventLog())) return found;
  recording::EventLogReader reader(run.EventLog());
  recording::LogEvent event;
  angle_t angle{};
  while (reader.Next(event)) {
    found.last = std::max(found.last, event.utime);
    if (!event.channel.ends_with(Reflection<angle_t>::kSuffix)) continue;
    if (!recording::DecodeSound(event.data, angle)) continue;
    for (const char* name : {"outer", "middle", "inner"}) {
      if (AxisNumber(name) == angle.axis) found.angle_deg[name] = angle.angle_deg;
    }
  }
  return found;
}

// nullopt where it was closed by who began it, or is acknowledged.
std::optional<InterruptedRun> CloseIfInterrupted(const recording::RunDirectory& run) {
  if (!std::filesystem::exists(run.RunJson())) return std::nullopt;
  nlohmann::json description = run.ReadRun();
  if (!description.is_object()) return std::nullopt;
  const std::string outcome = description.value("outcome", "");
  if (outcome == kInterruptedOutcome && !description.value(kAcknowledgedKey, true)) {
    return ReadLast(run, description);
  }
  if (outcome != kRunningOutcome) return std::nullopt;
  InterruptedRun found = ReadLast(run, description);
  DescribeInterruption(description, found.last);
  run.WriteRun(description);
  return found;
}

std::string SinceThen(const config::AxisConfig& axis, double now_deg,
                      std::optional<double> then_deg) {
  if (!then_deg) return ", and the record does not say where it stood";
  const double moved_deg = now_deg - *then_deg;
  if (std::abs(moved_deg) <= axis.following_error_deg) return ", where the record left it";
  return fmt::format(
      " and was at {:.3f} deg when it was recorded last: it moved by {:.3f} deg since", *then_deg,
      moved_deg);
}

}  // namespace

std::vector<InterruptedRun> CloseInterruptedRuns(const std::filesystem::path& records) {
  std::vector<InterruptedRun> closed;
  try {
    for (const recording::RunDirectory& run : recording::ListRuns(records)) {
      try {
        if (auto interrupted = CloseIfInterrupted(run)) closed.push_back(*std::move(interrupted));
      } catch (const std::exception& error) {
        spdlog::warn("record {}: {}", run.run_id(), error.what());
      }
    }
  } catch (const DataError& error) {
    spdlog::warn("{}", error.what());
  }
  return closed;
}

void Acknowledge(const InterruptedRun& run) {
  try {
    nlohmann::json description = run.directory.ReadRun();
    description[kAcknowledgedKey] = true;
    run.directory.WriteRun(description);
  } catch (const std::exception& error) {
    spdlog::warn("record {}: {}", run.directory.run_id(), error.what());
  }
}

std::string DescribeInterruption(const InterruptedRun& run, const config::StandConfig& stand,
                                 const std::map<std::string, std::optional<double>>& now_deg) {
  std::string text = fmt::format(
      "run {} was on when the daemon before this one ended{}: its record is closed as interrupted, "
      "and holds what was measured until then",
      run.directory.run_id(), run.last == 0 ? "" : " (last event " + IsoTime(run.last) + ")");
  if (stand.virtual_stand) {
    text +=
        ". The virtual stand begins anew with each daemon: where its axes stand now says nothing "
        "of where that run left them";
  }
  for (const config::AxisConfig& axis : stand.axes) {
    const auto now = now_deg.find(axis.name);
    const auto then = run.angle_deg.find(axis.name);
    const bool known = now != now_deg.end() && now->second;
    text += fmt::format(". axis.{} {}", axis.name,
                        known ? fmt::format("stands at {:.3f} deg", *now->second)
                              : std::string("does not say where it is"));
    if (known && !stand.virtual_stand)
      text += SinceThen(axis, *now->second,
                        then == run.angle_deg.end() ? std::nullopt : std::optional(then->second));
  }
  return text;
}

}  // namespace gyrobench::daemon
