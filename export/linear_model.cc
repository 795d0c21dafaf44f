#include "export/linear_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "calibration/effects/effect.h"
#include "export/text.h"

namespace gyrobench::exporting {
namespace {

using calibration::ChannelModel;

// As in the corrector: beyond this share of its largest entry an inverse means nothing.
constexpr double kLeastPivot = 1e-3;

void FillRow(const ChannelModel& model, std::size_t c, Vector3* row) {
  for (std::size_t j = 0; j < 3; ++j) {
    const bool never_turned = c == j && model.m_row[j] == 0.0;
    (*row)[j] = never_turned ? 1.0 : model.m_row[j];
  }
}

Matrix3 Inverse(const Matrix3& m) {
  Eigen::Matrix3d matrix;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < 3; ++j)
      matrix(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(j)) = m[c][j];
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(matrix);
  if (!(lu.matrixLU().diagonal().cwiseAbs().minCoeff() > kLeastPivot)) {
    throw DataError(
        "the calibration's matrix M has no inverse: two axes of it say the same; trace data in "
        "which each axis turned");
  }
  const Eigen::Matrix3d inverse = lu.inverse();
  Matrix3 out;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < 3; ++j)
      out[c][j] = inverse(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(j));
  return out;
}

}  // namespace

LinearModel MakeLinearModel(const calibration::Calibration& calibration) {
  LinearModel out;
  const ChannelModel& first = calibration.channels.at(0).model;
  out.unit = first.unit;
  out.units_per_deg_s.fill(first.units_per_deg_s);
  for (std::size_t c = 0; c < 3; ++c) out.m[c][c] = 1.0;
  for (const calibration::ChannelCalibration& channel : calibration.channels) {
    const ChannelModel& model = channel.model;
    if (model.unit != out.unit) {
      throw DataError(fmt::format(
          "the channels of the calibration are in different units, {} and {}: no single formula "
          "holds both; trace data of one unit",
          out.unit, model.unit));
    }
    const auto c = static_cast<std::size_t>(model.axis);
    out.axes[c] = &model;
    out.units_per_deg_s[c] = model.units_per_deg_s;
    FillRow(model, c, &out.m[c]);
  }
  out.inverse = Inverse(out.m);
  return out;
}

std::vector<std::string> WhatNoCorrectionHolds(const calibration::Calibration& calibration,
                                               const LinearModel& model) {
  std::vector<std::string> notes;
  for (std::size_t c = 0; c < 3; ++c) {
    if (model.axes[c] == nullptr) {
      notes.push_back(fmt::format("gyro {}: not in the calibration: nothing is corrected on it",
                                  kAxisNames[c]));
    } else if (calibration::ScaleUnknown(*model.axes[c])) {
      notes.push_back(fmt::format(
          "gyro {}: the calibration never turned it, and no sensitivity says how many counts are "
          "1 deg/s: what comes out of it are counts",
          kAxisNames[c]));
    } else if (model.axes[c]->m_row[c] == 0.0) {
      notes.push_back(fmt::format(
          "gyro {}: the calibration never turned it: its scale factor is the nominal one",
          kAxisNames[c]));
    }
  }
  LeftOut left_out;
  for (const calibration::ChannelCalibration& channel : calibration.channels) {
    for (const calibration::ModelTerm& term : channel.model.terms) {
      const std::string because = calibration::WhyNotApplied(term);
      if (because.empty() || term.owner != calibration::EffectOwner::kGyro) continue;
      left_out.Add(channel.model.axis, term.id, because);
    }
  }
  Append(&notes, left_out.Notes());
  Append(&notes, SetToZero(calibration));
  return notes;
}

std::vector<std::string> NotDetermined(const ChannelModel& model,
                                       const calibration::ModelTerm& term) {
  std::vector<std::string> names;
  const calibration::Effect* effect =
      term.origin == calibration::EffectOrigin::kCatalogue &&
              calibration::WhyNotApplied(term).empty()
          ? calibration::FindEffect(calibration::CatalogueName(term.id), term.nonlinear.size())
          : nullptr;
  if (effect == nullptr || effect->terms.size() != term.coefficients.size()) return names;
  const std::size_t all = model.parameter_names.size();
  for (std::size_t k = 0; k < term.coefficients.size(); ++k) {
    if (term.coefficients[k] != 0.0) continue;
    const std::string name = effect->terms[k].name;
    const auto found = std::ranges::find(model.parameter_names, term.id + "." + name);
    const auto at = static_cast<std::size_t>(found - model.parameter_names.begin());
    const bool has_error =
        at < all && model.covariance.size() == all * all && model.covariance[at * all + at] > 0.0;
    if (!has_error) names.push_back(name);
  }
  return names;
}

std::vector<std::string> SetToZero(const calibration::Calibration& calibration) {
  std::vector<std::string> notes;
  for (const calibration::ChannelCalibration& channel : calibration.channels) {
    for (const calibration::ModelTerm& term : channel.model.terms) {
      const std::vector<std::string> names = NotDetermined(channel.model, term);
      if (names.empty()) continue;
      notes.push_back(
          fmt::format("gyro {}: the data do not determine {} of {}: nothing of that is taken off, "
                      "as if it were 0; trace data that show it, of other poses say",
                      kAxisNames[static_cast<std::size_t>(channel.model.axis)],
                      fmt::join(names, ", "), term.id));
    }
  }
  return notes;
}

std::vector<std::string> MatrixLeftOut(const LinearModel& model) {
  std::vector<std::string> notes;
  for (std::size_t c = 0; c < 3; ++c) {
    if (model.axes[c] == nullptr) continue;
    double off = 0.0;
    for (std::size_t j = 0; j < 3; ++j) off += std::fabs(model.m[c][j] - (c == j ? 1.0 : 0.0));
    if (off == 0.0) continue;
    std::string note = fmt::format(
        "gyro {}: scale factor and misalignment are left out: its row of M is {:.6f} {:.6f} {:.6f}",
        kAxisNames[c], model.m[c][0], model.m[c][1], model.m[c][2]);
    const double rate_deg_s = model.axes[c]->max_rate_deg_s;
    if (std::isfinite(rate_deg_s)) {
      note += fmt::format(", up to {:.2g} deg/s of error at {:.3g} deg/s", off * rate_deg_s,
                          rate_deg_s);
    }
    notes.push_back(std::move(note));
  }
  return notes;
}

TemperatureRange CommonTemperatures(const LinearModel& model) {
  TemperatureRange common;
  for (const ChannelModel* axis : model.axes) {
    if (axis == nullptr) continue;
    common.low_degC = std::fmax(common.low_degC, axis->min_temperature_degC);
    common.high_degC = std::fmin(common.high_degC, axis->max_temperature_degC);
  }
  if (std::isfinite(common.low_degC) && std::isfinite(common.high_degC) && !common.known()) {
    throw DataError(fmt::format(
        "the axes of the calibration have no temperature in common: one begins at {:.1f} degC, "
        "another ends at {:.1f}; trace runs of all axes over the same temperatures",
        common.low_degC, common.high_degC));
  }
  return common;
}

}  // namespace gyrobench::exporting
