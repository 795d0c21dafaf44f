#include "daemon/acquisition.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "daemon/messages.h"
#include "gyrobench/angle_t.hpp"
#include "gyrobench/axes_t.hpp"

namespace gyrobench::daemon {
namespace {

// Motion ends at deadlines that the run engine keeps; the drive's poll is there for alarms.
constexpr Utime kDrivePeriod = kMicrosecondsPerSecond / 2;
constexpr Utime kOutputsPeriod = kMicrosecondsPerSecond / 2;
// Beyond a soft limit by more than the play of a worm and the noise of an encoder.
constexpr double kSoftLimitMargin_deg = 0.2;

// Of each device, for the report of a fault: two seconds of a reference that is read at 10 Hz.
constexpr std::size_t kLastSamples = 20;

Utime Period(double rate_hz) { return FromSeconds(1.0 / rate_hz); }

std::int8_t AxisNumber(const std::string& name) {
  if (name == "outer") return angle_t::OUTER;
  return name == "middle" ? angle_t::MIDDLE : angle_t::INNER;
}

}  // namespace

struct Acquisition::AxisUnit {
  const config::AxisConfig* config = nullptr;
  BusWorker* drive_bus = nullptr;
  BusWorker* encoder_bus = nullptr;
  std::unique_ptr<drivers::Axis> drive;
  std::unique_ptr<drivers::AngleSensor> encoder;
  AxisView view;
  boost::circular_buffer<drivers::AngleReading> last{kLastSamples};
  angle_t message;
  bool beyond_limit = false;  // of the encoder's bus thread: reported already
};

Acquisition::Acquisition(const config::StandConfig& stand, Clock& clock,
                         drivers::DeviceMaker& devices, Telemetry& telemetry,
                         FaultHandler on_silence, FaultHandler on_fault)
    : stand_(stand),
      clock_(clock),
      maker_(devices),
      telemetry_(telemetry),
      on_silence_(WithLastSamples(std::move(on_silence))),
      on_fault_(WithLastSamples(std::move(on_fault))),
      last_gyro_(kLastSamples) {
  for (const config::BusConfig& bus : stand.buses) {
    buses_.push_back(std::make_unique<BusWorker>(bus.name, clock));
    maker_.AddBus(bus, buses_.back()->participant());
  }
  for (const config::AxisConfig& axis : stand.axes) AddAxis(axis);
  AddGyro();
  if (stand.relays) AddOutputs();
}

Acquisition::~Acquisition() { Stop(); }

FaultHandler Acquisition::WithLastSamples(FaultHandler handler) const {
  return [this, handler = std::move(handler)](Fault fault) {
    fault.samples = Last();
    handler(fault);
  };
}

BusWorker& Acquisition::BusOf(const std::string& name) {
  const auto found = std::find_if(buses_.begin(), buses_.end(),
                                  [&](const auto& bus) { return bus->name() == name; });
  if (found == buses_.end()) throw ConfigError(fmt::format("no bus '{}' in the stand file", name));
  return **found;
}

Acquisition::AxisUnit& Acquisition::UnitOf(const std::string& axis) {
  const auto found = std::find_if(axes_.begin(), axes_.end(),
                                  [&](const auto& unit) { return unit->config->name == axis; });
  if (found == axes_.end()) throw LimitError(fmt::format("this stand has no axis '{}'", axis));
  return **found;
}

void Acquisition::AddAxis(const config::AxisConfig& axis) {
  auto unit = std::make_unique<AxisUnit>();
  AxisUnit& u = *unit;
  u.config = &axis;
  u.drive_bus = &BusOf(axis.drive.bus);
  u.encoder_bus = &BusOf(axis.encoder.bus);
  u.drive = maker_.MakeAxis(axis);
  u.encoder = maker_.MakeAngleSensor(axis);
  const Utime silence = FromSeconds(stand_.safety.silence_s);

  auto encoder = std::make_unique<PolledDevice>(
      DeviceStatus{"encoder." + axis.name, "encoder", axis.encoder.bus, axis.encoder.unit, false,
                   ""},
      PolledDevice::Actions{[&u] { u.encoder->Open(); }, [this, &u] { ReadEncoder(u); },
                            [this, &axis] {
                              return Period(IsActive(axis.name) ? axis.encoder.rate_hz
                                                                : axis.encoder.idle_rate_hz);
                            }},
      clock_, silence, on_silence_);
  auto drive = std::make_unique<PolledDevice>(
      DeviceStatus{"axis." + axis.name, "drive", axis.drive.bus, axis.drive.unit, false, ""},
      PolledDevice::Actions{[&u] { u.drive->Open(); }, [this, &u] { ReadDrive(u); },
                            [] { return kDrivePeriod; }},
      clock_, silence, on_silence_);
  u.encoder_bus->AddPoll([device = encoder.get()] { return device->Poll(); });
  u.drive_bus->AddPoll([device = drive.get()] { return device->Poll(); });
  devices_.push_back(std::move(drive));
  devices_.push_back(std::move(encoder));
  axes_.push_back(std::move(unit));
}

void Acquisition::AddGyro() {
  const config::GyroConfig& gyro = stand_.gyro;
  gyro_ = maker_.MakeGyro(gyro);
  // One sample less than a reply carries: a poll that comes a little late still needs one request
  // only.
  const Utime period = Period(gyro.rate_hz / (gyro.map.max_samples_per_block - 1));
  auto device = std::make_unique<PolledDevice>(
      DeviceStatus{"gyro", "gyro", gyro.bus, gyro.unit, false, ""},
      PolledDevice::Actions{[this] {
                              const drivers::GyroIdentity identity = gyro_->Open();
                              last_sample_ = clock_.Now();
                              const std::lock_guard lock(mutex_);
                              sensor_.identity = identity;
                            },
                            [this] { ReadGyro(); }, [period] { return period; }},
      clock_, FromSeconds(stand_.safety.silence_s), on_silence_);
  BusOf(gyro.bus).AddPoll([poll = device.get()] { return poll->Poll(); });
  devices_.push_back(std::move(device));
}

void Acquisition::AddOutputs() {
  const config::RelaysConfig& relays = *stand_.relays;
  BusWorker& bus = BusOf(relays.bus);
  outputs_ = std::make_unique<Outputs>(relays, bus, maker_.MakeRelays(relays), on_fault_);
  auto device = std::make_unique<PolledDevice>(
      DeviceStatus{"relays", "relays", relays.bus, relays.unit, false, ""},
      PolledDevice::Actions{[this] { outputs_->Open(); }, [this] { outputs_->Check(); },
                            [] { return kOutputsPeriod; }},
      clock_, FromSeconds(stand_.safety.silence_s), on_silence_);
  bus.AddPoll([poll = device.get()] { return poll->Poll(); });
  devices_.push_back(std::move(device));
}

void Acquisition::Start() {
  for (const auto& bus : buses_) bus->Start();
}

void Acquisition::Stop() {
  for (const auto& bus : buses_) bus->Stop();
}

void Acquisition::Hold(Clock::Participant& caller) {
  for (const auto& bus : buses_) bus->Hold(caller);
}

void Acquisition::Resume() {
  for (const auto& bus : buses_) bus->Resume();
}

void Acquisition::ReadEncoder(AxisUnit& unit) {
  const drivers::AngleReading reading = unit.encoder->Read();
  {
    const std::lock_guard lock(mutex_);
    unit.view.reference = reading;
    unit.last.push_back(reading);
  }
  unit.message.utime = reading.utime;
  unit.message.axis = AxisNumber(unit.config->name);
  unit.message.counts = reading.counts;
  unit.message.angle_deg = reading.angle_deg;
  unit.message.utime_request = reading.utime_request;
  unit.message.utime_reply = reading.utime_reply;
  telemetry_.Send(unit.message);
  CheckSoftLimits(unit, reading.angle_deg);
}

void Acquisition::CheckSoftLimits(AxisUnit& unit, double angle_deg) {
  const config::AxisConfig& axis = *unit.config;
  if (!IsActive(axis.name)) return;
  if (angle_deg >= axis.min_deg - kSoftLimitMargin_deg &&
      angle_deg <= axis.max_deg + kSoftLimitMargin_deg) {
    unit.beyond_limit = false;
    return;
  }
  if (std::exchange(unit.beyond_limit, true)) return;
  PostStopAll();
  on_fault_(
      {"axis." + axis.name,
       fmt::format("the table is at {:.3f} deg, beyond its soft limits {:g} .. {:g} deg: stopped. "
                   "Turn it back by hand or correct the limits, then: gyrobench reset",
                   angle_deg, axis.min_deg, axis.max_deg),
       {.device = "axis." + axis.name, .action = "soft limits"}});
}

void Acquisition::ReadDrive(AxisUnit& unit) {
  const drivers::AxisState state = unit.drive->Read();
  {
    const std::lock_guard lock(mutex_);
    unit.view.drive = state;
  }
  SendAxes(state.utime);
  if (!state.fault) return;
  on_fault_({"axis." + unit.config->name,
             fmt::format(
                 "the drive reports alarm {} (0x{:02X}). See the drive's manual, remove the cause, "
                 "then: gyrobench reset",
                 state.alarm, state.alarm),
             {.device = "axis." + unit.config->name + " drive",
              .action = "status",
              .code_kind = DeviceFailure::CodeKind::kAlarm,
              .code = state.alarm}});
}

void Acquisition::SendAxes(Utime utime) {
  axes_t message{};
  message.utime = utime;
  message.n = static_cast<std::int8_t>(axes_.size());
  {
    const std::lock_guard lock(mutex_);
    for (const auto& unit : axes_) {
      const drivers::AxisState& drive = unit->view.drive;
      message.name.push_back(unit->config->name);
      message.commanded_deg.push_back(drive.commanded_deg);
      message.reference_deg.push_back(unit->view.reference.angle_deg);
      message.enabled.push_back(drive.enabled);
      message.moving.push_back(drive.moving);
      message.fault.push_back(drive.fault);
      message.alarm.push_back(drive.alarm);
    }
  }
  telemetry_.Send(message);
}

void Acquisition::ReadGyro() {
  gyro_->Read(block_);
  const double tick_rate_hz = sensor_.identity.tick_rate_hz;  // written by this thread only
  const double tick_s = static_cast<double>(block_.tick) / tick_rate_hz;
  const bool began_anew = block_.boot_count != boot_count_ || tick_s < last_tick_s_;
  last_tick_s_ = tick_s;
  if (tick_fit_.count() == 0 || began_anew) {
    tick_fit_ = TickFit();
    boot_count_ = block_.boot_count;
    first_tick_s_ = tick_s;
  }
  tick_fit_.Add({tick_s, ToSeconds(block_.utime)});
  power_on_watch_.Take(sensor_.identity.serial_number, block_);
  {
    const std::lock_guard lock(mutex_);
    sensor_.power_on = power_on_watch_.power_on();
    sensor_.tick_ratio = tick_fit_.ratio();
    sensor_.tick_span_s = tick_s - first_tick_s_;
    sensor_.samples += static_cast<std::int64_t>(block_.samples.size());
    if (!block_.samples.empty()) {
      sensor_.temperature_degC = block_.samples.back().temperature_degC;
    }
    for (const drivers::GyroRawSample& sample : block_.samples) last_gyro_.push_back(sample);
  }
  RequireSamples();
  FillMessage(block_, sensor_.identity, gyro_message_);
  telemetry_.Send(gyro_message_);
}

// A unit that answers while its sensor is silent would leave a run blind, and a heater unwatched.
void Acquisition::RequireSamples() {
  if (!block_.samples.empty()) {
    last_sample_ = clock_.Now();
    if (outputs_) outputs_->Watch(block_.samples.back().temperature_degC);
    return;
  }
  const double silent_s = ToSeconds(clock_.Now() - last_sample_);
  if (silent_s <= stand_.safety.silence_s) return;
  throw DeviceError(
      fmt::format("gyro: the unit answers, but has had no sample of its sensor for {:.1f} s, "
                  "expected {:g} Hz. Check the sensor's own bus and supply.",
                  silent_s, stand_.gyro.rate_hz),
      {.device = "gyro", .action = "samples"});
}

void Acquisition::AwaitFirstTry(Clock::Participant& caller, Utime patience) const {
  constexpr Utime kStep = kMicrosecondsPerSecond / 20;
  const Utime deadline = clock_.Now() + patience;
  const auto all_tried = [this] {
    return std::all_of(devices_.begin(), devices_.end(),
                       [](const auto& device) { return device->tried(); });
  };
  while (!all_tried() && clock_.Now() < deadline) caller.WaitUntil(clock_.Now() + kStep);
}

std::vector<DeviceStatus> Acquisition::Devices() const {
  std::vector<DeviceStatus> all;
  for (const auto& device : devices_) all.push_back(device->status());
  return all;
}

AxisView Acquisition::Axis(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const auto& unit : axes_) {
    if (unit->config->name == name) return unit->view;
  }
  throw LimitError(fmt::format("this stand has no axis '{}'", name));
}

