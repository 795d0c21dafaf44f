#include "daemon/power_on.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>

namespace gyrobench::daemon {
namespace {

// Two estimates of one moment differ by what the unit's clock is off, and by a little of the bus.
constexpr double kClockTolerance = 0.02;
constexpr double kTolerance_s = 5.0;

// To the microsecond: two benches that are switched on in the same second are told apart.
std::string NameOf(Utime boot_utime, std::uint32_t serial_number, int boot_count) {
  const auto seconds = static_cast<std::time_t>(boot_utime / kMicrosecondsPerSecond);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:06}Z, sensor {}, start {}", fmt::gmtime(seconds),
                     boot_utime % kMicrosecondsPerSecond, serial_number, boot_count);
}

}  // namespace

// A unit may fail to count a start: then its tick tells, once it is opened again.
bool PowerOnWatch::IsSame(std::uint32_t serial_number, const drivers::GyroBlock& block) const {
  if (boot_count_ != block.boot_count || serial_number_ != serial_number) return false;
  if (!block.boot_utime || !power_on_) return !block.boot_utime;
  const double age_s = ToSeconds(block.utime - power_on_->utime);
  return std::fabs(ToSeconds(*block.boot_utime - power_on_->utime)) <=
         kTolerance_s + kClockTolerance * std::fabs(age_s);
}

void PowerOnWatch::Take(std::uint32_t serial_number, const drivers::GyroBlock& block) {
  if (IsSame(serial_number, block)) return;
  serial_number_ = serial_number;
  boot_count_ = block.boot_count;
  power_on_.reset();
  if (!block.boot_utime) return;
  power_on_ =
      PowerOn{NameOf(*block.boot_utime, serial_number, block.boot_count), *block.boot_utime};
}

}  // namespace gyrobench::daemon
