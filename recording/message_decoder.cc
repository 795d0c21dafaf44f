#include "recording/message_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "gyrobench/angle_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/reflection.hpp"
#include "gyrobench/run_t.hpp"
#include "recording/plausible.h"
#include "recording/sender.h"

namespace gyrobench::recording {
namespace {

bool RowsFit(const std::vector<std::vector<std::int16_t>>& rows, std::size_t n) {
  return rows.size() == 3 &&
         std::all_of(rows.begin(), rows.end(), [n](const auto& row) { return row.size() == n; });
}

// A count that the unit can have reached.
bool IsSampleNumber(std::int64_t number) { return number >= 0 && number < kMostSamples; }

// What was sampled was sampled before its block came, but for what the comparison of two clocks
// leaves open. A later time would make all that follow it late.
constexpr Utime kMaxAhead = kMicrosecondsPerSecond;

// An empty block may leave its arrays untouched.
bool ArraysFit(const gyro_t& message) {
  if (message.n == 0) return true;
  if (message.n < 0 || !IsSampleNumber(message.first_counter)) return false;
  const auto n = static_cast<std::size_t>(message.n);
  return message.sample_utime.size() == n &&
         std::all_of(message.sample_utime.begin(), message.sample_utime.end(),
                     [&](Utime utime) {
                       return IsPlausible(utime) && utime - message.utime <= kMaxAhead;
                     }) &&
         message.temperature_degC.size() == n && RowsFit(message.gyro_lsb, n) &&
         RowsFit(message.accel_lsb, n);
}

}  // namespace

MessageDecoder::MessageDecoder(const MeasurementInfo& info, Utime run_start, MeasurementSink& sink,
                               std::string run_id)
    : gyro_present_(info.gyro_present),
      accel_present_(info.accel_present),
      axis_present_(info.stand_axis_present),
      run_start_(run_start),
      origin_(info.power_on_utime.value_or(run_start)),
      sink_(sink),
      run_id_(std::move(run_id)) {
  sink_.OnInfo(info);
}

bool MessageDecoder::IsOurs(const std::string& run_id, Utime utime) {
  if (run_id.empty() || utime < run_start_) return false;
  if (run_id_.empty()) run_id_ = run_id;
  return run_id == run_id_;
}

void MessageDecoder::Report(const char* kind, std::int64_t count, Utime utime, const char* channel,
                            std::int64_t seq) {
  sink_.OnDefect({kind, count, Seconds(utime), fmt::format("{} message {}", channel, seq)});
}

bool MessageDecoder::IsInOrder(Utime utime, Utime& last, const char* channel, std::int64_t seq) {
  if (utime > last) {
    last = utime;
    return true;
  }
  Report(utime == last ? "repeated_time" : "time_backwards", 1, utime, channel, seq);
  return false;
}

// The unit says how many samples it overwrote; a damaged log shows as a jump of the sample numbers.
// What was lost before the run's first block was lost before the run.
void MessageDecoder::CheckContinuity(const gyro_t& message) {
  const bool restarted = boot_count_ && *boot_count_ != message.boot_count;
  if (restarted) {
    Report(kUnitRestarted, 1, message.utime, "_GYRO", message.seq);
    next_counter_.reset();
  }
  std::int64_t lost = boot_count_ ? message.missed : 0;
  boot_count_ = message.boot_count;
  if (message.n > 0) {
    if (next_counter_) lost = std::max(lost, message.first_counter - *next_counter_);
    next_counter_ = message.first_counter + message.n;
  } else if (next_counter_) {
    *next_counter_ += lost;
  }
  if (lost > 0) Report("samples_lost", lost, message.utime, "_GYRO", message.seq);
}

void MessageDecoder::Sample(const gyro_t& message, std::size_t i) {
  GyroSample sample;
  sample.t_s = Seconds(message.sample_utime[i]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (gyro_present_[axis]) sample.xi[axis] = message.gyro_lsb[axis][i];
    if (accel_present_[axis] && IsFactor(message.accel_lsb_per_g)) {
      sample.accel_g[axis] = message.accel_lsb[axis][i] / message.accel_lsb_per_g;
    }
  }
  const auto temperature_degC = static_cast<double>(message.temperature_degC[i]);
  if (IsPlausible(temperature_degC)) sample.temperature_degC = temperature_degC;
  sink_.OnGyro(sample);
}

void MessageDecoder::Gyro(const gyro_t& message) {
  if (!IsOurs(message.run_id, message.utime)) return;
  if (!ArraysFit(message)) {
    Report("damaged_message", 1, message.utime, "_GYRO", message.seq);
    return;
  }
  CheckContinuity(message);
  if (IsFactor(message.tick_rate_hz)) {
    sink_.OnTickPair(
        {static_cast<double>(message.unit_tick) / message.tick_rate_hz, Seconds(message.utime)});
  }
  if (suspended_) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(message.n); ++i) {
    if (message.sample_utime[i] < run_start_) continue;
    if (IsInOrder(message.sample_utime[i], last_gyro_, "_GYRO", message.seq)) Sample(message, i);
  }
}

