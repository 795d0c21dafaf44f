#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "gyrobench/angle_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "recording/defect_counter.h"
#include "recording/event_log.h"
#include "recording/measurement_files.h"
#include "recording/message_decoder.h"
#include "recording/plausible.h"
#include "recording/replay.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

namespace {

// A message's own time and the log's time stamp are of one clock and one moment: the same number
// where the daemon has written the log, and near to each other where another logger has.
class Stamps {
 public:
  // Whether these two can belong to one event, by what the log has shown so far.
  bool Belong(Utime message, Utime event) {
    if (message == event) {
      equal_ = std::min(equal_ + 1, kMost);
      return true;
    }
    if (equal_ == kMost) return false;
    equal_ = 0;
    return std::abs(message - event) <= kMaxDifference;
  }

 private:
  static constexpr Utime kMaxDifference = 60 * kMicrosecondsPerSecond;
  static constexpr int kMost = 8;  // on end are no accident
  int equal_ = 0;
};
constexpr int kEventsPerProgress = 1000;

// The messages of a log that make up a measurement, each decoded into memory that is used again.
class LogMessages {
 public:
  explicit LogMessages(const fs::path& log) : reader_(log), bad_(counter_.Add("damaged_message")) {}

  // Calls the function of the message's type for each message to the end of the log.
  template <typename OnGyro, typename OnAngle, typename OnRun>
  void ForEach(const OnGyro& on_gyro, const OnAngle& on_angle, const OnRun& on_run,
               const ReplayProgress& progress = {}) {
    LogEvent event;
    for (int i = 1; reader_.Next(event); ++i) {
      if (event.channel.ends_with("_GYRO")) {
        Dispatch(event, gyro_, on_gyro);
      } else if (event.channel.ends_with("_ANGLE")) {
        Dispatch(event, angle_, on_angle);
      } else if (event.channel.ends_with("_RUN")) {
        Dispatch(event, run_, on_run);
      }
      if (progress && i % kEventsPerProgress == 0) progress(reader_.fraction());
    }
  }
  // `origin`: of the measurement's time.
  std::vector<Defect> defects(Utime origin) const {
    std::vector<Defect> found;
    for (const LogDamage& damage : reader_.damage()) {
      Defect& defect = found.emplace_back(damage);
      if (IsPlausible(damage.after)) defect.first_t_s = ToSeconds(damage.after - origin);
    }
    for (const Defect& defect : counter_.Found()) found.push_back(defect);
    return found;
  }

 private:
  template <typename Message, typename Function>
  void Dispatch(const LogEvent& event, Message& message, const Function& function) {
    if (DecodeSound(event.data, message) && IsPlausible(message.utime) &&
        IsPlausible(event.utime) && stamps_.Belong(message.utime, event.utime)) {
      function(message);
      return;
    }
    counter_.Count(bad_, kMissing, [&event] {
      return fmt::format("byte {}, channel {}", event.byte, event.channel);
    });
  }