SensorView Acquisition::Sensor() const {
  const std::lock_guard lock(mutex_);
  return sensor_;
}

LastSamples Acquisition::Last() const {
  LastSamples last;
  const std::lock_guard lock(mutex_);
  for (const auto& unit : axes_) {
    last.axes.push_back(
        {unit->config->name, unit->view.drive, {unit->last.begin(), unit->last.end()}});
  }
  last.gyro.assign(last_gyro_.begin(), last_gyro_.end());
  return last;
}

MeasurementInfo Acquisition::Info() const {
  const SensorView sensor = Sensor();
  const drivers::GyroIdentity& identity = sensor.identity;
  MeasurementInfo info;
  info.gyro_unit = RateUnit::kLsb;
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = identity.gyro_lsb_per_deg_s;
  info.reference = stand_.axes.empty() ? ReferenceKind::kNone : ReferenceKind::kStandAngles;
  for (const config::AxisConfig& axis : stand_.axes) {
    info.stand_axis_present[static_cast<std::size_t>(AxisNumber(axis.name))] = true;
    // Of the axis that the run turns; of any, where it turns none.
    if (!info.gear_ratio || IsActive(axis.name)) {
      info.gear_ratio = axis.gear_ratio;
      info.stop_accuracy_deg = axis.shaft_accuracy_deg / axis.gear_ratio;
    }
    info.reference_delay_s =
        axis.encoder.map.delay_s;  // the stand file is refused where they differ
  }
  info.gyro_delay_s = identity.filter_delay_s;
  info.reference_uncertainty = {stand_.reference.scale_uncertainty,
                                stand_.reference.eccentricity_deg, stand_.reference.alignment_deg};
  info.geometry = stand_.geometry;
  info.site_latitude_deg = stand_.site.latitude_deg;
  info.site_heading_deg = stand_.site.heading_deg;
  info.sensor = fmt::format("{}", identity.serial_number);
  if (sensor.power_on) {
    info.power_on = sensor.power_on->name;
    info.power_on_utime = sensor.power_on->utime;
  }
  return info;
}

