#include "export/thermal_bias.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "base/geometry.h"
#include "calibration/artefact/model_terms.h"

namespace gyrobench::exporting {
namespace {

using calibration::ChannelModel;
using calibration::ModelTerm;

constexpr Eigen::Index kFitPoints = 64;
// A deviation below this is rounding [deg/s].
constexpr double kRounding_deg_s = 1e-9;

bool IsOfTemperatureAlone(const ModelTerm& term) {
  return term.origin != calibration::EffectOrigin::kCatalogue &&
         std::all_of(term.factors.begin(), term.factors.end(),
                     [](const std::string& factor) { return factor == "T"; });
}

// b(T) and the effects of the temperature alone [deg/s].
class AxisBias {
 public:
  // The effects that it does not hold go to `notes`.
  AxisBias(const ChannelModel& model, Lines* notes) : model_(model) {
    MeasurementInfo info;
    info.temperature_present = true;
    LeftOut left_out;
    for (const ModelTerm& term : model.terms) {
      if (!calibration::WhyNotApplied(term).empty()) continue;
      std::string why_not = "the autopilot holds offsets that depend on the temperature alone";
      if (IsOfTemperatureAlone(term)) {
        if (auto function = calibration::MakeTermFunction(term, model.axis, info, &why_not)) {
          terms_.push_back(std::move(function));
          continue;
        }
      }
      left_out.Add(model.axis, term.id, why_not);
    }
    Append(notes, left_out.Notes());
  }

  double At(double temperature_degC) const {
    double bias = 0.0;
    const std::vector<double>& b = model_.bias_deg_s;
    const double off = b.size() > 1 ? temperature_degC - model_.reference_degC : 0.0;
    for (std::size_t k = b.size(); k-- > 0;) bias = bias * off + b[k];
    calibration::SensorState point;
    point.temperature_degC = temperature_degC;
    for (const auto& term : terms_) bias += term->At(point);
    return bias;
  }
  // Where nothing is known of the temperature.
  double Constant() const { return model_.bias_deg_s.empty() ? 0.0 : model_.bias_deg_s[0]; }

 private:
  const ChannelModel& model_;
  std::vector<std::unique_ptr<calibration::TermFunction>> terms_;
};

// c(x) with x = (T - middle) / half turned into coefficients about `reference`.
Cubic Shifted(const Eigen::Vector4d& c, double middle, double half, double reference) {
  const double at = (reference - middle) / half, step = 1.0 / half;
  return {c[0] + at * (c[1] + at * (c[2] + at * c[3])),
          step * (c[1] + at * (2.0 * c[2] + at * 3.0 * c[3])),
          step * step * (c[2] + 3.0 * at * c[3]), step * step * step * c[3]};
}

// Least squares at Chebyshev's points, which keep the largest deviation near the least possible.
Cubic FitCubic(const AxisBias& bias, const TemperatureRange& range, double reference_degC,
               double* largest_error_deg_s) {
  const double middle = 0.5 * (range.low_degC + range.high_degC);
  const double half = std::fmax(0.5 * (range.high_degC - range.low_degC), 1e-3);
  Eigen::Matrix<double, Eigen::Dynamic, 4> powers(kFitPoints, 4);
  Eigen::VectorXd values(kFitPoints);
  for (Eigen::Index i = 0; i < kFitPoints; ++i) {
    const double x = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / kFitPoints);
    powers.row(i) << 1.0, x, x * x, x * x * x;
    values[i] = bias.At(middle + half * x);
  }
  const Eigen::Vector4d fit = powers.colPivHouseholderQr().solve(values);
  *largest_error_deg_s = (powers * fit - values).cwiseAbs().maxCoeff();
  return Shifted(fit, middle, half, reference_degC);
}

void NoteRange(const LinearModel& model, ThermalBias* out) {
  for (std::size_t c = 0; c < 3; ++c) {
    const ChannelModel* axis = model.axes[c];
    if (axis == nullptr || (!(axis->min_temperature_degC < out->range.low_degC) &&
                            !(axis->max_temperature_degC > out->range.high_degC))) {
      continue;
    }
    out->notes.push_back(fmt::format(
        "gyro {}: it was calibrated for {:.4g} .. {:.4g} degC; all axes share one range, and that "
        "is {:.4g} .. {:.4g} degC",
        kAxisNames[c], axis->min_temperature_degC, axis->max_temperature_degC, out->range.low_degC,
        out->range.high_degC));
  }
}

Lines DriverLines(const LinearModel& model, const calibration::Calibration& calibration) {
  Lines lines = {
      "Axes: those of the calibration's table. Where the autopilot's driver turns the chip's axes "
      "(it often negates two), exchange the axes and signs of these values alike."};
  if (model.unit == "LSB") {
    lines.push_back(
        fmt::format("Range: that of {:.6g} LSB per deg/s. The offset at another range of the "
                    "sensor is another.",
                    model.units_per_deg_s[0]));
  }
  if (const double zero = calibration.gyro_lsb_zero.value_or(0.0); zero != 0.0) {
    lines.push_back(
        fmt::format("Zero: the offset is of counts less {:g}, the converter's count of zero, which "
                    "the driver has to take off.",
                    zero));
  }
  return lines;
}

Lines ExampleLines(const ThermalBias& bias) {
  Lines lines = {"Worked example:"};
  std::vector<double> temperatures = {0.0};
  if (bias.range.known()) {
    temperatures = {bias.range.low_degC, 0.5 * (bias.range.low_degC + bias.range.high_degC),
                    bias.range.high_degC};
  }
  for (const double temperature : temperatures) {
    const Vector3 offset = bias.OffsetAt(temperature);
    const std::string when =
        bias.range.known() ? fmt::format("at {:.2f} degC", temperature) : "at any temperature";
    lines.push_back(fmt::format("  {} the offset is {:.8f} {:.8f} {:.8f} rad/s", when, offset[0],
                                offset[1], offset[2]));
  }
  return lines;
}

}  // namespace

