// From messages to a measurement. The running daemon and the replay of a record both go through
// this, so that both give the same numbers.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "base/clock.h"
#include "base/measurement.h"

namespace gyrobench {
class gyro_t;
class angle_t;
class run_t;
}  // namespace gyrobench

namespace gyrobench::recording {

// The bytes of a message, checked before they reach generated code: lcm-gen's decoder takes counts
// and string lengths from the bytes as they are: a damaged one makes it reserve gigabytes, or read
// past the end.
using MessageBytes = std::span<const std::uint8_t>;

// Decodes bytes in which all counts and lengths fit the size; who sent them may follow (sender.h).
// False when they are another type, another version or damaged. Message: any type of msgs/.
template <typename Message>
bool DecodeSound(MessageBytes bytes, Message& message);

// Turns the messages of one run into the events of a measurement: t_s = (utime - origin) * 1e-6.
// The origin is the power-on of the sensor, where `info` says when that was, else the run's start.
//
// Left out in silence: what lies before the run's start, and messages of another run or of none.
// Left out and reported as a defect: a sample whose time is not after that of the one before
// (repeated_time, time_backwards), an axis that `info` does not announce (unannounced_axis), a
// message whose arrays do not fit its count or whose times no clock can give (damaged_message).
// Left out and reported once: what was sampled while a run was suspended (suspended), or until it
// was taken up again after its daemon had ended (taken_up).
// Reported: samples_lost (by the unit's own count, or a jump of the sample numbers),
// unit_restarted. Allocates nothing per sample.
class MessageDecoder {
 public:
  // Gives `info` to the sink at once. `run_id`: the run to listen to; empty: the run of the first
  // message at or after `run_start` that names one.
  MessageDecoder(const MeasurementInfo& info, Utime run_start, MeasurementSink& sink,
                 std::string run_id = {});

  void Gyro(const gyro_t& message);
  void Angle(const angle_t& message);
  void Run(const run_t& message);

 private:
  bool IsOurs(const std::string& run_id, Utime utime);
  double Seconds(Utime utime) const { return ToSeconds(utime - origin_); }
  bool IsInOrder(Utime utime, Utime& last, const char* channel, std::int64_t seq);
  void CheckContinuity(const gyro_t& message);
  void Sample(const gyro_t& message, std::size_t i);
  void Report(const char* kind, std::int64_t count, Utime utime, const char* channel,
              std::int64_t seq);

  static constexpr Utime kNever = std::numeric_limits<Utime>::min();

  const std::array<bool, 3> gyro_present_;
  const std::array<bool, 3> accel_present_;
  const std::array<bool, 3> axis_present_;
  const Utime run_start_;
  const Utime origin_;  // of t_s
  MeasurementSink& sink_;
  std::string run_id_;
  Utime last_gyro_ = kNever;
  std::array<Utime, 3> last_angle_ = {kNever, kNever, kNever};
  bool suspended_ = false;
  std::optional<std::int32_t> boot_count_;
  std::optional<std::int64_t> next_counter_;
};

}  // namespace gyrobench::recording
