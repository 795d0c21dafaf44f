// How much faster than real time the virtual stand runs over Modbus, with the gyro at 200 Hz and
// the reference at 50 Hz (config/one-axis.toml), and which share that is of what the same number of
// bare libmodbus transactions on a pseudo-terminal would allow.
#include <fcntl.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/lcm_publisher.h"
#include "daemon/notices.h"
#include "daemon/simulated_buses.h"
#include "daemon/telemetry.h"
#include "drivers/factory.h"

namespace {

using gyrobench::Utime;
namespace fs = std::filesystem;
using Seconds = std::chrono::duration<double>;

constexpr Utime kStart = 1'700'000'000'000'000;
constexpr int kEncoderReply = 2;  // registers
constexpr int kGyroReply = 120;   // registers

struct Speed {
  double real_s = 0.0;
  double transactions = 0.0;
};

// The daemon's acquisition with record and LCM, without a run engine.
Speed RunVirtualStand(double bench_s) {
  gyrobench::config::StandConfig stand = gyrobench::config::LoadStandConfig(
      std::string(GYROBENCH_SOURCE_DIR) + "/config/one-axis.toml");
  const auto clock = gyrobench::MakeVirtualClock(kStart);
  auto me = clock->Join("benchmark");
  const auto simulated = gyrobench::daemon::MakeSimulatedBuses(stand, *clock);
  stand.buses = simulated->buses();
  gyrobench::daemon::LcmPublisher publisher("udpm://239.255.76.67:7699?ttl=0", "GYROBENCH");
  const auto complain = [](const gyrobench::daemon::Fault& fault) {
    std::fprintf(stderr, "%s: %s\n", fault.source.c_str(), fault.message.c_str());
  };
  gyrobench::daemon::Telemetry telemetry(publisher, [&](const std::string& message) {
    complain({"record", message});
  });
  gyrobench::drivers::ModbusDevices devices(*clock);
  gyrobench::daemon::Notices notices;
  gyrobench::daemon::Acquisition acquisition(stand, *clock, devices, telemetry, complain, complain,
                                             notices);
  acquisition.SetActiveAxes({stand.axes.front().name});
  acquisition.Start();
  me->WaitUntil(kStart + 2'000'000);

  const fs::path log =
      fs::temp_directory_path() / ("gyrobench-speed-" + std::to_string(::getpid()));
  telemetry.BeginRun("speed", log.string(), acquisition.Info(), clock->Now());
  const auto begin = std::chrono::steady_clock::now();
  me->WaitUntil(clock->Now() + gyrobench::FromSeconds(bench_s));
  const double real_s = Seconds(std::chrono::steady_clock::now() - begin).count();
  telemetry.EndRun();
  me.reset();  // holds no time while the buses end what they are doing
  acquisition.Stop();
  fs::remove(log);
  return {real_s, static_cast<double>(devices.Transactions())};
}

// A server that answers any read with zeros: as little work as a reply can be.
class BareServer {
 public:
  BareServer() {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY);
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    thread_ = std::thread([this] { Serve(); });
  }
  ~BareServer() {
    stop_ = true;
    thread_.join();
    ::close(master_);
  }
  const char* device() const { return ::ptsname(master_); }

 private:
  void Serve() {
    modbus_t* context = modbus_new_rtu("/dev/null", 115200, 'N', 8, 1);
    modbus_set_slave(context, 1);
    modbus_set_socket(context, master_);
    modbus_mapping_t* mapping = modbus_mapping_new(0, 0, 0, 125);
    std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> request{};
    while (!stop_) {
      pollfd ready{master_, POLLIN, 0};
      if (::poll(&ready, 1, 50) <= 0 || (ready.revents & POLLIN) == 0) continue;
      const int size = modbus_receive(context, request.data());
      if (size > 0) modbus_reply(context, request.data(), size, mapping);
    }
    modbus_mapping_free(mapping);
    modbus_free(context);
  }

  int master_ = -1;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

// The same number of transactions with replies of the same sizes, one client thread, one server
// thread.
double RunBare(int transactions, double gyro_share) {
  BareServer server;
  modbus_t* context = modbus_new_rtu(server.device(), 115200, 'N', 8, 1);
  modbus_set_slave(context, 1);
  modbus_set_response_timeout(context, 2, 0);
  if (modbus_connect(context) != 0) throw std::runtime_error("cannot open the pseudo-terminal");
  std::array<std::uint16_t, 125> registers{};
  double owed = 0.0;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < transactions; ++i) {
    owed += gyro_share;
    const bool gyro = owed >= 1.0;
    if (gyro) owed -= 1.0;
    modbus_flush(context);
    if (modbus_read_input_registers(context, 0, gyro ? kGyroReply : kEncoderReply,
                                    registers.data()) < 0) {
      throw std::runtime_error(modbus_strerror(errno));
    }
  }
  const double real_s = Seconds(std::chrono::steady_clock::now() - begin).count();
  modbus_close(context);
  modbus_free(context);
  return real_s;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void Compare(double bench_s) {
  constexpr int kRounds = 5;
  constexpr double kGyroPollsPerSecond = 200.0 / 13.0;
  std::vector<double> speeds;
  std::vector<double> shares;
  std::printf(
      "virtual stand over Modbus RTU, gyro 200 Hz, reference 50 Hz, %.0f s of bench time a round\n",
      bench_s);
  std::printf("%6s %14s %12s %12s %14s %8s\n", "round", "transactions", "stand s", "bare s",
              "x real time", "share");
  for (int round = 0; round < kRounds; ++round) {
    const Speed stand = RunVirtualStand(bench_s);
    const double gyro_share = kGyroPollsPerSecond * bench_s / stand.transactions;
    const double bare_s = RunBare(static_cast<int>(stand.transactions), gyro_share);
    speeds.push_back(bench_s / stand.real_s);
    shares.push_back(bare_s / stand.real_s);
    std::printf("%6d %14.0f %12.3f %12.3f %14.0f %7.0f%%\n", round + 1, stand.transactions,
                stand.real_s, bare_s, speeds.back(), 100 * shares.back());
  }
  std::printf("median %62.0f %7.0f%%   (wanted: at least 150, at least 70%%)\n", Median(speeds),
              100 * Median(shares));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    Compare(argc > 1 ? std::stod(argv[1]) : 600.0);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_virtual_stand: %s\n", error.what());
    return 1;
  }
}
