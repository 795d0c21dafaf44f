// What the virtual stand costs: a gyro sample, and a Modbus transaction on a pseudo-terminal and
// over TCP.
#include <modbus/modbus.h>
#include <time.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/clock.h"
#include "stand/bench_physics.h"
#include "stand/specimen.h"
#include "stand/virtual_stand.h"
#include "tests/stand/test_stand.h"

namespace {

using namespace gyrobench;
using namespace gyrobench::stand;
using Clk = std::chrono::steady_clock;

// Of this process: what other programs do does not count.
double Cpu_s() {
  timespec now = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Since(Clk::time_point begin) {
  return std::chrono::duration<double>(Clk::now() - begin).count();
}

void TimeSamples(const char* what, int divider, bool moving, int axes) {
  Physics physics(TestStand(), DrawSpecimen(config::Scenario{}, 1), 1, kStart);
  physics.WithGyro(kStart, [&](GyroSampler& gyro, double t) { gyro.Set(t, {.divider = divider}); });
  const double kBench_s = 1800;
  if (moving) {
    for (int axis = 0; axis < axes; ++axis) {
      physics.MoveBy(static_cast<std::size_t>(axis), kStart, 1'000'000'000, TestMove(133));
    }
  }
  const double begin_s = Cpu_s();
  for (double t = 0; t < kBench_s; t += 0.05) physics.AdvanceTo(At(t));
  const double real_s = Cpu_s() - begin_s;
  const double samples = kBench_s * 1000 / (1 + divider);
  std::printf("%-34s %8.0f ns a sample %10.0f x real time\n", what, real_s / samples * 1e9,
              kBench_s / real_s);
}

void TimeTransactions(config::BusConfig::Transport transport) {
  const auto clock = MakeVirtualClock(kStart);
  const auto me = clock->Join("benchmark");
  config::StandConfig stand = TestStand();
  for (auto& axis : stand.axes) axis.drive.bus = axis.encoder.bus = "all";
  stand.gyro.bus = "all";
  VirtualStand virtual_stand(stand, config::Scenario{}, 1, *clock);
  config::BusConfig bus;
  bus.name = "all";
  bus.transport = transport;
  const auto served = virtual_stand.Serve(bus);
  const bool rtu = transport == config::BusConfig::Transport::kRtu;
  const std::unique_ptr<modbus_t, void (*)(modbus_t*)> client(
      rtu ? modbus_new_rtu(served.device.c_str(), 115200, 'N', 8, 1)
          : modbus_new_tcp(served.host.c_str(), served.port),
      modbus_free);
  if (modbus_connect(client.get()) != 0) throw std::runtime_error("cannot connect");
  std::array<std::uint16_t, 120> words;
  const auto read = [&](int unit, int function, int count) {
    modbus_set_slave(client.get(), unit);
    const int got = function == 3
                        ? modbus_read_registers(client.get(), 0, count, words.data())
                        : modbus_read_input_registers(client.get(), 0x4000, count, words.data());
    if (got != count) throw std::runtime_error("no reply");
  };
  for (const bool gyro : {false, true}) {
    constexpr int kCount = 30000;
    const auto begin = Clk::now();
    for (int i = 0; i < kCount; ++i) gyro ? read(21, 4, 120) : read(13, 3, 2);
    std::printf("%-34s %8.0f transactions/s\n",
                (std::string(rtu ? "pseudo-terminal" : "TCP") +
                 (gyro ? ", gyro block of 120" : ", encoder"))
                    .c_str(),
                kCount / Since(begin));
  }
  modbus_close(client.get());
}

}  // namespace

int main() {
  TimeSamples("200 Hz, at rest", 4, false, 0);
  TimeSamples("200 Hz, one axis turning", 4, true, 1);
  TimeSamples("200 Hz, three axes turning", 4, true, 3);
  TimeSamples("1 kHz, one axis turning", 0, true, 1);
  TimeTransactions(config::BusConfig::Transport::kRtu);
  TimeTransactions(config::BusConfig::Transport::kTcp);
  return 0;
}
