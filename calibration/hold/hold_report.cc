#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/geometry.h"
#include "calibration/effects/effect.h"
#include "calibration/hold/estimate_noise.h"
#include "calibration/hold/hold_judgement.h"
#include "calibration/sensor/sensor_matrix.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

Vector3 Plain(const Vector3d& v) { return {v[0], v[1], v[2]}; }

Matrix3 PlainRows(const Matrix3d& m) { return {Plain(m.row(0)), Plain(m.row(1)), Plain(m.row(2))}; }

// Standard errors of nine elements, row by row.
Matrix3 Errors(const Matrix9& covariance) {
  Matrix3 out;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto k = static_cast<Index>(3 * i + j);
      out[i][j] = std::sqrt(covariance(k, k));
    }
  return out;
}

// Of the state's parameters in the units of the result: M without unit, deg/s, deg/s/g.
class Reporter {
 public:
  Reporter(const HeldChain& chain, const HoldFit& fit, HoldResult* out)
      : chain_(chain),
        fit_(fit),
        out_(*out),
        covariance_(CovarianceOverNoise(fit.model, fit.noise)),
        at_offset_(fit.extent.Parameters()) {}

  void Fill(const RestNoise& rests, std::array<bool, 3> seen) {
    FillUnits();
    FillBias();
    FillMatrix();
    FillGSensitivity(seen);
    FillAccelerometer();
    FillNoise(rests);
    FillRanges();
    for (std::size_t c = 0; c < 3; ++c) out_.channels.push_back(Channel(c, seen[c]));
  }

 private:
  // factor_[c]: deg/s of the output over its sensitivity for one rad/s of the fit's.
  void FillUnits() {
    const MeasurementInfo& info = chain_.recordings.front()->info;
    out_.unit = info.gyro_unit == RateUnit::kLsb ? "LSB" : "deg/s";
    for (std::size_t c = 0; c < 3; ++c) {
      const double row = fit_.state.m.row(static_cast<Index>(c)).norm();
      out_.units_per_deg_s[c] =
          (out_.sensitivity_given ? 1.0 : row) / (kDegPerRad * fit_.state.unit);
      factor_[static_cast<Index>(c)] = 1.0 / (fit_.state.unit * out_.units_per_deg_s[c]);
    }
  }

  void FillBias() {
    Vector3d sum = Vector3d::Zero();
    double temperature = 0.0;
    const auto n = static_cast<double>(chain_.rests.size());
    for (std::size_t k = 0; k < chain_.rests.size(); ++k) {
      sum += 0.5 / n * (fit_.state.nodes[k].beta_begin + fit_.state.nodes[k].beta_end);
      temperature += chain_.rests[k].temperature_degC / n;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const auto i = static_cast<Index>(c);
      out_.bias_deg_s[c] = factor_[i] * sum[i];
      out_.bias_std_error_deg_s[c] =
          factor_[i] * std::sqrt(covariance_(at_offset_ + i, at_offset_ + i));
    }
    out_.temperature_degC = temperature;
  }

  void FillMatrix() {
    for (Index i = 0; i < 3; ++i) {
      m_.value.row(i) = factor_[i] / kDegPerRad * fit_.state.m.row(i);
      for (Index k = 0; k < 3; ++k)
        m_.covariance.block<3, 3>(3 * i, 3 * k) =
            factor_[i] * factor_[k] / (kDegPerRad * kDegPerRad) *
            covariance_.block<3, 3>(kAtM + 3 * i, kAtM + 3 * k);
    }
    const MatrixWithCovariance a = InverseOver(
        m_, {out_.units_per_deg_s[0], out_.units_per_deg_s[1], out_.units_per_deg_s[2]});
    out_.vector.unit = out_.unit;
    VectorMatrix& matrix = out_.vector.matrix.emplace();
    matrix.m = PlainRows(m_.value);
    matrix.a = PlainRows(a.value);
    matrix.m_std_error = Errors(m_.covariance);
    matrix.a_std_error = Errors(a.covariance);
    matrix.m_covariance.assign(m_.covariance.data(), m_.covariance.data() + 81);
    matrix.a_covariance.assign(a.covariance.data(), a.covariance.data() + 81);
    out_.vector.split = SplitAxes(m_);
    if (!out_.vector.split)
      out_.vector.remarks.emplace_back(
          "the gyro's axes are left-handed in the accelerometer's frame: the sign of one axis is "
          "reversed, or two are exchanged; the matrix holds, a mounting rotation there is not");
  }

