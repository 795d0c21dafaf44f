#include "tests/calibration/simulated_run.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

namespace gyrobench::testing {
namespace {

double RampTime(const TurnSchedule& s) {
  return std::min(s.rate_deg_s / s.acceleration_deg_s2,
                  std::sqrt(s.angle_deg / s.acceleration_deg_s2));
}

// Turn number (before the first: -1) and time since its begin.
struct Place {
  int turn = -1;
  double since_s = 0.0;
};

Place PlaceOf(const TurnSchedule& schedule, double t_s) {
  const double cycle_s = schedule.TurnTime() + schedule.rest_s;
  const double since_s = t_s - schedule.rest_s;
  if (since_s < 0) return {};
  const int turn = std::min(schedule.turns - 1, static_cast<int>(since_s / cycle_s));
  return {turn, since_s - turn * cycle_s};
}

double Sign(const TurnSchedule& schedule, int turn) {
  return schedule.back_and_forth && turn % 2 == 1 ? -1.0 : 1.0;
}

double StopAngle(const TurnSchedule& schedule, int stops) {
  if (schedule.back_and_forth) return stops % 2 == 1 ? schedule.angle_deg : 0.0;
  return stops * schedule.angle_deg;
}

// Trapezoid profile, from rest to rest.
double TurnedBy(const TurnSchedule& s, double since_s) {
  const double ramp_s = RampTime(s), whole_s = s.TurnTime(), a = s.acceleration_deg_s2;
  if (since_s <= 0) return 0.0;
  if (since_s >= whole_s) return s.angle_deg;
  if (since_s < ramp_s) return 0.5 * a * since_s * since_s;
  if (since_s > whole_s - ramp_s)
    return s.angle_deg - 0.5 * a * (whole_s - since_s) * (whole_s - since_s);
  return 0.5 * a * ramp_s * ramp_s + a * ramp_s * (since_s - ramp_s);
}

class Noise {
 public:
  Noise(const SimulatedSensor& sensor, std::uint64_t seed)
      : random_(seed),
        white_(sensor.n * std::sqrt(sensor.gyro_rate_hz)),
        walk_(sensor.k / std::sqrt(sensor.gyro_rate_hz)) {}
  double Normal(double sigma) { return sigma * normal_(random_); }
  double Uniform(double half) {
    return std::uniform_real_distribution<double>(-half, half)(random_);
  }
  // Noise of the next sample [deg/s].
  double Sample() {
    const double out = bias_ + Normal(white_);
    bias_ += Normal(walk_);
    return out;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double white_, walk_, bias_ = 0.0;
};

MeasurementInfo InfoFor(const SimulatedSensor& sensor) {
  MeasurementInfo info;
  info.source = "simulated";
  info.gyro_present = {false, false, true};
  info.gyro_units_per_deg_s = sensor.nominal_lsb_per_deg_s;
  if (sensor.stop_accuracy_known) info.stop_accuracy_deg = sensor.stop_half_width_deg;
  return info;
}

}  // namespace

double TurnSchedule::TurnTime() const {
  const double ramp_s = RampTime(*this);
  return 2.0 * ramp_s +
         (angle_deg - acceleration_deg_s2 * ramp_s * ramp_s) / (acceleration_deg_s2 * ramp_s);
}

double TableAngle(const TurnSchedule& schedule, double t_s) {
  const Place place = PlaceOf(schedule, t_s);
  if (place.turn < 0) return 0.0;
  return StopAngle(schedule, place.turn) +
         Sign(schedule, place.turn) * TurnedBy(schedule, place.since_s);
}

void SimulateTurns(const TurnSchedule& schedule, const SimulatedSensor& sensor, std::uint64_t seed,
                   MeasurementSink* sink, const std::function<void()>& segment_end) {
  Noise noise(sensor, seed);
  MeasurementInfo info = InfoFor(sensor);
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  sink->OnInfo(info);
  std::vector<double> stop_error(static_cast<std::size_t>(schedule.turns) + 1);
  for (double& error : stop_error) error = noise.Uniform(sensor.stop_half_width_deg);
  const double step_s = 1.0 / sensor.gyro_rate_hz;
  double next_reading_s = 0.001;
  int place_before = 0;
  for (int i = 0; i * step_s < schedule.Duration(); ++i) {
    const double t_s = i * step_s;
    while (next_reading_s <= t_s) {
      const double at_s = next_reading_s - sensor.latency_s;
      const Place place = PlaceOf(schedule, at_s);
      // The error passes from one stop's to the next's while the table turns.
      const double part =
          place.turn < 0 ? 0.0 : TurnedBy(schedule, place.since_s) / schedule.angle_deg;
      const auto from = static_cast<std::size_t>(std::max(0, place.turn));
      const double error =
          stop_error[from] +
          part * (stop_error[std::min(from + 1, stop_error.size() - 1)] - stop_error[from]);
      sink->OnAngle({next_reading_s, 2,
                     TableAngle(schedule, at_s) + error + noise.Normal(sensor.reading_noise_deg)});
      next_reading_s += 1.0 / sensor.reference_rate_hz;
    }
    GyroSample sample;
    sample.t_s = t_s;
    const double turned_deg = TableAngle(schedule, t_s) - TableAngle(schedule, t_s - step_s);
    const double rate =
        (1.0 + sensor.scale_error) * turned_deg / step_s + sensor.bias_deg_s + noise.Sample();
    sample.xi[2] = std::round(rate * sensor.nominal_lsb_per_deg_s);
    sink->OnGyro(sample);
    const Place now = PlaceOf(schedule, t_s);
    const int place_now = 2 * now.turn + (now.since_s > schedule.TurnTime() ? 1 : 0);
    if (segment_end && i > 0 && place_now != place_before) segment_end();
    place_before = place_now;
  }
}

double ScaleBound(const TurnSchedule& schedule, const SimulatedSensor& sensor) {
  std::vector<DenseInterval> intervals;
  std::vector<double> rotation;
  const int pieces = 4;
  double t_s = 0.0;
  for (int stop = 0; stop <= schedule.turns; ++stop) {
    for (int i = 0; i < pieces; ++i, t_s += schedule.rest_s / pieces) {
      intervals.push_back({t_s, t_s + schedule.rest_s / pieces});
      rotation.push_back(0.0);
    }
    if (stop == schedule.turns) break;
    intervals.push_back({t_s, t_s + schedule.TurnTime(), stop, stop + 1});
    rotation.push_back(Sign(schedule, stop) * schedule.angle_deg);
    t_s += schedule.TurnTime();
  }
  const auto n = static_cast<Eigen::Index>(intervals.size());
  Eigen::MatrixXd x(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto index = static_cast<std::size_t>(i);
    x(i, 0) = rotation[index];
    x(i, 1) = intervals[index].end_s - intervals[index].begin_s;
  }
  // The gain of the reference's error in the output is the scale factor.
  const double gain = 1.0 + sensor.scale_error;
  const DenseNoise noise{sensor.n, sensor.k, gain * sensor.stop_half_width_deg / std::sqrt(3.0)};
  const DenseSolution solution =
      SolveDense(DenseCovariance(intervals, noise), x, Eigen::VectorXd::Zero(n));
  return std::sqrt(solution.covariance(0, 0)) / gain;
}

double WarmUp::Temperature(double t_s) const {
  return end_degC - (end_degC - start_degC) * std::exp(-t_s / tau_s);
}

double WarmUp::Beta(double temperature_degC) const {
  double sum = 0.0;
  for (std::size_t i = beta_deg_s.size(); i-- > 0;)
    sum = sum * (temperature_degC - 30.0) + beta_deg_s[i];
  return sum;
}

void SimulateWarmUp(const WarmUp& warm_up, const SimulatedSensor& sensor, std::uint64_t seed,
                    MeasurementSink* sink) {
  Noise noise(sensor, seed);
  MeasurementInfo info = InfoFor(sensor);
  info.temperature_present = true;
  sink->OnInfo(info);
  const double step_s = 1.0 / sensor.gyro_rate_hz;
  for (int i = 0; i * step_s < warm_up.duration_s; ++i) {
    GyroSample sample;
    sample.t_s = i * step_s;
    const double temperature = warm_up.Temperature(sample.t_s);
    sample.temperature_degC =
        std::round((temperature + noise.Normal(warm_up.thermometer_noise_degC)) * 340.0) / 340.0;
    sample.xi[2] =
        std::round((warm_up.Beta(temperature) + noise.Sample()) * sensor.nominal_lsb_per_deg_s);
    sink->OnGyro(sample);
  }
}

double CurveBound(const WarmUp& warm_up, const SimulatedSensor& sensor) {
  const double piece_s = 1.0;
  const auto n = static_cast<Eigen::Index>(warm_up.duration_s / piece_s);
  const auto p = static_cast<Eigen::Index>(warm_up.beta_deg_s.size());
  const double middle = 0.5 * (warm_up.Temperature(0.0) + warm_up.Temperature(warm_up.duration_s));
  const double half = middle - warm_up.Temperature(0.0);
  std::vector<DenseInterval> intervals;
  Eigen::MatrixXd x(n, p);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double begin_s = piece_s * static_cast<double>(i);
    intervals.push_back({begin_s, begin_s + piece_s});
    const double u = (warm_up.Temperature(begin_s + 0.5 * piece_s) - middle) / half;
    for (Eigen::Index j = 0; j < p; ++j) x(i, j) = std::pow(u, j) * piece_s;
  }
  const DenseSolution solution = SolveDense(DenseCovariance(intervals, {sensor.n, sensor.k, 0.0}),
                                            x, Eigen::VectorXd::Zero(n));
  double square = 0.0;
  const int points = 101;
  for (int k = 0; k < points; ++k) {
    const double u = -1.0 + 2.0 * k / (points - 1);
    Eigen::VectorXd powers(p);
    for (Eigen::Index j = 0; j < p; ++j) powers(j) = std::pow(u, j);
    square += powers.dot(solution.covariance * powers);
  }
  return std::sqrt(square / points);
}

}  // namespace gyrobench::testing
