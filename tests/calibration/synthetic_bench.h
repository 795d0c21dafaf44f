// A stand and a sensor of plain formulas, sent through the door that real measurements come
// through. Written apart from the tracer and from the virtual stand: it shares no code with either,
// so that an effect put into it is an independent witness of what the tracer says.
//
// Geometry: world W with z up, R_WS = Rz(outer) Rx(middle) Rz(inner). Unless asked for, only the
// sensor's z axis has an output, in deg/s.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::testing {

enum TableAxis : std::size_t { kOuterAxis = 0, kMiddleAxis = 1, kInnerAxis = 2 };

// Where the table is.
struct TablePose {
  std::array<double, 3> angle_deg = {};  // outer, middle, inner
  std::array<double, 3> rate_deg_s = {};
};

// One axis moves at a time, with a rate that is smooth enough to be sampled.
class Motion {
 public:
  explicit Motion(double ramp_s = kRamp_s) : ramp_s_(ramp_s) {}
  Motion& Rest(double duration_s);
  // At a constant rate between ramps of ramp_s, and a rest of kPause_s after it.
  Motion& Turn(TableAxis axis, double angle_deg, double rate_deg_s);
  Motion& ThereAndBack(TableAxis axis, double angle_deg, double rate_deg_s);
  // Whole periods of a sine between here and `amplitude_deg` on.
  Motion& Swing(TableAxis axis, double amplitude_deg, double frequency_hz, int periods);

  TablePose At(double t_s) const;
  double duration_s() const { return end_s_; }

  static constexpr double kRamp_s = 0.5, kPause_s = 1.0;

 private:
  enum class Kind { kRest, kTurn, kSwing };
  struct Piece {
    double begin_s = 0.0, duration_s = 0.0;
    Kind kind = Kind::kRest;
    TableAxis axis = kInnerAxis;
    double rate_deg_s = 0.0;                         // turn
    double amplitude_deg = 0.0, frequency_hz = 0.0;  // swing
    std::array<double, 3> from_deg = {};
  };
  void Add(Piece piece, double way_deg);

  double ramp_s_;
  std::vector<Piece> pieces_;
  std::array<double, 3> angle_deg_ = {};
  double end_s_ = 0.0;
};

// Poses, speeds both ways, headings and a swing in some five minutes.
Motion EveryMotion();
// The inner axis alone, z up.
Motion ManySpeeds();

// What the sensor goes through at one time.
struct BenchState {
  double t_s = 0.0;
  TablePose table;
  std::array<double, 3> rate_deg_s = {};  // of the sensor
  std::array<double, 3> g = {};           // specific force [g]
  std::array<double, 3> z_axis_in_world = {};
  double temperature_degC = 0.0, temperature_rate_degC_s = 0.0;
  double vibration_g = 0.0;  // amplitude of a sine on the accelerometer's z axis
  double supply_v = 0.0;
};

struct BenchSensor {
  std::array<double, 3> m_row = {0.006, -0.004, 1.015};
  // Whether x and y have an output as well: without an offset or an effect of their own.
  bool three_channels = false;
  double angle_random_walk_deg_sqrt_s = 0.001;
  double reading_deg = 0.003;  // noise of a reading of the reference
  // What is read of an axis is a whole number of steps from a zero that lies that part of a step
  // beside that of the axis; 0: an encoder without steps.
  double step_deg = 0.0;
  std::array<double, 3> zero_steps = {};
  int reads_resting_axes = 1;      // once in so many of its readings
  double thermometer_degC = 0.02;  // noise of a sample's temperature
  // Where positive the temperature swings by +-5 degC with this period; else it warms up, is cooled
  // by a fan and warms up again.
  double temperature_period_s = 0.0;
};

// What is added to such a bench. Each is called in the order of time.
struct Injection {
  std::function<double(const BenchState&)> rate_deg_s;  // added to the output
  // By how much the gyro's angle leads the reference's: the reading of `axis` shows less.
  std::function<double(const BenchState&)> angle_deg;
  // The time whose angles a reading shows.
  std::function<double(double t_s)> shown_s = {};
  TableAxis axis = kInnerAxis;  // of angle_deg
};

class SyntheticBench {
 public:
  explicit SyntheticBench(Motion motion, const BenchSensor& sensor = {})
      : motion_(std::move(motion)), sensor_(sensor) {}

  BenchState At(double t_s) const;
  // With a column "supply_v" where asked for, and the reference's readings on the gyro's clock.
  calibration::Recording Measure(const Injection& injection, std::uint64_t seed,
                                 bool with_supply = false, double reference_drift_ppm = 0.0) const;
  // Of the channels x and y, where they have an output.
  static constexpr double kOtherScale = 0.99;

  const Motion& motion() const { return motion_; }
  const BenchSensor& sensor() const { return sensor_; }

 private:
  // An angle in the steps of its encoder.
  double Read(double angle_deg, std::size_t axis) const;

  Motion motion_;
  BenchSensor sensor_;
};

}  // namespace gyrobench::testing