Vector3 ThermalBias::OffsetAt(double temperature_degC) const {
  const double held = std::fmin(std::fmax(temperature_degC, range.low_degC), range.high_degC);
  const double off = range.known() ? held - reference_degC : 0.0;
  Vector3 offset;
  for (std::size_t c = 0; c < 3; ++c) {
    const Cubic& k = coefficients_rad_s[c];
    offset[c] = k[0] + off * (k[1] + off * (k[2] + off * k[3]));
  }
  return offset;
}

ThermalBias MakeThermalBias(const calibration::Calibration& calibration, double reference_degC) {
  const LinearModel model = MakeLinearModel(calibration);
  ThermalBias out;
  out.range = CommonTemperatures(model);
  out.reference_degC = std::isfinite(reference_degC) || !out.range.known()
                           ? reference_degC
                           : 0.5 * (out.range.low_degC + out.range.high_degC);
  out.notes = WhatNoCorrectionHolds(calibration, model);
  Append(&out.notes, MatrixLeftOut(model));
  for (std::size_t c = 0; c < 3; ++c) {
    if (model.axes[c] == nullptr) continue;
    const AxisBias bias(*model.axes[c], &out.notes);
    Cubic& cubic = out.coefficients_rad_s[c];
    double error_deg_s = 0.0;
    if (out.range.known()) {
      cubic = FitCubic(bias, out.range, out.reference_degC, &error_deg_s);
    } else {
      cubic = {bias.Constant(), 0.0, 0.0, 0.0};
    }
    for (double& coefficient : cubic) coefficient *= kRadPerDeg;
    if (error_deg_s > kRounding_deg_s) {
      out.notes.push_back(
          fmt::format("gyro {}: the bias is no cubic of the temperature: the cubic here is off by "
                      "up to {:.2g} deg/s",
                      kAxisNames[c], error_deg_s));
    }
  }
  if (out.range.known()) NoteRange(model, &out);
  return out;
}

Lines AutopilotLines(const std::string& autopilot, const calibration::Calibration& calibration,
                     const Origin& origin, const ThermalBias& bias, const Lines& formula,
                     const Lines& notes) {
  const LinearModel model = MakeLinearModel(calibration);
  Lines about = OriginLines(calibration, origin);
  about[0] = fmt::format("Gyro offset for {}. {}", autopilot, about[0]);
  for (const Lines& more : {Lines{""}, formula, DriverLines(model, calibration), Lines{""},
                            ValidityLines(model), ExampleLines(bias), NoteLines(notes)}) {
    Append(&about, more);
  }
  return about;
}

}  // namespace gyrobench::exporting
