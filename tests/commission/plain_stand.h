// A stand for tests of commissioning: rigid, with a noiseless gyro, written apart from the virtual
// stand and from kinematics.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "commission/probe.h"
#include "config/stand_config.h"

namespace gyrobench::commission {

// What is really there. Of each drive and encoder: which axis it is on (0: outer), and how.
struct Wired {
  std::vector<std::size_t> drive_axis = {0, 1, 2}, encoder_axis = {0, 1, 2};
  std::vector<double> turned_per_commanded = {1.0, 1.0, 1.0};  // below 0: the other way round
  std::vector<double> counts_per_deg = {131072.0 / 360.0, 131072.0 / 360.0, 131072.0 / 360.0};
  std::vector<bool> low_word_first = {false, false, false};
  std::vector<int> pulses_per_turn = {10000, 10000, 10000};
  Eigen::Matrix3d mount = Eigen::Matrix3d::Identity();  // sensor frame into that of the table
  double delay_s = 0.0;                                 // of all encoders
  double play_deg = 0.0;
  // The encoder on axis 1 stays behind by this share of each positive turn.
  double loose = 0.0;
  bool accelerometer = true;
  std::array<std::int64_t, 3> counts_at_mark = {};
  bool flickers = false;  // each encoder, by a count from reading to reading
};

// Axes outer (z), middle (x), inner (z), each from its mark; a move takes its angle over its rate.
class PlainStand final : public Devices {
 public:
  explicit PlainStand(Wired wired) : wired_(std::move(wired)) {}

  int PulsesPerTurn(std::size_t drive) override { return wired_.pulses_per_turn[drive]; }
  void StartMove(std::size_t drive, double angle_deg, double rate_deg_s,
                 double acceleration_deg_s2) override;
  bool IsMoving(std::size_t) override { return now_ < move_.end; }
  Angle ReadEncoder(std::size_t encoder) override;
  void ReadRates(std::vector<Rate>* rates) override;
  void Wait(double duration_s) override { now_ += FromSeconds(duration_s); }
  Utime Now() override { return now_; }
  void Progress(double fraction, std::size_t) override { progress_.push_back(fraction); }
  const std::vector<double>& progress() const { return progress_; }

  double farthest_deg() const { return farthest_deg_; }
  std::function<void()> on_move = [] {};
  double slip = 0.0;  // share of the next move that the shaft does not make

 private:
  struct Motion {
    std::size_t axis = 0;
    Utime begin = 0, end = 0;
    double from_deg = 0.0, to_deg = 0.0;
    double loosened_deg = 0.0;  // by which the loose encoder stays behind from then on
  };
  double AngleAt(std::size_t axis, Utime at) const;

  const Wired wired_;
  std::vector<double> progress_;
  Utime now_ = 1'000'000'000, read_until_ = 1'000'000'000;
  Motion move_;
  std::array<double, 3> angle_deg_ = {};
  std::array<double, 3> shaft_deg_ = {};  // the table follows within its play
  double behind_deg_ = 0.0, farthest_deg_ = 0.0;
  int readings_ = 0;
};

// A stand file of three axes that is right for a Wired{}.
std::vector<config::AxisConfig> PlainAxes();

}  // namespace gyrobench::commission
