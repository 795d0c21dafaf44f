#include "record_builder.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "gyrobench/angle_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "recording/event_log.h"
#include "recording/run_directory.h"
#include "sinks.h"

namespace gyrobench::recording {

namespace {

constexpr int kSamplesPerBlock = 10;
constexpr Utime kSampleInterval = 5'000;

class Log {
 public:
  Log(const std::filesystem::path& file, const RecordPlan& plan) : writer_(file), plan_(plan) {}

  template <typename Message>
  void Write(const std::string& suffix, const Message& message) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    writer_.Write(plan_.channel_prefix + suffix, message.utime, bytes.data(), bytes.size());
  }
  void Gyro(const std::string& run_id, int block) {
    gyro_t message;
    message.run_id = run_id;
    message.seq = block;
    message.tick_rate_hz = 250'000.0;
    message.boot_count = plan_.restart_at_block >= 0 && block >= plan_.restart_at_block ? 4 : 3;
    message.missed = 0;
    message.gyro_lsb_per_deg_s = 131.0;
    message.accel_lsb_per_g = 16384.0;
    message.n = kSamplesPerBlock;
    message.first_counter = 500 + block * kSamplesPerBlock;
    message.gyro_lsb.resize(3);
    message.accel_lsb.resize(3);
    for (int i = 0; i < kSamplesPerBlock; ++i) Sample(message, block * kSamplesPerBlock + i);
    message.utime = message.sample_utime.back() + 1'213;
    message.unit_tick = message.sample_tick.back() + 303;
    Write("_GYRO", message);
  }
  void Angle(int axis, Utime utime, double angle_deg) {
    angle_t message;
    message.utime = utime;
    message.run_id = plan_.run_id;
    message.seq = seq_++;
    message.axis = static_cast<std::int8_t>(axis);
    message.counts = std::llround(angle_deg * 1000.0);
    message.angle_deg = angle_deg;
    message.utime_request = utime - 700;
    message.utime_reply = utime + 900;
    Write("_ANGLE", message);
  }
  void Run(std::int8_t event, Utime utime, const std::string& name, Utime begin) {
    run_t message;
    message.utime = utime;
    message.run_id = plan_.run_id;
    message.seq = seq_++;
    message.event = event;
    message.procedure = "scale";
    message.segment_kind = "turn";
    message.segment_name = name;
    message.segment_begin_utime = begin;
    message.segments_done = 0;
    message.progress = 0.5;
    message.remaining_s = 12.0;
    Write("_RUN", message);
  }

 private:
  void Sample(gyro_t& message, int number) const {
    message.sample_utime.push_back(plan_.start + 2'011 + number * kSampleInterval + number % 3);
    message.sample_tick.push_back(100'000 + number * 1250);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int wave = (number * (7 + static_cast<int>(axis) * 4)) % 401 - 200;
      message.gyro_lsb[axis].push_back(
          static_cast<std::int16_t>(wave * 97 + static_cast<int>(axis)));
      message.accel_lsb[axis].push_back(static_cast<std::int16_t>(wave * 51 + 13));
    }
    message.temperature_degC.push_back(21.37f + 0.001f * static_cast<float>(number));
  }

  EventLogWriter writer_;
  const RecordPlan& plan_;
  std::int64_t seq_ = 0;
};

}  // namespace

MeasurementInfo PlannedInfo(const RecordPlan& plan) {
  MeasurementInfo info;
  info.source = plan.run_id;
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = 131.0;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {true, false, true};
  info.geometry = {{90.0, -0.1, 12.25}, 0.5, -1.5};
  info.site_latitude_deg = 55.75;
  info.site_heading_deg = 12.5;
  info.gear_ratio = 40.0;
  info.stop_accuracy_deg = 0.025;
  info.gyro_delay_s = 0.0048;
  info.reference_delay_s = 0.0005;
  info.sensor = "GB-0017";
  info.power_on = "boot 3";
  info.power_on_utime = plan.power_on_utime;
  info.notes = {{"operator", "A. Osadchiy"}};
  return info;
}

void BuildRecord(const std::filesystem::path& folder, const RecordPlan& plan) {
  std::filesystem::create_directories(folder);
  if (plan.with_run_json) {
    WriteJsonAtomically(folder / kRunJsonName, {{kRunIdKey, plan.run_id},
                                                {kStartUtimeKey, plan.start},
                                                {kMeasurementKey, ToJson(PlannedInfo(plan))}});
  }
  Log log(folder / kEventLogName, plan);
  log.Gyro("", -20);                      // between runs
  log.Gyro("20261121-120000-bias", -10);  // the run before
  log.Run(run_t::START, plan.start, "", 0);
  const Utime block_us = kSamplesPerBlock * kSampleInterval;
  for (int block = 0; block < plan.blocks; ++block) {
    const Utime begin = plan.start + block * block_us;
    // The reference is heard a little before the block that holds samples older than it.
    log.Angle(0, begin + 20'300, 0.001 * block);
    log.Angle(2, begin + 21'650, 123.456789012 + block * 9.0 / 7.0);
    log.Gyro(plan.run_id, block);
    if (block % 40 == 39) {
      log.Run(run_t::SEGMENT_END, begin + block_us, "turn " + std::to_string(block),
              begin - 39 * block_us);
    }
  }
  log.Run(run_t::STOP, plan.start + plan.blocks * block_us, "", 0);
}

std::string WithoutChecksums(const std::filesystem::path& log) {
  std::string bytes = ReadFile(log);
  EventLogReader reader(log);
  LogEvent event;
  while (reader.Next(event)) bytes.replace(static_cast<std::size_t>(event.byte) + 4, 4, 4, '\0');
  return bytes;
}

}  // namespace gyrobench::recording