void Acquisition::SetActiveAxes(std::set<std::string> names) {
  const std::lock_guard lock(mutex_);
  active_axes_ = std::move(names);
}

bool Acquisition::IsActive(const std::string& axis) const {
  const std::lock_guard lock(mutex_);
  return active_axes_.contains(axis);
}

double Acquisition::MoveBy(Clock::Participant& caller, const std::string& axis, double angle_deg,
                           double rate_deg_s, double acceleration_deg_s2,
                           const std::function<void()>& may_move) {
  AxisUnit& unit = UnitOf(axis);
  return unit.drive_bus->Call(caller, [&] {
    may_move();
    return unit.drive->MoveBy(angle_deg, rate_deg_s, acceleration_deg_s2);
  });
}

drivers::AxisState Acquisition::ReadDriveNow(Clock::Participant& caller, const std::string& axis) {
  AxisUnit& unit = UnitOf(axis);
  unit.drive_bus->Call(caller, [&] { ReadDrive(unit); });
  return Axis(axis).drive;
}

AxisView Acquisition::ReadNow(Clock::Participant& caller, const std::string& axis) {
  AxisUnit& unit = UnitOf(axis);
  unit.drive_bus->Call(caller, [&] { ReadDrive(unit); });
  unit.encoder_bus->Call(caller, [&] { ReadEncoder(unit); });
  return Axis(axis);
}

