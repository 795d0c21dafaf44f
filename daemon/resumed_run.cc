#include "daemon/resumed_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "daemon/run_control.h"
#include "daemon/run_record.h"
#include "recording/event_log.h"
#include "recording/message_decoder.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

// Two estimates of the moment at which the unit was switched on: what its tick and a bus are off.
constexpr double kPowerOnTolerance_s = 5.0;
constexpr double kPowerOnTolerance = 0.005;

// One whose description cannot be read is none: it is told of at the daemon's start.
bool IsInterrupted(const recording::RunDirectory& run) try {
  if (!std::filesystem::exists(run.RunJson())) return false;
  const json description = run.ReadRun();
  return description.is_object() && description.value("outcome", "") == kInterruptedOutcome;
} catch (const std::exception&) {
  return false;
}

recording::RunDirectory FindInterrupted(const std::filesystem::path& records,
                                        const std::string& run_id) {
  std::vector<std::string> interrupted;
  std::optional<recording::RunDirectory> last;
  for (const recording::RunDirectory& run : recording::ListRuns(records)) {
    if (run.run_id() == run_id) return run;
    if (!IsInterrupted(run)) continue;
    interrupted.push_back(run.run_id());
    last = run;
  }
  if (run_id == "latest") {
    if (last) return *std::move(last);
    throw StateError(fmt::format("there is no run in {} that was interrupted", records.string()));
  }
  throw Error(
      fmt::format("there is no run '{}' in {}; interrupted were: {}", run_id, records.string(),
                  interrupted.empty() ? "none" : fmt::format("{}", fmt::join(interrupted, ", "))));
}

void RequireInterrupted(const std::string& run_id, const json& description) {
  const std::string outcome = description.value("outcome", "");
  if (outcome != kInterruptedOutcome) {
    throw StateError(fmt::format(
        "run {} is '{}': only a run whose daemon ended with it (interrupted) can be taken up",
        run_id, outcome));
  }
  if (!description.value(kAcknowledgedKey, false)) {
    throw StateError(fmt::format(
        "run {} was interrupted, and nobody has said that he has looked at the stand: gyrobench "
        "reset",
        run_id));
  }
  if (description.contains(recording::kResumedByKey)) {
    throw StateError(fmt::format("run {} was taken up already, by run {}", run_id,
                                 description[recording::kResumedByKey].get<std::string>()));
  }
}

std::map<std::string, double> AnglesOf(const FinishedCommand& command) {
  return command.outcome.at("angles_deg").get<std::map<std::string, double>>();
}

// A turn is measured from rest to rest: one that no rest followed is made again.
bool IsRest(const std::string& command) {
  return command.starts_with("rest ") || command.starts_with("soak ");
}
bool IsMotion(const std::string& command) {
  return command.starts_with("turn ") || command.starts_with("swing ");
}

// The log up to its last rest that was over.
void ReadJournal(ResumedRun& run) {
  if (!std::filesystem::exists(run.from.EventLog())) return;
  recording::EventLogReader reader(run.from.EventLog());
  recording::LogEvent event;
  run_t message{};
  int segments = 0;
  std::vector<FinishedCommand> behind_rest;  // not in the journal yet
  bool moved = false;                        // in one of them
  while (reader.Next(event)) {
    run.end = std::max(run.end, event.utime);
    if (!event.channel.ends_with(Reflection<run_t>::kSuffix)) continue;
    if (!recording::DecodeSound(event.data, message) || message.run_id != run.from.run_id())
      continue;
    if (message.event == run_t::SEGMENT_END) segments = message.segments_done;
    if (message.event != run_t::COMMAND) continue;
    if (!reader.damage().empty()) break;
    behind_rest.push_back({message.text, json::parse(message.outcome)});
    moved = !IsRest(message.text) && (moved || IsMotion(message.text));
    if (moved) continue;
    std::ranges::move(behind_rest, std::back_inserter(run.journal));
    behind_rest.clear();
    run.last_event = event.number;
    run.last = event.utime;
    run.segments_done = segments;
  }
}

const json& Part(const json& stand, const char* key) {
  static const json nothing;
  const auto found = stand.find(key);
  return found == stand.end() ? nothing : *found;
}

bool IsMeasured(const run_t& message) {
  switch (message.event) {
    case run_t::START:
    case run_t::SEGMENT_BEGIN:
    case run_t::SEGMENT_END:
    case run_t::QUESTION:
    case run_t::ANSWER:
    case run_t::PAUSE:
    case run_t::RESUME:
    case run_t::SUSPEND:
    case run_t::CONTINUE:
    case run_t::COMMAND:
    case run_t::TAKEN_UP:
    case run_t::OTHER_POWER_ON:
      return true;
    default:
      return false;  // what is said again, or was a result
  }
}

template <typename Message>
bool Decoded(const recording::LogEvent& event, AnyMessage& message) {
  if (!event.channel.ends_with(Reflection<Message>::kSuffix)) return false;
  if (!std::holds_alternative<Message>(message)) message = Message{};
  return recording::DecodeSound(event.data, std::get<Message>(message));
}

class Messages {
 public:
  Messages(const ResumedRun& run, bool same_power_on)
      : reader_(run.from.EventLog()),
        run_id_(run.from.run_id()),
        start_(run.start),
        last_event_(run.last_event),
        last_(run.last),
        marks_{run_t::TAKEN_UP} {
    if (!same_power_on) marks_.push_back(std::int8_t{run_t::OTHER_POWER_ON});
  }

