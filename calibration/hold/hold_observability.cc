#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/geometry.h"
#include "calibration/hold/hold_judgement.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kCovered_deg = 35.0;
// What is held to be possible of a parameter before anything is measured.
constexpr double kBefore = 1.0;
// An axis that turned by less in all, there and back, has not been turned about.
constexpr double kHardlyTurned_deg = 60.0;
constexpr std::array<const char*, 6> kFaces = {"+x", "-x", "+y", "-y", "+z", "-z"};

// Standard errors of the base parameters when each is known to kBefore.
Eigen::VectorXd StdErrors(const HeldChain& chain, const HoldState& state, const HoldNoise& noise) {
  const LinearModel model = Linearize(chain, state, ModelExtent{}, kMissing);
  ArrowSystem system(model.nodes, kBase);
  for (const HoldFactor& factor : model.factors) {
    const double weight = 1.0 / VarianceOf(factor, noise);
    if (factor.kind == FactorKind::kTurn || factor.kind == FactorKind::kLinkWalk) {
      system.AddPair(factor.node, factor.products, weight);
    } else {
      system.AddNode(factor.node, factor.products, weight);
    }
  }
  for (Index i = 0; i < kBase; ++i) system.AddParameter(i, 0.0, 1.0 / (kBefore * kBefore));
  const ArrowSystem::Solution solution = system.Solve();
  if (!solution.positive) return Eigen::VectorXd::Constant(kBase, kBefore);
  return solution.covariance.diagonal().cwiseSqrt();
}

std::string Elements(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string MissingFaces(const HoldState& state) {
  std::vector<std::string> faces;
  for (const HoldFace& face : FacesOf(state))
    if (!face.covered) faces.push_back(face.up);
  if (faces.empty())
    return "hold the sensor in more poses between its faces, tilted by 30 to 60 deg";
  return fmt::format("hold the sensor also with {} up", fmt::join(faces, ", "));
}

}  // namespace

std::vector<HoldFace> FacesOf(const HoldState& state) {
  std::vector<HoldFace> faces;
  for (std::size_t f = 0; f < kFaces.size(); ++f) {
    const auto axis = static_cast<Index>(f / 2);
    const double sign = f % 2 == 0 ? 1.0 : -1.0;
    double nearest = -1.0;
    for (const NodeState& node : state.nodes)
      nearest = std::max(nearest, sign * node.gravity[axis]);
    HoldFace face;
    face.up = kFaces[f];
    face.nearest_deg = kDegPerRad * std::acos(std::clamp(nearest, -1.0, 1.0));
    face.covered = face.nearest_deg < kCovered_deg;
    faces.push_back(face);
  }
  return faces;
}

std::array<double, 3> TurnedAbout(const HeldChain& chain, const HoldState& state) {
  std::array<double, 3> turned = {};
  const Eigen::Matrix3d a = state.unit * state.m.inverse();
  for (std::size_t k = 0; k < chain.links.size(); ++k) {
    if (chain.links[k].kind != LinkKind::kTurn) continue;
    const auto& epochs = chain.recordings[chain.rests[k].recording]->epochs;
    for (std::size_t i = chain.links[k].epochs.first; i < chain.links[k].epochs.last; ++i) {
      const Vector3d angle = a * epochs[i].angle -
                             epochs[i].duration_s() * state.m.inverse() * state.nodes[k].beta_end;
      for (std::size_t c = 0; c < 3; ++c)
        turned[c] += kDegPerRad * std::fabs(angle[static_cast<Index>(c)]);
    }
  }
  return turned;
}

std::vector<std::string> WhatIsMissing(const HeldChain& chain, const HoldState& state,
                                       const HoldNoise& noise) {
  const Eigen::VectorXd errors = StdErrors(chain, state, noise);
  std::vector<std::string> missing, elements, accelerometer;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (errors[static_cast<Index>(kAtM + 3 * i + j)] > kScaleOfDataSheet)
        elements.push_back(fmt::format("{}{}", "xyz"[i], "xyz"[j]));
    }
  }
  for (Index i = 0; i < 3; ++i) {
    const char axis = "xyz"[i];
    if (errors[kAtScale + i] > kScaleOfDataSheet)
      accelerometer.push_back(fmt::format("scale {}", axis));
    if (errors[kAtOffset + i] > kScaleOfDataSheet * state.accel.scale.mean())
      accelerometer.push_back(fmt::format("offset {}", axis));
    if (errors[kAtShear + i] > kScaleOfDataSheet)
      accelerometer.push_back(fmt::format(
          "angle {}",
          std::array<const char*, 3>{"y-z", "z-x", "x-y"}.at(static_cast<std::size_t>(i))));
  }
  if (!accelerometer.empty()) {
    missing.push_back(fmt::format("the accelerometer's {} cannot be told from these {} rests: {}",
                                  Elements(accelerometer), chain.rests.size(),
                                  MissingFaces(state)));
  }
  if (!elements.empty()) {
    const std::array<double, 3> turned = TurnedAbout(chain, state);
    std::vector<std::string> unturned;
    for (std::size_t c = 0; c < 3; ++c)
      if (turned[c] < kHardlyTurned_deg) unturned.push_back(std::string(1, "xyz"[c]));
    const std::string what =
        unturned.empty()
            ? "turn about more axes and further, 60 to 180 deg with gravity across the axis"
            : fmt::format("turn about {} by 60 to 180 deg with that axis level",
                          fmt::join(unturned, " and "));
    missing.push_back(
        fmt::format("{} of the gyro's matrix (row: output, column: axis) cannot be "
                    "told from these turns: {}",
                    Elements(elements), what));
  }
  return missing;
}

}  // namespace gyrobench::calibration
