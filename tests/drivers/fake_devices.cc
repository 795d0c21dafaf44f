#include "tests/drivers/fake_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

void FaultScript::FailNext(const std::string& message, int times) {
  const std::lock_guard lock(mutex_);
  faults_.insert(faults_.end(), static_cast<std::size_t>(times), message);
}

void FaultScript::FailAlways(const std::string& message) {
  const std::lock_guard lock(mutex_);
  always_ = message;
}

void FaultScript::Recover() {
  const std::lock_guard lock(mutex_);
  faults_.clear();
  always_.clear();
}

void FaultScript::Step() {
  const std::lock_guard lock(mutex_);
  std::string fault = always_;
  if (!faults_.empty()) {
    fault = faults_.front();
    faults_.pop_front();
  }
  if (!fault.empty()) throw NoAnswer(fault, fields);
}

FakeAxis::FakeAxis(std::string name, const Clock& clock) : name_(std::move(name)), clock_(clock) {}

void FakeAxis::Note(std::string call) {
  if (on_call) on_call(call);
  calls_.push_back(std::move(call));
}

bool FakeAxis::IsMoving() {
  Note("is moving");
  faults_.Step();
  return Moving();
}

AxisState FakeAxis::Open() {
  Note("open");
  const AxisState found = Read();
  if (another_) throw DeviceError("pulses per turn: expected 10000, found 1600");
  if (found.fault) throw DeviceError(fmt::format("reports a fault, alarm {}", alarm_));
  if (emergency_stop_) throw DeviceError("its emergency stop input acts");
  enabled_ = true;
  return found;
}

double FakeAxis::AngleDeg() const {
  const double way_deg = rate_deg_s_ * ToSeconds(clock_.Now() - moved_at_);
  const double whole_deg = to_deg_ - from_deg_;
  return way_deg >= std::fabs(whole_deg) ? to_deg_ : from_deg_ + std::copysign(way_deg, whole_deg);
}

double FakeAxis::RateDegSAt(Utime utime) const {
  const double since_s = ToSeconds(utime - moved_at_), whole_deg = to_deg_ - from_deg_;
  const bool moves = since_s >= 0.0 && rate_deg_s_ * since_s < std::fabs(whole_deg);
  return moves ? std::copysign(rate_deg_s_, whole_deg) : 0.0;
}

bool FakeAxis::Moving() const { return AngleDeg() != to_deg_; }

AxisState FakeAxis::Read() {
  faults_.Step();
  return {clock_.Now(), AngleDeg(),      enabled_,    Moving(),    alarm_ != 0,
          alarm_,       emergency_stop_, limit_plus_, limit_minus_};
}

void FakeAxis::SetInputs(bool emergency_stop, bool limit_plus, bool limit_minus) {
  emergency_stop_ = emergency_stop;
  limit_plus_ = limit_plus;
  limit_minus_ = limit_minus;
  from_deg_ = to_deg_ = AngleDeg();
  if (emergency_stop) enabled_ = false;
}

double FakeAxis::MoveBy(double angle_deg, double rate_deg_s, double /*acceleration_deg_s2*/) {
  Note(fmt::format("move {:g} deg at {:g} deg/s", angle_deg, rate_deg_s));
  faults_.Step();
  if (!enabled_ || alarm_ != 0 || Moving()) {
    throw DeviceError(fmt::format("axis.{}: move refused (enabled {}, alarm {}, moving {})", name_,
                                  enabled_, alarm_, Moving()));
  }
  from_deg_ = to_deg_;
  to_deg_ += angle_deg;
  rate_deg_s_ = rate_deg_s;
  moved_at_ = clock_.Now();
  return rate_deg_s;
}

void FakeAxis::Stop() {
  Note("stop");
  faults_.Step();
  from_deg_ = to_deg_ = AngleDeg();
}

void FakeAxis::ClearAlarm() {
  Note("clear alarm");
  faults_.Step();
  alarm_ = 0;
}

FakeAngleSensor::FakeAngleSensor(std::string name, const Clock& clock, Source angle_deg)
    : name_(std::move(name)), clock_(clock), angle_deg_(std::move(angle_deg)) {}

AngleReading FakeAngleSensor::Open() { return Now(); }

AngleReading FakeAngleSensor::Read() {
  ++reads_;
  return Now();
}

// High word first.
RawAngle FakeAngleSensor::ReadRaw() {
  const AngleReading now = Now();
  const auto counts = static_cast<std::uint32_t>(now.counts);
  return {now.utime,
          {static_cast<std::uint16_t>(counts >> 16), static_cast<std::uint16_t>(counts)}};
}

AngleReading FakeAngleSensor::Now() {
  faults_.Step();
  const Utime now = clock_.Now();
  const auto counts =
      static_cast<std::int64_t>(std::llround(angle_deg_(now) / 360.0 * kCountsPerTurn));
  return {now, now, now, counts, static_cast<double>(counts) * 360.0 / kCountsPerTurn};
}

FakeGyro::FakeGyro(GyroIdentity identity, const Clock& clock, Source source)
    : identity_(std::move(identity)), clock_(clock), source_(std::move(source)) {}

GyroIdentity FakeGyro::Open() {
  faults_.Step();
  const std::lock_guard lock(mutex_);
  started_ = clock_.Now();
  next_ = 0;
  return identity_;
}

std::int64_t FakeGyro::TickAt(Utime utime) const {
  return std::llround(ToSeconds(utime - started_) * identity_.tick_rate_hz);
}

void FakeGyro::Miss(std::int64_t samples) {
  const std::lock_guard lock(mutex_);
  missing_ += samples;
}

void FakeGyro::Restart() {
  const std::lock_guard lock(mutex_);
  ++identity_.boot_count;
  started_ = clock_.Now();
  next_ = 0;
}

void FakeGyro::Read(GyroBlock& block) {
  faults_.Step();
  const std::lock_guard lock(mutex_);
  const Utime now = clock_.Now();
  block.samples.clear();
  block.utime = now;
  block.tick = TickAt(now);
  block.boot_count = identity_.boot_count;
  block.missed = 0;
  block.sensor_bus_errors = counters_.sensor_bus_errors;
  block.samples_lost = counters_.samples_lost;
  block.frames_rejected = counters_.frames_rejected;
  while (true) {
    const Utime due = started_ + FromSeconds(static_cast<double>(next_) / identity_.sample_rate_hz);
    if (due > now) break;
    if (missing_ > 0) {
      --missing_;
      ++block.missed;
    } else {
      GyroRawSample sample = source_(due);
      sample.counter = next_;
      sample.tick = TickAt(due);
      sample.utime = due;
      block.samples.push_back(sample);
    }
    ++next_;
  }
}

void FakeRelays::Open() {
  faults.Step();
  for (auto& [output, state] : on) state = false;
}

void FakeRelays::Switch(const std::string& output, bool state) {
  calls.push_back(output + (state ? " on" : " off"));
  if (on_call) on_call(calls.back());
  faults.Step();
  if (output == refuses) throw DeviceError(output + " does not obey");
  on.at(output) = state;
  if (output == loses) throw NoAnswer(output + ": the answer was lost");
}

std::map<std::string, bool> FakeRelays::Read() {
  faults.Step();
  return on;
}

}  // namespace gyrobench::drivers
