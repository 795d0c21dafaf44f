#include "daemon/commission_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace gyrobench::daemon {

CommissionDevices::CommissionDevices(Context context)
    : context_(std::move(context)), axes_(context_.stand.axes) {
  drivers::DeviceMaker& devices = context_.acquisition.devices();
  for (const config::AxisConfig& axis : axes_) {
    drives_.push_back(devices.MakeAxis(axis));
    encoders_.push_back(devices.MakeAngleSensor(axis));
  }
  gyro_ = devices.MakeGyro(context_.stand.gyro);
  context_.acquisition.Hold(context_.participant);
  try {
    On(context_.stand.gyro.bus, [this] { gyro_identity_ = gyro_->Open(); });
  } catch (...) {
    context_.acquisition.Resume();
    throw;
  }
}

// An abort leaves a move to those who stop it.
CommissionDevices::~CommissionDevices() {
  context_.acquisition.OpenAnew(context_.participant);
  context_.acquisition.Resume();
}

void CommissionDevices::On(const std::string& bus, const std::function<void()>& work) {
  context_.control.ThrowIfToEnd();
  context_.acquisition.OnBus(context_.participant, bus, work);
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
  drivers::AxisState state;
  On(axes_[drive].drive.bus, [&] { state = drives_[drive]->Read(); });
  if (state.fault || !state.enabled) {
    throw DeviceError(
        fmt::format("axis.{}: the drive {} while it turned. See its manual, remove the cause, and "
                    "run commission again",
                    axes_[drive].name,
                    state.fault ? fmt::format("reported alarm 0x{:02X}", state.alarm)
                                : std::string("was no longer enabled")),
        {.device = "axis." + axes_[drive].name, .action = "move"});
  }
  return state.moving;
}

commission::Devices::Angle CommissionDevices::ReadEncoder(std::size_t encoder) {
  drivers::RawAngle raw;
  On(axes_[encoder].encoder.bus, [&] { raw = encoders_[encoder]->ReadRaw(); });
  return {raw.utime, raw.words};
}

void CommissionDevices::ReadRates(std::vector<Rate>* rates) {
  On(context_.stand.gyro.bus, [&] { gyro_->Read(block_); });
  if (block_.missed > 0 && !rates->empty()) {
    throw DataError(
        fmt::format("{} samples of the gyro were lost while an axis turned: is its line "
                    "disturbed, or the machine busy?",
                    block_.missed));
  }
  for (const drivers::GyroRawSample& sample : block_.samples) {
    Rate rate{sample.utime - FromSeconds(gyro_identity_.filter_delay_s), {}};
    for (std::size_t a = 0; a < 3; ++a)
      rate.rate_deg_s[a] = sample.gyro_lsb[a] / gyro_identity_.gyro_lsb_per_deg_s;
    rates->push_back(rate);
  }
}

void CommissionDevices::Wait(double duration_s) {
  // The unit's ring must not run over meanwhile.
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(duration_s));
}

}  // namespace gyrobench::daemon
