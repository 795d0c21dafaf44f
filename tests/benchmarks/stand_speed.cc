// What the virtual stand costs: a gyro sample, and a Modbus transaction on a pseudo-terminal and
// over TCP.
#include <modbus/modbus.h>
#include <pty.h>
#include <stdlib.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "stand/bench_physics.h"
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

using Client = std::unique_ptr<modbus_t, void (*)(modbus_t*)>;

Client Connect(const config::BusConfig& bus) {
  const bool rtu = bus.transport == config::BusConfig::Transport::kRtu;
  Client client(rtu ? modbus_new_rtu(bus.device.c_str(), 115200, 'N', 8, 1)
                    : modbus_new_tcp(bus.host.c_str(), bus.port),
                modbus_free);
  modbus_set_response_timeout(client.get(), 5, 0);
  if (modbus_connect(client.get()) != 0) throw std::runtime_error("cannot connect");
  return client;
}

// Reads the encoder's two registers, and a gyro block of 120 every fifth time, as the acquisition
// does.
double TransactionsPerSecond(modbus_t* client) {
  constexpr int kCount = 20000;
  std::array<std::uint16_t, 120> words;
  const auto begin = Clk::now();
  for (int i = 0; i < kCount; ++i) {
    const bool gyro = i % 5 == 0;
    modbus_set_slave(client, gyro ? 21 : 13);
    const int got = gyro ? modbus_read_input_registers(client, 0x4000, 120, words.data())
                         : modbus_read_registers(client, 0, 2, words.data());
    if (got < 0) throw std::runtime_error("no reply");
  }
  return kCount / Since(begin);
}

double TimeStand(config::BusConfig::Transport transport) {
  const auto clock = MakeVirtualClock(kStart);
  const auto me = clock->Join("benchmark");
  config::StandConfig stand = TestStand();
  for (auto& axis : stand.axes) axis.drive.bus = axis.encoder.bus = "all";
  stand.gyro.bus = "all";
  VirtualStand virtual_stand(stand, config::Scenario{}, 1, *clock);
  config::BusConfig bus;
  bus.name = "all";
  bus.transport = transport;
  const Client client = Connect(virtual_stand.Serve(bus));
  const double rate = TransactionsPerSecond(client.get());
  modbus_close(client.get());
  return rate;
}

// Serves both units until the client's last request.
double TimeBareServer() {
  int master = -1;
  int slave = -1;
  termios raw = {};
  cfmakeraw(&raw);
  if (::openpty(&master, &slave, nullptr, &raw, nullptr) != 0)
    throw std::runtime_error("no terminal");
  std::atomic<bool> stop = false;
  std::thread server([&] {
    const Client context(modbus_new_rtu("/dev/null", 115200, 'N', 8, 1), modbus_free);
    modbus_set_socket(context.get(), master);
    const std::array<int, 2> units = {13, 21};
    modbus_mapping_t* mapping = modbus_mapping_new_start_address(0, 0, 0, 0, 0, 2, 0x4000, 120);
    std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> request;
    // libmodbus answers for one unit at a time; which comes next is known here.
    for (int i = 0; !stop; ++i) {
      modbus_set_slave(context.get(), units[i % 5 == 0 ? 1 : 0]);
      const int size = modbus_receive(context.get(), request.data());
      if (size > 0 && !stop) modbus_reply(context.get(), request.data(), size, mapping);
    }
    modbus_mapping_free(mapping);
  });
  config::BusConfig bus;
  bus.device = ::ptsname(master);
  const Client client = Connect(bus);
  const double rate = TransactionsPerSecond(client.get());
  stop = true;
  [[maybe_unused]] const auto ended = ::write(slave, "stop", 4);
  ::close(slave);
  modbus_close(client.get());
  server.join();
  ::close(master);
  return rate;
}

void TimeTransactions() {
  std::vector<double> shares;
  for (int round = 0; round < 5; ++round) {
    const double bare = TimeBareServer();
    const double stand = TimeStand(config::BusConfig::Transport::kRtu);
    shares.push_back(stand / bare);
    std::printf(
        "pseudo-terminal: stand %8.0f transactions/s, bare libmodbus server %8.0f, share %.2f\n",
        stand, bare, shares.back());
  }
  std::sort(shares.begin(), shares.end());
  std::printf("median share %.2f\n", shares[2]);
  std::printf("TCP: stand %8.0f transactions/s\n", TimeStand(config::BusConfig::Transport::kTcp));
}

}  // namespace

int main() {
  TimeSamples("200 Hz, at rest", 4, false, 0);
  TimeSamples("200 Hz, one axis turning", 4, true, 1);
  TimeSamples("200 Hz, three axes turning", 4, true, 3);
  TimeSamples("1 kHz, one axis turning", 0, true, 1);
  TimeTransactions();
  return 0;
}
