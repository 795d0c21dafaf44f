#include "tests/blind_trials/vector_trial.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <cmath>
#include <exception>

#include "calibration/trace/trace.h"
#include "tests/blind_trials/corrected_elsewhere.h"
#include "tests/blind_trials/vector_bound.h"

namespace gyrobench::blind_trials {
namespace {

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using calibration::VectorCalibration;

constexpr double kGravitySpread_deg_s_per_g = 0.03;
constexpr double kUnits = 131.0;

std::string Element(std::size_t i, std::size_t j) {
  return {static_cast<char>('x' + i), static_cast<char>('x' + j)};
}

class Comparison {
 public:
  Comparison(const TrialSpec& spec, const TruePart& part, const calibration::Traced& traced,
             VectorOutcome& out)
      : part_(part), traced_(traced), vector_(traced.result.vector), out_(out) {
    if (!spec.mount_known) TurnPart(MountOf(spec));
    bounds_ = VectorBound(spec, traced.models.front().reference_degC);
    // The mean temperature, of what can be used of a channel: the same, unless some cannot.
    for (std::size_t c = 1; c < 3; ++c) {
      const double own_degC = traced.models.at(c).reference_degC;
      if (own_degC != traced.models.front().reference_degC)
        bounds_[c] = VectorBound(spec, own_degC)[c];
    }
  }

  void Run() {
    Matrix();
    for (std::size_t c = 0; c < 3; ++c) Bias(c);
    Gravity();
    Accelerometer();
  }

 private:
  // What a mounting that nobody knows of makes of it.
  void TurnPart(const Eigen::Matrix3d& mount) {
    for (config::Square* square : {&part_.m, &part_.g_linear, &part_.accel_m}) {
      const RowMajor turned = Eigen::Map<const RowMajor>(square->data()) * mount.transpose();
      Eigen::Map<RowMajor>(square->data()) = turned;
    }
  }
  double Bound(std::size_t channel, std::size_t parameter) const {
    const auto k = static_cast<Eigen::Index>(parameter);
    return std::sqrt(bounds_[channel](k, k));
  }
  void Add(const char* group, std::string name, double estimate, double truth, double std_error,
           double bound = kMissing) {
    out_.numbers.push_back({group, std::move(name), estimate, truth, std_error, bound});
  }

  void Matrix() {
    if (!vector_.matrix) {
      out_.failure = fmt::format("no matrix: {}", fmt::join(vector_.missing, "; "));
      return;
    }
    const RowMajor m = Eigen::Map<const RowMajor>(part_.m.data());
    const RowMajor b = m.inverse();
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
        Add("M", Element(i, j), vector_.matrix->m[i][j], m(row, column),
            vector_.matrix->m_std_error[i][j], Bound(i, j));
        // Errors of rows do not depend on each other: dA_ij = - sum_k B_ik (dM_k. B_.j) / s0
        double variance = 0.0;
        for (std::size_t k = 0; k < 3; ++k)
          variance += std::pow(b(row, static_cast<Eigen::Index>(k)), 2) *
                      b.col(column).dot(bounds_[k].topLeftCorner<3, 3>() * b.col(column));
        Add("A", Element(i, j), vector_.matrix->a[i][j], b(row, column) / kUnits,
            vector_.matrix->a_std_error[i][j], std::sqrt(variance) / kUnits);
      }
    }
  }

  // The true polynomial about the calibration's T0: sum_k b_k (T - T1)^k, T - T1 = (T - T0) + d.
  double TrueBias(std::size_t channel, std::size_t order, double d) const {
    double sum = 0.0, factor = 1.0;  // of (k over order) d^(k - order)
    for (std::size_t k = order; k < part_.bias.size(); ++k) {
      sum += part_.bias[k][channel] * factor;
      factor *= d * static_cast<double>(k + 1) / static_cast<double>(k + 1 - order);
    }
    return sum;
  }

  void Bias(std::size_t c) {
    const calibration::ChannelModel& model = traced_.models.at(c);
    const double d = model.reference_degC - part_.reference_degC;
    const auto& parameters = traced_.result.channels.at(c).baseline.parameters;
    for (std::size_t k = 0; k < model.bias_deg_s.size(); ++k) {
      Add("b", fmt::format("{}{}", "xyz"[c], k), model.bias_deg_s[k], TrueBias(c, k, d),
          parameters.at(3 + k).std_error, Bound(c, 3 + k));
    }
  }

  void Gravity() {
    const auto& g = *vector_.g_sensitivity;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        Add("g-sensitivity", Element(i, j), g.value[i][j], part_.g_linear[3 * i + j],
            g.std_error[i][j], Bound(i, 7 + j));
  }

  void Accelerometer() {
    const auto& accelerometer = *vector_.accelerometer;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j)
        Add("accelerometer", Element(i, j), accelerometer.m[i][j], part_.accel_m[3 * i + j],
            accelerometer.m_std_error[i][j]);
      Add("accelerometer", std::string("offset ") + "xyz"[i], accelerometer.offset_g[i],
          part_.accel_offset_g[i], accelerometer.offset_std_error_g[i]);
    }
  }

  TruePart part_;
  const calibration::Traced& traced_;
  const VectorCalibration& vector_;
  VectorOutcome& out_;
  std::array<RowCovariance, 3> bounds_;
};

std::string Named(const calibration::TraceResult& result) {
  std::vector<std::string> axes;
  for (const calibration::ChannelTrace& channel : result.channels) {
    std::vector<std::string> ids;
    for (const auto& effect : channel.effects) ids.push_back(effect.id);
    axes.push_back(fmt::format("{}", fmt::join(ids, " ")));
  }
  return fmt::format("{}", fmt::join(axes, ", "));
}

calibration::Calibration CalibrationOf(const calibration::Traced& traced) {
  calibration::Calibration calibration;
  for (const calibration::ChannelModel& model : traced.models)
    calibration.channels.emplace_back().model = model;
  calibration.vector = traced.result.vector;
  return calibration;
}

}  // namespace

VectorOutcome RunVectorTrial(std::uint64_t seed, const config::Triple& mount_deg,
                             bool mount_known) {
  VectorOutcome out;
  out.seed = seed;
  TrialSpec spec{.seed = seed,
                 .all_channels = true,
                 .g_linear_deg_s_per_g = kGravitySpread_deg_s_per_g,
                 .mount_deg = mount_deg,
                 .mount_known = mount_known};
  try {
    calibration::Collector collector;
    const TrialTruth truth = RecordTrial(spec, collector);
    out.noise = truth.noise;
    const calibration::Recording recording = collector.Take();
    const calibration::Recording* const recordings[] = {&recording};
    calibration::TraceOptions options;
    options.curves = false;
    options.try_on_rest = false;
    const calibration::Traced traced = calibration::Trace(recordings, options);
    out.effects = Named(traced.result);
    Comparison(spec, truth.part, traced, out).Run();
    spec.sequence = SequenceKind::kElsewhere;
    spec.run = 1;
    out.elsewhere_whitened_rms = CorrectedElsewhere(spec, CalibrationOf(traced));
  } catch (const std::exception& error) {
    out.failure = error.what();
  }
  return out;
}

}  // namespace gyrobench::blind_trials