  bool Next(AnyMessage& message) {
    recording::LogEvent event;
    while (!ended_ && reader_.Next(event)) {
      ended_ = event.number >= last_event_;
      if (IsWanted(event, message)) return true;
    }
    if (next_mark_ == marks_.size()) return false;
    run_t mark{};
    mark.utime = last_;
    mark.event = marks_[next_mark_++];
    mark.text = mark.event == run_t::OTHER_POWER_ON
                    ? "the gyro was switched off and on since"
                    : "run " + run_id_ + " was interrupted; what comes before was measured by it";
    message = mark;
    return true;
  }

 private:
  bool IsWanted(const recording::LogEvent& event, AnyMessage& message) const {
    if (Decoded<gyro_t>(event, message)) {
      auto& block = std::get<gyro_t>(message);
      // The ticks of another daemon count from another begin: no pairs for the comparison of
      // clocks.
      block.tick_rate_hz = 0.0;
      return block.run_id == run_id_ && block.utime >= start_;
    }
    if (Decoded<angle_t>(event, message)) {
      const auto& angle = std::get<angle_t>(message);
      return angle.run_id == run_id_ && angle.utime >= start_;
    }
    if (!Decoded<run_t>(event, message)) return false;
    const auto& course = std::get<run_t>(message);
    return course.run_id == run_id_ && IsMeasured(course);
  }

  recording::EventLogReader reader_;
  const std::string run_id_;
  const Utime start_;
  const std::int64_t last_event_;
  const Utime last_;
  std::vector<std::int8_t> marks_;
  std::size_t next_mark_ = 0;
  bool ended_ = false;
};

}  // namespace

ResumedRun ReadInterrupted(const std::filesystem::path& records, const std::string& run_id) {
  const recording::RunDirectory from = FindInterrupted(records, run_id);
  json description = from.ReadRun();
  RequireInterrupted(from.run_id(), description);
  ResumedRun run{.from = from, .description = std::move(description)};
  try {
    run.info = recording::MeasurementInfoFromJson(run.description.at(recording::kMeasurementKey));
    run.parameters = ParametersFrom(run.description.at("parameters"));
    run.start = run.description.at(recording::kStartUtimeKey);
    ReadJournal(run);
    if (!run.journal.empty()) {
      run.angles_deg = AnglesOf(run.journal.back());
      run.begin_angles_deg = AnglesOf(run.journal.front());
    }
  } catch (const json::exception& error) {
    throw DataError(fmt::format("run {} cannot be taken up, its record is damaged: {}",
                                from.run_id(), error.what()));
  }
  return run;
}

void RequireSame(const ResumedRun& run, const procedures::Procedure& procedure,
                 const config::StandConfig& stand, const MeasurementInfo& now) {
  const std::string& run_id = run.from.run_id();
  const auto refuse = [&run_id](const std::string& why) {
    throw Error(fmt::format("run {} cannot be taken up: {}; run it anew", run_id, why));
  };
  const std::string& name = procedure.info().name;
  if (!procedure.info().resumable) {
    refuse(
        fmt::format("what {} measures depends on what went on without a break before (its script "
                    "does not say resumable = true)",
                    name));
  }
  if (run.description.value("script", "") != procedure.source())
    refuse("the script of " + name + " is not the one that it ran");
  if (run.journal.size() < 2) refuse("none of its commands was over");
  for (const FinishedCommand& command : run.journal) {
    if (command.command.starts_with(kNotTakenUp))
      refuse("it had switched an output or chosen by what it had measured");
  }
  const json then = run.description.value("stand", json::object());
  const json stand_now = config::ToJson(stand);
  for (const char* key : {"axis", "gyro", "geometry", "reference"}) {
    if (Part(then, key) != Part(stand_now, key))
      refuse(fmt::format("the stand file says something else of '{}' than it did then", key));
  }
  if (run.info.sensor != now.sensor)
    refuse(fmt::format("the sensor is {}, expected {}", now.sensor, run.info.sensor));
}

void DescribeResumption(json& run, const ResumedRun& resumed, const std::string& run_id) {
  run[recording::kResumedFromKey] = resumed.from.run_id();
  json earlier = resumed.description;
  earlier[recording::kResumedByKey] = run_id;
  resumed.from.WriteRun(earlier);
}

bool IsSamePowerOn(const ResumedRun& run, const MeasurementInfo& now, bool virtual_stand) {
  if (virtual_stand || run.info.power_on.empty() || now.power_on.empty()) return false;
  // The name: moment, sensor, count of starts.
  const auto start_of = [](const std::string& name) { return name.substr(name.find(',') + 1); };
  if (start_of(run.info.power_on) != start_of(now.power_on)) return false;
  if (!run.info.power_on_utime || !now.power_on_utime) return false;
  const double apart_s = ToSeconds(*now.power_on_utime - *run.info.power_on_utime);
  const double age_s = ToSeconds(run.end - *run.info.power_on_utime);
  return std::abs(apart_s) <= kPowerOnTolerance_s + kPowerOnTolerance * std::abs(age_s);
}

MeasurementInfo ContinuedInfo(const ResumedRun& run, const MeasurementInfo& now,
                              bool same_power_on) {
  MeasurementInfo info = now;
  info.power_on_utime = run.info.power_on_utime;
  info.power_on = same_power_on ? run.info.power_on : "";
  return info;
}

std::function<bool(AnyMessage&)> MessagesBefore(const ResumedRun& run, bool same_power_on) {
  auto messages = std::make_shared<Messages>(run, same_power_on);
  return [messages](AnyMessage& message) { return messages->Next(message); };
}

}  // namespace gyrobench::daemon
