// What a driver's read costs over the bare libmodbus call of the same size on the same line.
//
// Both are made in turn, in one process, against one server; compared are medians over batches, so
// that what disturbs the machine disturbs both. The server's share of the time is in both.
#include <fmt/format.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "base/clock.h"
#include "drivers/factory.h"
#include "drivers/modbus_bus.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/gyro_unit_model.h"

namespace gyrobench {
namespace {

constexpr double kMostAllowed = 1.15;
constexpr int kMostBatches = 1600;
constexpr int kCallsPerBatch = 10;
constexpr std::chrono::seconds kMostTime{6};  // a line of the table, on a busy machine
constexpr int kGyroUnit = 21, kBareGyroUnit = 22, kEncoderUnit = 11;

struct ModbusFree {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};

class BareLine {
 public:
  explicit BareLine(const config::BusConfig& bus)
      : context_(bus.transport == Transport::kTcp
                     ? modbus_new_tcp(bus.host.c_str(), bus.port)
                     : modbus_new_rtu(bus.device.c_str(), bus.baud, bus.parity, 8, bus.stop_bits)) {
    if (context_ == nullptr || modbus_connect(context_.get()) != 0) {
      throw std::runtime_error("bare libmodbus cannot connect");
    }
  }
  void Read(int unit, int function, int address, int count) {
    modbus_set_slave(context_.get(), unit);
    const int read =
        function == 3 ? modbus_read_registers(context_.get(), address, count, words_.data())
                      : modbus_read_input_registers(context_.get(), address, count, words_.data());
    if (read != count) throw std::runtime_error(modbus_strerror(errno));
  }

 private:
  std::unique_ptr<modbus_t, ModbusFree> context_;
  std::array<std::uint16_t, 125> words_ = {};
};

double BatchMicroseconds(const std::function<void()>& call) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kCallsPerBatch; ++i) call();
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
  return took.count() / kCallsPerBatch;
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Prints a line of the table; true when within what is allowed.
bool Compare(const char* line, const char* what, const std::function<void()>& bare,
             const std::function<void()>& driver) {
  std::vector<double> bare_us, driver_us, ratios;
  const auto start = std::chrono::steady_clock::now();
  for (int batch = -10; batch < kMostBatches; ++batch) {
    if (batch > 0 && std::chrono::steady_clock::now() - start > kMostTime) break;
    const bool bare_first = batch % 2 == 0;
    const double first = BatchMicroseconds(bare_first ? bare : driver);
    const double second = BatchMicroseconds(bare_first ? driver : bare);
    if (batch < 0) continue;  // warming up
    bare_us.push_back(bare_first ? first : second);
    driver_us.push_back(bare_first ? second : first);
    ratios.push_back(driver_us.back() / bare_us.back());
  }
  const double ratio = Median(ratios);
  const bool good = ratio <= kMostAllowed;
  fmt::print("{:<13} {:<28} {:>9.2f} {:>11.2f} {:>8.3f} {:>8.2f}  {}\n", line, what,
             Median(bare_us), Median(driver_us), ratio, kMostAllowed, good ? "PASS" : "FAIL");
  return good;
}

bool CompareOn(Transport transport) {
  const bool tcp = transport == Transport::kTcp;
  // Two of the kind, so that each call finds 14 new samples and costs the server the same.
  GyroUnitModel unit, bare_unit;
  unit.TakeOnDemand(14);
  bare_unit.TakeOnDemand(14);
  RegisterUnit encoder_unit;
  encoder_unit.SetHolding(0, {0x0001, 0x2345});
  FakeLine line(transport);
  line.Connect(kGyroUnit, unit);
  line.Connect(kBareGyroUnit, bare_unit);
  line.Connect(kEncoderUnit, encoder_unit);

  const auto clock = MakeSystemClock();
  const auto participant = clock->Join("bus", Clock::Role::kResident);
  config::BusConfig bus_config = line.Config();
  bus_config.response_timeout_s = 5.0;
  drivers::ModbusBus bus(bus_config, *clock, *participant);
  config::GyroConfig gyro_config;
  gyro_config.map = GyroMapOfThePage();
  const auto gyro = MakeGyro(gyro_config, bus);
  gyro->Open();
  config::AxisConfig axis;
  axis.name = "inner";
  axis.encoder.unit = kEncoderUnit;
  axis.encoder.map.words = 2;
  axis.encoder.map.counts_per_turn = 131072;
  axis.encoder.map.range_counts = std::uint64_t{1} << 29;
  const auto encoder = MakeAngleSensor(axis, bus);
  encoder->Open();

  BareLine bare(bus_config);
  drivers::GyroBlock block;
  gyro->Read(block);
  const auto read_gyro = [&] {
    gyro->Read(block);
    if (block.samples.size() != 14) throw std::runtime_error("the gyro's block is not full");
  };
  int bare_next = 0;
  const auto read_gyro_bare = [&] {
    bare.Read(kBareGyroUnit, 4, 0x4000 + bare_next % 0x4000, 120);
    bare_next += 14;
  };
  const char* name = tcp ? "TCP loopback" : "RTU pty";
  const bool gyro_good = Compare(name, "Gyro::Read, 14 samples", read_gyro_bare, read_gyro);
  const bool encoder_good = Compare(
      name, "AngleSensor::Read, 2 words", [&] { bare.Read(kEncoderUnit, 3, 0, 2); },
      [&] { encoder->Read(); });
  return gyro_good && encoder_good;
}

int Run() {
  fmt::print(
      "A driver's read against bare libmodbus: medians of up to {} batches of {} calls, in turn.\n",
      kMostBatches, kCallsPerBatch);
  fmt::print("{:<13} {:<28} {:>9} {:>11} {:>8} {:>8}\n", "line", "read", "bare [us]", "driver [us]",
             "ratio", "at most");
  const bool rtu = CompareOn(Transport::kRtu);
  const bool tcp = CompareOn(Transport::kTcp);
  return rtu && tcp ? 0 : 1;
}

}  // namespace
}  // namespace gyrobench

int main() {
  try {
    return gyrobench::Run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
