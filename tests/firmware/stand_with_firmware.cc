// gyrobench-stand with the firmware's image in an emulated processor in place of its own gyro unit.
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "base/clock.h"
#include "stand/stand_program.h"
#include "tests/firmware/emulation/emulated_gyro_device.h"

namespace gyrobench::firmware {
namespace {

// Goes on between the requests as well.
class RunningUnit final : public stand::Device {
 public:
  RunningUnit(const config::StandConfig& stand, stand::Physics& physics, Utime start)
      : Device("gyro"),
        unit_(GYROBENCH_FIRMWARE_IMAGE, stand.gyro.map, physics, start),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  stand::ModbusException Read(int function, std::uint16_t address, std::span<std::uint16_t> words,
                              Utime at) override {
    return unit_.Read(function, address, words, at);
  }
  stand::ModbusException Write(std::uint16_t address, std::span<const std::uint16_t> words,
                               Utime at) override {
    return unit_.Write(address, words, at);
  }
  stand::ModbusException Disguise(std::uint16_t address, std::span<std::uint16_t> words) override {
    return unit_.Disguise(address, words);
  }

 private:
  void Run(const std::stop_token& stop) {
    constexpr std::chrono::milliseconds kStep{5};
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      unit_.CatchUp(clock_->Now());
      stopped_.wait_for(lock, stop, kStep, [] { return false; });
    }
  }

  std::unique_ptr<Clock> clock_ = MakeSystemClock();
  EmulatedGyroDevice unit_;
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::jthread thread_;  // the last: it ends before what it uses
};

}  // namespace
}  // namespace gyrobench::firmware

int main(int argc, char** argv) {
  using namespace gyrobench;
  return stand::RunStandProgram(
      argc, argv, [](const config::StandConfig& stand, stand::Physics& physics, Utime start) {
        return std::make_unique<firmware::RunningUnit>(stand, physics, start);
      });
}
