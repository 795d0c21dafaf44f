#include "daemon/commission_devices.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

#include "base/error.h"

namespace gyrobench::daemon {

CommissionDevices::Held::Held(Acquisition& acquisition, Clock::Participant& participant)
    : acquisition_(acquisition), participant_(participant) {
  // The thermometer is not watched meanwhile.
  if (Outputs* outputs = acquisition_.outputs()) outputs->PostAllOff();
  try {
    acquisition_.Hold(participant_);
  } catch (...) {
    acquisition_.Resume();
    throw;
  }
}

// An abort leaves a move to those who stop it.
CommissionDevices::Held::~Held() {
  try {
    acquisition_.OpenAnew(participant_);
  } catch (const std::exception& error) {
    spdlog::warn("after commissioning: {}", error.what());
  }
  acquisition_.Resume();
}

CommissionDevices::CommissionDevices(Context context)
    : context_(std::move(context)),
      axes_(context_.stand.axes),
      held_(context_.acquisition, context_.participant) {
  drivers::DeviceMaker& devices = context_.acquisition.devices();
  for (const config::AxisConfig& axis : axes_) {
    drives_.push_back(devices.MakeAxis(axis));
    encoders_.push_back(devices.MakeAngleSensor(axis));
  }
  gyro_ = devices.MakeGyro(context_.stand.gyro);
  On(context_.stand.gyro.bus, [this] { gyro_identity_ = gyro_->Open(); });
}

// A reply that was lost because a stop hurried is no fault.
void CommissionDevices::On(const std::string& bus, const std::function<void()>& work) {
  context_.control.ThrowIfToEnd();
  try {
    context_.acquisition.OnBus(context_.participant, bus, work);
  } catch (const DeviceError&) {
    context_.control.ThrowIfToEnd();
    throw;
  }
}

int CommissionDevices::PulsesPerTurn(std::size_t drive) {
  config::AxisConfig& axis = axes_[drive];
  On(axis.drive.bus, [&] {
    axis.drive.map.pulses_per_turn = drives_[drive]->PulsesPerTurn();
    drives_[drive] = context_.acquisition.devices().MakeAxis(axis);
    if (drives_[drive]->IsMoving()) drives_[drive]->Stop();
    drives_[drive]->Open();
  });
  return axis.drive.map.pulses_per_turn;
}

void CommissionDevices::StartMove(std::size_t drive, double angle_deg, double rate_deg_s,
                                  double acceleration_deg_s2) {
  On(axes_[drive].drive.bus, [&] {
    context_.control.ThrowIfToEnd();  // nothing moves after a stop
    drives_[drive]->MoveBy(angle_deg, rate_deg_s, acceleration_deg_s2);
  });
}

bool CommissionDevices::IsMoving(std::size_t drive) {
  bool moving = false;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    drivers::AxisState state;
    On(axes_[i].drive.bus, [&] { state = drives_[i]->Read(); });
    RequireFree(axes_[i].name, state);
    if (i == drive) moving = state.moving;
  }
  return moving;
}

void CommissionDevices::RequireFree(const std::string& axis, const drivers::AxisState& state) {
  std::string what;
  if (state.emergency_stop) what = "its emergency stop input acts";
  if (state.limit_plus || state.limit_minus) what = "its limit input acts";
  if (!state.enabled) what = "it is no longer enabled";
  if (state.fault) what = fmt::format("it reports alarm 0x{:02X}", state.alarm);
  if (what.empty()) return;
  throw DeviceError(
      fmt::format("axis.{}: {}: all axes are stopped. Remove the cause, see that nothing is in the "
                  "way, and run commission again",
                  axis, what),
      {.device = "axis." + axis + " drive", .action = "status"});
}

commission::Devices::Angle CommissionDevices::ReadEncoder(std::size_t encoder) {
  drivers::RawAngle raw;
  On(axes_[encoder].encoder.bus, [&] { raw = encoders_[encoder]->ReadRaw(); });
  return {raw.utime, raw.words};
}

void CommissionDevices::ReadRates(std::vector<Rate>* rates) {
  On(context_.stand.gyro.bus, [&] { gyro_->Read(block_); });
  if (std::exchange(boot_count_, block_.boot_count) != block_.boot_count && !rates->empty())
    throw DataError("the gyro's unit started anew while an axis turned: look at its supply");
  if (block_.missed > 0 && !rates->empty()) {
    throw DataError(
        fmt::format("{} samples of the gyro were lost while an axis turned: is its line "
                    "disturbed, or the machine busy?",
                    block_.missed));
  }
  for (const drivers::GyroRawSample& sample : block_.samples) {
    Rate rate{sample.utime - FromSeconds(gyro_identity_.filter_delay_s), {}, {}};
    for (std::size_t a = 0; a < 3; ++a) {
      rate.rate_deg_s[a] = sample.gyro_lsb[a] / gyro_identity_.gyro_lsb_per_deg_s;
      rate.specific_force_g[a] = sample.accel_lsb[a] / gyro_identity_.accel_lsb_per_g;
    }
    rates->push_back(rate);
  }
}

void CommissionDevices::Wait(double duration_s) {
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(duration_s));
}

}  // namespace gyrobench::daemon