  EventLogReader reader_;
  DefectCounter counter_;
  std::size_t bad_;
  Stamps stamps_;
  gyro_t gyro_;
  angle_t angle_;
  run_t run_;
};

// What run.json says of the measurement, or what the messages do.
struct RunFacts {
  MeasurementInfo info;
  std::string run_id;
  std::optional<Utime> start;
  bool has_measurement = false;
  std::vector<Defect> defects;
};

Utime StartFrom(const nlohmann::json& value) {
  const auto start = value.get<Utime>();
  if (IsPlausible(start)) return start;
  throw DataError(fmt::format("{} = {}: expected microseconds since the epoch, at most {}",
                              kStartUtimeKey, start, kLatestUtime));
}

// No run begins before its sensor is on.
void CheckPowerOn(const RunFacts& facts) {
  if (!facts.info.power_on_utime) return;
  const Utime power_on = *facts.info.power_on_utime, latest = facts.start.value_or(kLatestUtime);
  if (IsPlausible(power_on) && power_on <= latest) return;
  throw DataError(fmt::format(
      "{}.power_on_utime = {}: expected microseconds since the epoch, at most {} ({})",
      kMeasurementKey, power_on, latest,
      facts.start ? fmt::format("{} of the run", kStartUtimeKey) : "what a clock can give"));
}

void ReadRunJson(const fs::path& file, RunFacts& facts) {
  const nlohmann::json run = ReadJson(file);
  const auto id = run.find(kRunIdKey);
  if (id != run.end() && id->is_string()) facts.run_id = id->get<std::string>();
  const auto start = run.find(kStartUtimeKey);
  if (start != run.end() && start->is_number_integer()) facts.start = StartFrom(*start);
  const auto measurement = run.find(kMeasurementKey);
  if (measurement == run.end()) return;
  facts.info = MeasurementInfoFromJson(*measurement);
  CheckPowerOn(facts);
  facts.has_measurement = true;
}

RunFacts FactsFromJson(const fs::path& file) {
  RunFacts facts;
  if (!fs::exists(file)) return facts;
  try {
    ReadRunJson(file, facts);
  } catch (const DataError& error) {
    facts = {};
    facts.defects.push_back({"damaged_run_json", 1, kMissing, error.what()});
  }
  return facts;
}

// The first run whose beginning the log holds, or the one that run.json names.
void FindStart(const fs::path& log, RunFacts& facts) {
  bool found = false;
  LogMessages(log).ForEach([](const gyro_t&) {}, [](const angle_t&) {},
                           [&](const run_t& message) {
                             const bool ours =
                                 facts.run_id.empty() || message.run_id == facts.run_id;
                             if (found || !ours || message.event != run_t::START) return;
                             found = true;
                             facts.run_id = message.run_id;
                             if (!facts.start) facts.start = message.utime;
                             if (!facts.has_measurement)
                               facts.info.notes["procedure"] = message.procedure;
                           });
}

// What the samples of the run say of the measurement; the time of the first one where no start is
// known.
void CompleteFromSamples(const fs::path& log, RunFacts& facts) {
  MeasurementInfo info = facts.info;
  std::optional<Utime> earliest;
  const auto is_ours = [&](const std::string& run_id, Utime utime) {
    if (facts.run_id.empty()) facts.run_id = run_id;
    const bool ours = !run_id.empty() && run_id == facts.run_id;
    if (ours) earliest = std::min(earliest.value_or(utime), utime);
    return ours;
  };
  LogMessages(log).ForEach(
      [&](const gyro_t& message) {
        const bool has_time = message.n > 0 && IsPlausible(message.sample_utime.front());
        const Utime first = has_time ? message.sample_utime.front() : message.utime;
        if (!is_ours(message.run_id, first)) return;
        info.gyro_present = {true, true, true};
        info.accel_present.fill(IsFactor(message.accel_lsb_per_g));
        info.temperature_present = true;
        if (IsFactor(message.gyro_lsb_per_deg_s))
          info.gyro_units_per_deg_s = message.gyro_lsb_per_deg_s;
      },
      [&](const angle_t& message) {
        if (!is_ours(message.run_id, message.utime) || message.axis < 0 || message.axis > 2) return;
        info.reference = ReferenceKind::kStandAngles;
        info.stand_axis_present.at(static_cast<std::size_t>(message.axis)) = true;
      },
      [](const run_t&) {});
  if (!facts.start) facts.start = earliest;
  if (!facts.has_measurement) facts.info = info;
}

}  // namespace

void ReplayRun(const fs::path& record, MeasurementSink& sink, const ReplayProgress& progress) {
  const MeasurementFiles on_disk = FilesOfMeasurement(record);
  // A log whose very beginning is damaged is still one, when it is asked for as one.
  const fs::path log = !on_disk.is_record      ? record
                       : on_disk.files.empty() ? fs::path()
                                               : on_disk.files.front();
  if (log.empty() || log.filename() == kRunJsonName) {
    throw DataError(fmt::format("{}: no record: expected the event log {} in it", record.string(),
                                kEventLogName));
  }
  RunFacts facts = FactsFromJson(on_disk.folder / kRunJsonName);
  if (!facts.start || !facts.has_measurement) {
    FindStart(log, facts);
    CompleteFromSamples(log, facts);
  }
  if (!facts.start) {
    throw DataError(
        fmt::format("{}: holds no readable message of a run: expected channels that end in "
                    "_GYRO, _ANGLE, _RUN",
                    log.string()));
  }
  if (facts.info.source.empty()) facts.info.source = facts.run_id;
  MessageDecoder decoder(facts.info, *facts.start, sink, facts.run_id);
  LogMessages messages(log);
  messages.ForEach([&](const gyro_t& message) { decoder.Gyro(message); },
                   [&](const angle_t& message) { decoder.Angle(message); },
                   [&](const run_t& message) { decoder.Run(message); }, progress);
  for (const Defect& defect : facts.defects) sink.OnDefect(defect);
  const Utime origin = facts.info.power_on_utime.value_or(*facts.start);
  for (const Defect& defect : messages.defects(origin)) sink.OnDefect(defect);
  if (progress) progress(1.0);
}

}  // namespace gyrobench::recording
