// Devices in memory, for tests of everything above the drivers. No bus, no thread: they move with
// the clock that they are given, and fail when they are told to, by a test whose daemon may be
// reading them just then.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"
#include "drivers/gyro.h"
#include "drivers/relays.h"

namespace gyrobench::drivers {

// Failures told beforehand. Each call of a fake takes the next one: an empty text lets it pass, any
// other is thrown as NoAnswer with `fields`.
class FaultScript {
 public:
  void FailNext(const std::string& message, int times = 1);
  void PassNext(int times = 1) { FailNext("", times); }
  void FailAlways(const std::string& message);
  void Recover();
  DeviceFailure fields;
  // Throws when it is time to.
  void Step();

 private:
  std::mutex mutex_;
  std::deque<std::string> faults_;
  std::string always_;
};

// Moves at constant rate (acceleration takes no time); stops at once.
class FakeAxis final : public Axis {
 public:
  FakeAxis(std::string name, const Clock& clock);
  const std::string& name() const override { return name_; }
  bool IsMoving() override;
  int PulsesPerTurn() override { return 10000; }
  AxisState Open() override;
  AxisState Read() override;
  double MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2) override;
  void Stop() override;
  void ClearAlarm() override;

  // Commanded table angle now.
  double AngleDeg() const;
  // Of the last move, where it was under way at that time.
  double RateDegSAt(Utime utime) const;
  // As a drive that lost its power and has it again.
  void LosePower() { enabled_ = false; }
  void SetAlarm(int alarm) { alarm_ = alarm; }  // 0 = none; the fault bit follows
  // Digital inputs that act. An emergency stop stops it and disables it.
  void SetInputs(bool emergency_stop, bool limit_plus, bool limit_minus);
  // Its identity is not that of the map: it is refused when it is opened.
  void BeAnother() { another_ = true; }
  FaultScript& faults() { return faults_; }
  // Calls in their order: "open", "is moving", "move 9 deg at 10 deg/s", "stop", "clear alarm".
  // Read is not among them.
  const std::vector<std::string>& calls() const { return calls_; }
  // Told of each of them as it comes.
  std::function<void(const std::string& call)> on_call;

 private:
  void Note(std::string call);
  bool Moving() const;

  const std::string name_;
  const Clock& clock_;
  bool enabled_ = false;
  int alarm_ = 0;
  bool emergency_stop_ = false, limit_plus_ = false, limit_minus_ = false;
  bool another_ = false;
  double from_deg_ = 0.0, to_deg_ = 0.0, rate_deg_s_ = 1.0;
  Utime moved_at_ = 0;
  FaultScript faults_;
  std::vector<std::string> calls_;
};

// Reads an angle that the test computes, e.g. that of a FakeAxis and steps lost.
class FakeAngleSensor final : public AngleSensor {
 public:
  using Source = std::function<double(Utime)>;  // table angle [deg] at a host time
  FakeAngleSensor(std::string name, const Clock& clock, Source angle_deg);
  const std::string& name() const override { return name_; }
  AngleReading Open() override;
  AngleReading Read() override;
  RawAngle ReadRaw() override;
  int reads() const { return reads_; }  // so far
  FaultScript& faults() { return faults_; }

  static constexpr double kCountsPerTurn = 131072.0;

 private:
  AngleReading Now();

  const std::string name_;
  const Clock& clock_;
  Source angle_deg_;
  int reads_ = 0;
  FaultScript faults_;
};

// Takes a sample every 1 / sample_rate_hz of the clock from Open on.
class FakeGyro final : public Gyro {
 public:
  // Raw output at a host time; counter, tick and utime of the sample are filled in by the fake.
  using Source = std::function<GyroRawSample(Utime)>;
  FakeGyro(GyroIdentity identity, const Clock& clock, Source source);
  const std::string& name() const override { return name_; }
  GyroIdentity Open() override;
  void Read(GyroBlock& block) override;

  // The next `samples` samples are overwritten before they are read.
  void Miss(std::int64_t samples);
  // The unit starts anew: boot counter up, numbers and ticks from 0.
  void Restart();
  FaultScript& faults() { return faults_; }
  GyroBlock& counters() { return counters_; }  // error counters that each block carries

 private:
  std::int64_t TickAt(Utime utime) const;

  const std::string name_ = "gyro";
  std::mutex mutex_;
  GyroIdentity identity_;
  const Clock& clock_;
  Source source_;
  Utime started_ = 0;
  std::int64_t next_ = 0;
  std::int64_t missing_ = 0;
  FaultScript faults_;
  GyroBlock counters_;
};

// `refuses` names an output that does not obey, `loses` one that does and whose answer is lost.
class FakeRelays final : public Relays {
 public:
  std::map<std::string, bool> on = {{"fan", true}, {"heater", true}};
  std::vector<std::string> calls;
  std::function<void(const std::string& call)> on_call;  // told of each as it comes
  std::string refuses, loses;
  FaultScript faults;

  void Open() override;
  void Switch(const std::string& output, bool state) override;
  std::map<std::string, bool> Read() override;
};

}  // namespace gyrobench::drivers