  void FillGSensitivity(std::array<bool, 3> seen) {
    if (!fit_.extent.g_sensitivity) return;
    constexpr double kNotKnown_deg_s_g = 0.1;  // what the data sheet of an MPU-6050 allows
    GSensitivity g;
    g.in_model = seen;
    const Index at = fit_.extent.AtGSensitivity();
    std::string hidden;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto i = static_cast<Index>(c);
      for (std::size_t j = 0; j < 3; ++j) {
        const Index k = at + 3 * i + static_cast<Index>(j);
        const double error = factor_[i] * std::sqrt(covariance_(k, k));
        if (error > kNotKnown_deg_s_g) {
          hidden += fmt::format("{}{}{}", hidden.empty() ? "" : ", ", "xyz"[c], "xyz"[j]);
          continue;
        }
        g.value[c][j] = factor_[i] * fit_.state.g_sensitivity(i, static_cast<Index>(j));
        g.std_error[c][j] = error;
      }
    }
    if (!hidden.empty())
      g.because.push_back(fmt::format(
          "{}: the poses do not tell it from the offset; hold the sensor in more of them", hidden));
    out_.vector.g_sensitivity = g;
  }

  void FillAccelerometer() {
    AccelerometerCalibration accelerometer;
    accelerometer.poses = static_cast<std::int64_t>(chain_.rests.size());
    MatrixWithCovariance t;
    t.value = fit_.state.accel.Matrix();
    const Eigen::Matrix<double, 9, 6> slope = AccelSlope();
    t.covariance = slope * covariance_.block<6, 6>(kAtScale, kAtScale) * slope.transpose();
    accelerometer.m = PlainRows(t.value);
    accelerometer.m_std_error = Errors(t.covariance);
    accelerometer.offset_g = Plain(fit_.state.accel.offset_g);
    accelerometer.offset_std_error_g =
        Plain(Vector3d(covariance_.diagonal().segment<3>(kAtOffset).cwiseSqrt()));
    accelerometer.pose_scatter_g = fit_.noise.pose_scatter_g;
    accelerometer.split = SplitAxes(t);
    if (accelerometer.split) {
      // The frame is the accelerometer's own, by choice and without error.
      accelerometer.split->mount_deg = accelerometer.split->mount_std_error_deg = {};
      accelerometer.split->r_mount = PlainRows(Matrix3d::Identity());
    }
    accelerometer.check = SizeOfGravity();
    out_.vector.accelerometer = accelerometer;
  }

  GravityCheck SizeOfGravity() const {
    const Matrix3d inverse = fit_.state.accel.Matrix().inverse();
    double before = 0.0, after = 0.0;
    const auto n = static_cast<double>(chain_.rests.size());
    for (const HeldRest& rest : chain_.rests) {
      before += std::pow(rest.accel_g.norm() - 1.0, 2) / n;
      after += std::pow((inverse * (rest.accel_g - fit_.state.accel.offset_g)).norm() - 1.0, 2) / n;
    }
    GravityCheck check;
    check.rms_before_g = std::sqrt(before);
    check.rms_after_g = std::sqrt(after);
    return check;
  }

  // Of T's elements, row by row, by scale and shear.
  Eigen::Matrix<double, 9, 6> AccelSlope() const {
    Eigen::Matrix<double, 9, 6> slope;
    constexpr double kStep = 1e-6;
    for (Index p = 0; p < 6; ++p) {
      AccelParameters up = fit_.state.accel, down = up;
      (p < 3 ? up.scale[p] : up.shear[p - 3]) += kStep;
      (p < 3 ? down.scale[p] : down.shear[p - 3]) -= kStep;
      const Matrix3d d = (up.Matrix() - down.Matrix()) / (2.0 * kStep);
      for (Index i = 0; i < 3; ++i) slope.block<3, 1>(3 * i, p) = d.row(i).transpose();
    }
    return slope;
  }

  void FillNoise(const RestNoise& rests) {
    out_.noise = {fit_.noise, rests.median_angle_random_walk_deg_sqrt_s};
  }

  void FillRanges() {
    double fastest = 0.0;
    const Matrix3d to_rate = kDegPerRad * fit_.state.unit * fit_.state.m.inverse();
    for (const HoldRecording* recording : chain_.recordings) {
      for (const Epoch& epoch : recording->epochs) {
        if (epoch.usable)
          fastest = std::max(fastest, (to_rate * epoch.rate()).cwiseAbs().maxCoeff());
        out_.min_temperature_degC = std::fmin(out_.min_temperature_degC, epoch.temperature_degC);
        out_.max_temperature_degC = std::fmax(out_.max_temperature_degC, epoch.temperature_degC);
      }
    }
    out_.max_rate_deg_s = fastest;
  }

  // Parameters of a channel: its row of M, own element first, the offset, its g-sensitivity.
  ChannelCalibration Channel(std::size_t c, bool with_gravity) const {
    ChannelCalibration channel;
    ChannelModel& model = channel.model;
    model.axis = static_cast<SensorAxis>(c);
    model.unit = out_.unit;
    model.units_per_deg_s = out_.units_per_deg_s[c];
    model.m_row = out_.vector.matrix->m[c];
    model.m_row_std_error = out_.vector.matrix->m_std_error[c];
    model.reference_degC = out_.temperature_degC;
    model.bias_deg_s = {out_.bias_deg_s[c]};
    const auto i = static_cast<Index>(c);
    std::vector<Index> columns;
    std::vector<double> units;
    const auto add = [&](const std::string& name, Index column, double unit) {
      model.parameter_names.push_back(name);
      columns.push_back(column);
      units.push_back(unit);
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t j = (c + k) % 3;
      add(fmt::format("M_{}{}", "xyz"[c], "xyz"[j]), kAtM + 3 * i + static_cast<Index>(j),
          factor_[i] / kDegPerRad);
    }
    add("b_0", at_offset_ + i, factor_[i]);
    if (with_gravity) {
      ModelTerm term;
      term.id = GSensitivityEffect().id;
      term.chosen_on = ChosenOn::kAllData;
      for (std::size_t j = 0; j < 3; ++j) {
        const auto k = static_cast<Index>(j);
        term.coefficients.push_back(factor_[i] * fit_.state.g_sensitivity(i, k));
        add(fmt::format("{}.k_{}", term.id, "xyz"[j]), fit_.extent.AtGSensitivity() + 3 * i + k,
            factor_[i]);
      }
      model.terms.push_back(term);
    }
    for (std::size_t a = 0; a < columns.size(); ++a)
      for (std::size_t b = 0; b < columns.size(); ++b)
        model.covariance.push_back(units[a] * units[b] * covariance_(columns[a], columns[b]));
    model.min_temperature_degC = out_.min_temperature_degC;
    model.max_temperature_degC = out_.max_temperature_degC;
    model.max_rate_deg_s = out_.max_rate_deg_s;
    channel.heldout_whitened_rms.after = fit_.turn_whitened_rms;
    channel.noise = {out_.noise.angle_random_walk_deg_sqrt_s,
                     out_.noise.bias_random_walk_deg_s_sqrt_s, kMissing};
    return channel;
  }

  const HeldChain& chain_;
  const HoldFit& fit_;
  HoldResult& out_;
  MatrixXd covariance_;
  Index at_offset_ = 0;
  Vector3d factor_ = Vector3d::Ones();
  MatrixWithCovariance m_;
};

}  // namespace

void FillResult(const HeldChain& chain, const HoldFit& fit, const RestNoise& rests,
                std::array<bool, 3> seen, HoldResult* out) {
  Reporter(chain, fit, out).Fill(rests, seen);
}

}  // namespace gyrobench::calibration
