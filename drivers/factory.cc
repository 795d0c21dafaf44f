#include "drivers/factory.h"

#include "drivers/encoder.h"
#include "drivers/gyro_unit.h"
#include "drivers/relay_unit.h"
#include "drivers/stepper_axis.h"

namespace gyrobench::drivers {

std::unique_ptr<Axis> MakeAxis(const config::AxisConfig& config, ModbusBus& bus) {
  return std::make_unique<StepperAxis>(config, bus);
}

std::unique_ptr<AngleSensor> MakeAngleSensor(const config::AxisConfig& config, ModbusBus& bus) {
  return std::make_unique<Encoder>(config, bus);
}

std::unique_ptr<Gyro> MakeGyro(const config::GyroConfig& config, ModbusBus& bus) {
  return std::make_unique<GyroUnit>(config, bus);
}

std::unique_ptr<Relays> MakeRelays(const config::RelaysConfig& config, ModbusBus& bus) {
  return std::make_unique<RelayUnit>(config, bus);
}

}  // namespace gyrobench::drivers
