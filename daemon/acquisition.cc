#include "daemon/acquisition.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/error.h"
#include "drivers/modbus_bus.h"
#include "gyrobench/axes_t.hpp"

namespace gyrobench::daemon {
namespace {

// Motion ends at deadlines that the run engine keeps; the drive's poll is there for alarms.
constexpr Utime kDrivePeriod = kMicrosecondsPerSecond / 2;
constexpr Utime kOutputsPeriod = kMicrosecondsPerSecond / 2;
// Of a drive that gives way to others of its line, each with as many tries as they leave it: one at
// least, so that it has as many requests as it would have alone.
constexpr int kStopTurns = 6;

}  // namespace

Acquisition::Acquisition(const config::StandConfig& stand, Clock& clock,
                         drivers::DeviceMaker& devices, Telemetry& telemetry,
                         FaultHandler on_silence, FaultHandler on_fault, Notices& notices)
    : stand_(stand),
      clock_(clock),
      maker_(devices),
      telemetry_(telemetry),
      on_silence_(WithLastSamples(std::move(on_silence))),
      on_fault_(WithLastSamples(std::move(on_fault))),
      notices_(notices) {
  for (const config::BusConfig& bus : stand.buses) {
    buses_.push_back(std::make_unique<BusWorker>(bus.name, clock));
    maker_.AddBus(bus, buses_.back()->participant(),
                  [worker = buses_.back().get()] { return worker->hurries(); });
  }
  // First, so that they are off before anything else is asked.
  if (stand.relays) AddOutputs();
  for (const config::AxisConfig& axis : stand.axes) AddAxis(axis);
  // An axis that moves waits for no reference that is silent.
  for (const auto& axis : axes_) AddDrive(*axis);
  for (const auto& axis : axes_) AddEncoder(*axis);
  AddGyro();
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

AxisUnit& Acquisition::AxisNamed(const std::string& name) const {
  const auto found = std::find_if(axes_.begin(), axes_.end(),
                                  [&](const auto& axis) { return axis->name() == name; });
  if (found == axes_.end()) throw LimitError(fmt::format("this stand has no axis '{}'", name));
  return **found;
}

void Acquisition::AddDevice(BusWorker& bus, DeviceStatus identity, PolledDevice::Actions actions) {
  auto device = std::make_unique<PolledDevice>(std::move(identity), std::move(actions), clock_,
                                               FromSeconds(stand_.safety.silence_s), on_silence_);
  bus.AddPoll([this, poll = device.get()] {
    const bool was_well = poll->ok();
    const Utime due = poll->Poll();
    if (poll->ok() != was_well) TellWellness();
    return due;
  });
  devices_.push_back(std::move(device));
}

void Acquisition::TellWellness() {
  const std::lock_guard lock(well_mutex_);
  const bool all_well =
      std::ranges::all_of(devices_, [](const auto& device) { return device->ok(); });
  if (std::exchange(all_well_, all_well) != all_well) on_well_(all_well);
}

void Acquisition::AddAxis(const config::AxisConfig& config) {
  axes_.push_back(std::make_unique<AxisUnit>(
      config, BusOf(config.drive.bus), BusOf(config.encoder.bus), maker_, telemetry_,
      AxisUnit::Hooks{
          [this](Utime utime) { SendAxes(utime); }, [this] { PostStopAll(); },
          [this, &config](const std::string& not_stopped) { SayFoundMoving(config, not_stopped); },
          on_fault_}));
}

void Acquisition::AddEncoder(AxisUnit& axis) {
  const config::AxisConfig& config = axis.config();
  AddDevice(
      axis.encoder_bus(),
      {"encoder." + config.name, "encoder", config.encoder.bus, config.encoder.unit, false, ""},
      {[&axis] { axis.OpenEncoder(); }, [&axis] { axis.ReadEncoder(); },
       [&axis] { return axis.encoder_period(); }});
}

void Acquisition::AddDrive(AxisUnit& axis) {
  const config::AxisConfig& config = axis.config();
  AddDevice(
      axis.drive_bus(),
      {"axis." + config.name, "drive", config.drive.bus, config.drive.unit, false, ""},
      {[&axis] { axis.OpenDrive(); }, [&axis] { axis.ReadDrive(); }, [] { return kDrivePeriod; }});
}

// Whoever commanded it is gone: a daemon that was killed, as a rule.
void Acquisition::SayFoundMoving(const config::AxisConfig& axis, const std::string& not_stopped) {
  const std::string what =
      fmt::format("axis.{}: the drive was moving when it was opened: ", axis.name);
  if (not_stopped.empty()) {
    notices_.Add(clock_.Now(), what + "stopped");
  } else {
    notices_.Add(clock_.Now(), what + "NOT stopped, use the emergency stop: " + not_stopped);
  }
}

void Acquisition::AddGyro() {
  const config::GyroConfig& gyro = stand_.gyro;
  gyro_ = std::make_unique<GyroFeed>(gyro, stand_.safety.silence_s, clock_, maker_.MakeGyro(gyro),
                                     telemetry_, [this](double temperature_degC) {
                                       if (outputs_) outputs_->Watch(temperature_degC);
                                       WatchTemperature(temperature_degC);
                                     });
  AddDevice(BusOf(gyro.bus), {"gyro", "gyro", gyro.bus, gyro.unit, false, ""},
            {[this] { gyro_->Open(); }, [this] { gyro_->Read(); },
             [period = gyro_->period()] { return period; }});
}

// Once; a thermometer that comes back into the range arms it again.
void Acquisition::WatchTemperature(double temperature_degC) {
  constexpr int kBlocksBeyond = 2;
  const config::GyroConfig& gyro = stand_.gyro;
  const bool within = temperature_degC >= gyro.min_degC && temperature_degC <= gyro.max_degC;
  beyond_range_ = within ? 0 : beyond_range_ + 1;
  if (beyond_range_ != kBlocksBeyond) return;
  PostStopAll();
  if (outputs_) outputs_->PostAllOff();
  on_fault_(
      {"gyro",
       fmt::format("the sensor's thermometer says {:.1f} degC, outside the part's range {:g} .. "
                   "{:g} degC (gyro.min_degC, gyro.max_degC): axes stopped, outputs off. Let it "
                   "cool down or warm up, then: gyrobench reset",
                   temperature_degC, gyro.min_degC, gyro.max_degC),
       {.device = "gyro", .action = "temperature"}});
}

void Acquisition::AddOutputs() {
  const config::RelaysConfig& relays = *stand_.relays;
  BusWorker& bus = BusOf(relays.bus);
  outputs_ = std::make_unique<Outputs>(relays, bus, maker_.MakeRelays(relays), on_fault_);
  AddDevice(
      bus, {"relays", "relays", relays.bus, relays.unit, false, ""},
      {[this] { outputs_->Open(); }, [this] { outputs_->Check(); }, [] { return kOutputsPeriod; }});
}

void Acquisition::Start() {
  {
    // Not before they were asked.
    const std::lock_guard lock(well_mutex_);
    all_well_ = false;
  }
  on_well_(false);
  for (const auto& bus : buses_) bus->Start();
}

void Acquisition::Stop() {
  for (const auto& bus : buses_) bus->Stop();
}

void Acquisition::Hold(Clock::Participant& caller) {
  for (const auto& bus : buses_) bus->Hold(caller);
}

void Acquisition::OnBus(Clock::Participant& caller, const std::string& bus,
                        const std::function<void()>& work) {
  BusOf(bus).Call(caller, work);
}

void Acquisition::OpenAnew(Clock::Participant& caller) {
  for (const auto& axis : axes_)
    axis->encoder_bus().Call(caller, [unit = axis.get()] { unit->MayHaveBeenTurned(); });
  for (const auto& device : devices_)
    BusOf(device->status().bus).Call(caller, [poll = device.get()] { poll->OpenAnew(); });
}

void Acquisition::Resume() {
  for (const auto& bus : buses_) bus->Resume();
}

void Acquisition::SendAxes(Utime utime) {
  axes_t message{};
  message.utime = utime;
  message.n = static_cast<std::int8_t>(axes_.size());
  for (const auto& axis : axes_) {
    const AxisView view = axis->view();
    message.name.push_back(axis->name());
    message.commanded_deg.push_back(view.drive.commanded_deg);
    message.reference_deg.push_back(view.reference.angle_deg);
    message.enabled.push_back(view.drive.enabled);
    message.moving.push_back(view.drive.moving);
    message.fault.push_back(view.drive.fault);
    message.alarm.push_back(view.drive.alarm);
  }
  telemetry_.Send(message);
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

AxisView Acquisition::Axis(const std::string& name) const { return AxisNamed(name).view(); }

int Acquisition::PowerLosses(const std::string& axis) const {
  return AxisNamed(axis).power_losses();
}

SensorView Acquisition::Sensor() const { return gyro_->view(); }

std::string Acquisition::StuckBus() const {
  // To open a silent drive, and to wait until it is enabled, takes some ten requests.
  constexpr double kRequests = 20.0;
  constexpr double kLeast_s = 10.0;
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    const config::BusConfig& bus = stand_.buses[i];
    const double longest_s =
        std::max(kLeast_s, kRequests * bus.response_timeout_s * (1.0 + bus.retries));
    const double busy_s = buses_[i]->BusyFor_s();
    if (busy_s <= longest_s) continue;
    return fmt::format("the thread of bus {} has been at one thing for {:.0f} s", bus.name, busy_s);
  }
  return {};
}

LastSamples Acquisition::Last() const {
  LastSamples last;
  for (const auto& axis : axes_) last.axes.push_back(axis->last());
  last.gyro = gyro_->last();
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
    info.stand_axis_present[static_cast<std::uint8_t>(AxisNumber(axis.name))] = true;
    // Of the axis that the run turns; of any, where it turns none.
    if (!info.gear_ratio || AxisNamed(axis.name).active()) {
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

void Acquisition::SetActiveAxes(const std::set<std::string>& names) {
  for (const auto& axis : axes_) axis->SetActive(names.contains(axis->name()));
}

double Acquisition::MoveBy(Clock::Participant& caller, const std::string& axis, double angle_deg,
                           double rate_deg_s, double acceleration_deg_s2,
                           const std::function<void()>& may_move) {
  AxisUnit& unit = AxisNamed(axis);
  return unit.drive_bus().Call(caller, [&] {
    may_move();
    return unit.MoveBy(angle_deg, rate_deg_s, acceleration_deg_s2);
  });
}

drivers::AxisState Acquisition::ReadDriveNow(Clock::Participant& caller, const std::string& axis) {
  AxisUnit& unit = AxisNamed(axis);
  unit.drive_bus().Call(caller, [&] { unit.ReadDrive(); });
  return unit.view().drive;
}

AxisView Acquisition::ReadNow(Clock::Participant& caller, const std::string& axis) {
  AxisUnit& unit = AxisNamed(axis);
  unit.drive_bus().Call(caller, [&] { unit.ReadDrive(); });
  unit.encoder_bus().Call(caller, [&] { unit.ReadEncoder(); });
  return unit.view();
}

std::vector<AxisUnit*> Acquisition::MostUrgentFirst() const {
  std::vector<AxisUnit*> order;
  for (const auto& axis : axes_) order.push_back(axis.get());
  std::ranges::stable_sort(order, {}, [](const AxisUnit* axis) {
    const bool may_move = axis->active() || axis->view().drive.moving;
    return (may_move ? 0 : 2) + (axis->drive_answers() ? 0 : 1);
  });
  return order;
}

void Acquisition::PostStop(AxisUnit& axis, const std::string& key, StopHandler done, int turn) {
  axis.drive_bus().PostUrgentOnce(key, [this, &axis, key, done = std::move(done), turn] {
    try {
      axis.drive().Stop();
    } catch (const std::exception& error) {
      const bool gave_way = axis.drive_bus().hurries();
      if (gave_way && turn < kStopTurns) return PostStop(axis, key, done, turn + 1);
      return done(&error);
    }
    done(nullptr);
  });
}

void Acquisition::PostStopAll() {
  for (AxisUnit* axis : MostUrgentFirst()) {
    PostStop(*axis, "stop " + axis->name(), [this, axis](const std::exception* error) {
      if (error != nullptr) on_fault_(FaultOf("axis." + axis->name(), *error));
    });
  }
}

void Acquisition::PostStopWhatAnswers() {
  for (AxisUnit* axis : MostUrgentFirst()) {
    PostStop(*axis, "stop if it answers " + axis->name(), [](const std::exception* error) {
      if (error != nullptr) spdlog::warn("{}", error->what());  // its poll says so as well
    });
  }
}

void Acquisition::PostRearm() {
  for (const auto& axis : axes_) axis->Rearm();
  BusOf(stand_.gyro.bus).PostOnce("rearm", [this] { beyond_range_ = 0; });
}

void Acquisition::PostClearAlarms() {
  for (const auto& axis : axes_) {
    axis->drive_bus().PostOnce("clear alarm " + axis->name(), [this, unit = axis.get()] {
      try {
        unit->drive().ClearAlarm();
      } catch (const drivers::NoAnswer& error) {
        spdlog::warn("{}", error.what());
      } catch (const std::exception& error) {
        on_fault_(FaultOf("axis." + unit->name(), error));
      }
    });
  }
}

// All are told before any is waited for.
std::vector<Fault> Acquisition::TryStopAll(Clock::Participant& caller) {
  struct Outcome {
    std::mutex mutex;  // held while notifying, so that the caller is still there
    std::size_t left = 0;
    std::vector<Fault> failed;
  };
  const auto outcome = std::make_shared<Outcome>();
  outcome->left = axes_.size();
  for (AxisUnit* axis : MostUrgentFirst()) {
    PostStop(*axis, "", [outcome, &caller, axis](const std::exception* error) {
      const std::lock_guard lock(outcome->mutex);
      if (error != nullptr) outcome->failed.push_back(FaultOf("axis." + axis->name(), *error));
      --outcome->left;
      caller.Notify();
    });
  }
  const auto all_done = [&outcome] {
    const std::lock_guard lock(outcome->mutex);
    return outcome->left == 0;
  };
  while (!all_done()) caller.WaitUntil(kForever);
  return outcome->failed;
}

void Acquisition::StopAll(Clock::Participant& caller) {
  Fault all;
  for (const Fault& failed : TryStopAll(caller))
    AddTo(all, DeviceError(failed.message, failed.failure));
  if (!all.message.empty()) throw DeviceError(all.message, all.failure);
}

}  // namespace gyrobench::daemon
