// An MPU-6050 as its registers show it on the two-wire bus.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

namespace gyrobench::firmware {

// What of RM-MPU-6000A (rev. 4.2) the unit's firmware touches, and the sensor's own clock: asleep
// after power-on, output at 8 kHz with filter 0 and 7 and else at 1 kHz, a sample of each 1 +
// SMPLRT_DIV outputs. A burst of the 14 data bytes is of one sample. The unit keeps to the master's
// side of the bus; times are seconds since power-on.
class VirtualMpu6050 {
 public:
  struct Settings {
    int gyro_range = 0;   // 0 to 3: 250 to 2000 deg/s
    int accel_range = 0;  // 0 to 3: 2 to 16 g
    int filter = 0;       // DLPF_CFG
    double rate_hz = 1000.0;
    bool operator==(const Settings&) const = default;
  };
  // Accelerometer x, y, z, temperature, gyro x, y, z.
  using Words = std::array<std::int16_t, 7>;
  // The sample that is ready at `t_s`.
  using Source = std::function<Words(double t_s, const Settings&)>;

  // `clock_rel`: the sensor's clock runs so much too fast.
  explicit VirtualMpu6050(Source source, double clock_rel = 0.0)
      : source_(std::move(source)), clock_rel_(clock_rel) {}

  // As from power-on: all settings are gone, and it sleeps.
  void Reset();
  // Nothing answers, as with the sensor's plug pulled; when it is back it has lost its settings.
  void SetPresent(bool present);
  bool present() const { return present_; }
  void SetWhoAmI(std::uint8_t value) { who_am_i_ = value; }

  // The bus's master side.
  void Begin() { pointer_given_ = false; }
  void Write(std::uint8_t byte, double now_s);
  std::uint8_t Read();

  // When the next sample is ready, at or after which MakeReady is called; none while it sleeps or
  // raises no interrupt.
  std::optional<double> next_ready_s() const { return next_s_; }
  void MakeReady();
  Settings settings() const;

 private:
  void Schedule(double now_s);
  double Period_s() const;

  Source source_;
  double clock_rel_;
  bool present_ = true;
  std::uint8_t who_am_i_ = 0x68;
  std::array<std::uint8_t, 128> registers_ = PowerOnRegisters();
  std::uint8_t pointer_ = 0;
  bool pointer_given_ = false;
  std::optional<double> next_s_;

  static std::array<std::uint8_t, 128> PowerOnRegisters();
};

}  // namespace gyrobench::firmware