void MessageDecoder::Angle(const angle_t& message) {
  if (!IsOurs(message.run_id, message.utime)) return;
  const int axis = message.axis;
  if (axis < 0 || axis > 2 || !axis_present_.at(static_cast<std::size_t>(axis))) {
    Report("unannounced_axis", 1, message.utime, "_ANGLE", message.seq);
    return;
  }
  if (suspended_) return;
  Utime& last = last_angle_.at(static_cast<std::size_t>(axis));
  if (!IsInOrder(message.utime, last, "_ANGLE", message.seq)) return;
  const double angle_deg = IsPlausible(message.angle_deg) ? message.angle_deg : kMissing;
  sink_.OnAngle({Seconds(message.utime), axis, angle_deg});
}

void MessageDecoder::Run(const run_t& message) {
  if (!IsOurs(message.run_id, message.utime)) return;
  if (message.event == run_t::SUSPEND) Report("suspended", 1, message.utime, "_RUN", message.seq);
  if (message.event == run_t::TAKEN_UP) Report("taken_up", 1, message.utime, "_RUN", message.seq);
  if (message.event == run_t::OTHER_POWER_ON)
    Report(kUnitRestarted, 1, message.utime, "_RUN", message.seq);
  if (message.event == run_t::TAKEN_UP) {  // another daemon counts samples and starts anew
    next_counter_.reset();
    boot_count_.reset();
  }
  if (message.event == run_t::SUSPEND || message.event == run_t::TAKEN_UP) suspended_ = true;
  if (message.event == run_t::CONTINUE) suspended_ = false;
  if (message.event != run_t::SEGMENT_END) return;
  if (!IsPlausible(message.segment_begin_utime)) return;
  sink_.OnSegment({Seconds(message.segment_begin_utime), Seconds(message.utime),
                   message.segment_kind, message.segment_name});
}

namespace {

// Walks over the fields of one message without reading their values.
class Walk {
 public:
  explicit Walk(MessageBytes bytes) : left_(bytes) { Skip(8); }  // the type's hash

  void Skip(std::size_t bytes) {
    sound_ = sound_ && bytes <= left_.size();
    if (sound_) left_ = left_.subspan(bytes);
  }
  // The size of an array, a signed number of so many bytes.
  std::size_t Count(std::size_t bytes) {
    const std::span<const std::uint8_t> number = left_;
    Skip(bytes);
    sound_ = sound_ && number[0] < 0x80;
    std::size_t value = 0;
    for (std::size_t i = 0; sound_ && i < bytes; ++i) value = value << 8 | number[i];
    return value;
  }
  // A string's length counts its terminating zero.
  void String() {
    const std::size_t length = Count(4);
    sound_ = sound_ && length >= 1;
    Skip(length);
  }
  // All fields were there, and nothing after them but who sent it.
  bool Ended() const {
    const bool is_signed = left_.size() == SenderBytes().size() && SenderOf(left_).has_value();
    return sound_ && (left_.empty() || is_signed);
  }
  std::size_t left() const { return left_.size(); }
  bool sound() const { return sound_; }

 private:
  MessageBytes left_;
  bool sound_ = true;
};

}  // namespace

template <typename Message>
bool DecodeSound(MessageBytes bytes, Message& message) {
  Walk walk(bytes);
  Reflection<Message>::Pass(walk);
  if (!walk.Ended()) return false;
  const int size = static_cast<int>(bytes.size() - walk.left());
  return message.decode(bytes.data(), 0, size) == size;
}

#define GYROBENCH_INSTANTIATE(Message) template bool DecodeSound(MessageBytes, Message&);
GYROBENCH_FOR_EACH_MESSAGE(GYROBENCH_INSTANTIATE)
#undef GYROBENCH_INSTANTIATE

}  // namespace gyrobench::recording