void Acquisition::PostStopAll() {
  for (const auto& unit : axes_) {
    unit->drive_bus->Post([this, u = unit.get()] {
      try {
        u->drive->Stop();
      } catch (const std::exception& error) {
        on_fault_(FaultOf("axis." + u->config->name, error));
      }
    });
  }
}

void Acquisition::StopAll(Clock::Participant& caller) {
  std::vector<AxisUnit*> order;
  for (const auto& unit : axes_) order.push_back(unit.get());
  std::stable_partition(order.begin(), order.end(),
                        [this](const AxisUnit* unit) { return IsActive(unit->config->name); });
  Fault failed;
  for (AxisUnit* unit : order) {
    try {
      unit->drive_bus->Call(caller, [&] { unit->drive->Stop(); });
    } catch (const DeviceError& error) {
      AddTo(failed, error);
    }
  }
  if (!failed.message.empty()) throw DeviceError(failed.message, failed.failure);
}

void Acquisition::PostClearAlarms() {
  for (const auto& unit : axes_) {
    unit->drive_bus->Post([this, u = unit.get()] {
      try {
        u->drive->ClearAlarm();
      } catch (const std::exception& error) {
        on_fault_(FaultOf("axis." + u->config->name, error));
      }
    });
  }
}

}  // namespace gyrobench::daemon
