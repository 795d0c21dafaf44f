#include "calibration/hold/held_rest.h"

#include <fmt/format.h>

#include <cmath>

namespace gyrobench::calibration {
namespace {

using Eigen::Vector3d;

// Of the first bad stretch within the times, in words.
std::string WhyUnusable(const HoldRecording& recording, double begin_s, double end_s) {
  for (const Defect& defect : recording.defects) {
    const bool within = defect.first_t_s >= begin_s - 1.0 && defect.first_t_s <= end_s + 1.0;
    if (within && defect.kind == "saturation") return fmt::format("{} is saturated", defect.where);
  }
  for (const BadStretch& bad : recording.bad) {
    if (bad.begin_s > end_s || bad.end_s < begin_s) continue;
    return fmt::format(
        "samples from {:.2f} s to {:.2f} s cannot be used (saturation, a gap, a "
        "frozen sensor or no number)",
        bad.begin_s, bad.end_s);
  }
  return "samples in it cannot be used";
}

HeldLink MakeLink(const HoldRecording& recording, const HeldRest& from, const HeldRest& to) {
  HeldLink link;
  link.epochs = {from.epochs.last, to.epochs.first};
  link.begin_s = from.end_s;
  link.end_s = to.begin_s;
  for (std::size_t i = link.epochs.first; i < link.epochs.last; ++i) {
    if (recording.epochs[i].usable) continue;
    link.kind = LinkKind::kLeftOut;
    link.because = WhyUnusable(recording, link.begin_s, link.end_s);
    return link;
  }
  if (link.duration_s() > kLongestTurn_s) {
    link.kind = LinkKind::kLeftOut;
    link.because =
        fmt::format("it lasts {:.0f} s, longer than {:.0f} s", link.duration_s(), kLongestTurn_s);
  }
  return link;
}

// One power-on goes on through a gap between its recordings, whose times count from its start.
HeldLink LinkRecordings(const HoldRecording& before, const HoldRecording& after,
                        const HeldRest& from, const HeldRest& to) {
  HeldLink link;
  link.begin_s = from.end_s;
  link.end_s = to.begin_s;
  const bool one = !before.info.power_on.empty() && before.info.power_on == after.info.power_on &&
                   link.duration_s() > 0.0;
  link.kind = one ? LinkKind::kLeftOut : LinkKind::kApart;
  return link;
}

}  // namespace

HeldRest ReduceRest(std::span<const Epoch> epochs, const EpochRange& range) {
  HeldRest rest;
  rest.epochs = range;
  rest.begin_s = epochs[range.first].begin_s;
  rest.end_s = epochs[range.last - 1].end_s;
  double temperature = 0.0, temperature_s = 0.0, white_square = 0.0;
  int white_samples = 0;
  for (std::size_t i = range.first; i < range.last; ++i) {
    rest.accel_g += epochs[i].duration_s() / rest.duration_s() * epochs[i].accel_g;
    rest.angle += epochs[i].angle;
    white_square += epochs[i].white_square;
    white_samples += epochs[i].white_samples;
    if (!std::isfinite(epochs[i].temperature_degC))
      continue;  // of a thermometer slower than epochs
    temperature += epochs[i].duration_s() * epochs[i].temperature_degC;
    temperature_s += epochs[i].duration_s();
  }
  rest.temperature_degC = temperature_s > 0.0 ? temperature / temperature_s : kMissing;
  if (white_samples > 0) rest.white_density = std::sqrt(white_square / (3.0 * white_samples));
  // Trapezoids between the epochs' ends.
  Vector3d sum = Vector3d::Zero(), angle = Vector3d::Zero(), last = Vector3d::Zero();
  double square = 0.0;
  for (std::size_t i = range.first; i < range.last; ++i) {
    const double h = epochs[i].duration_s();
    angle += epochs[i].angle;
    const Vector3d path =
        angle - rest.angle * ((epochs[i].end_s - rest.begin_s) / rest.duration_s());
    sum += 0.5 * h * (last + path);
    square += 0.5 * h * (last.squaredNorm() + path.squaredNorm());
    last = path;
  }
  rest.path_mean = sum / rest.duration_s();
  rest.path_rms = std::sqrt(square / rest.duration_s());
  return rest;
}

HeldChain MakeChain(std::span<const HoldRecording* const> recordings,
                    std::span<const RestSearch> searches) {
  HeldChain chain;
  chain.recordings.assign(recordings.begin(), recordings.end());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const HoldRecording& recording = *recordings[r];
    for (const EpochRange& range : searches[r].rests) {
      HeldRest rest = ReduceRest(recording.epochs, range);
      rest.recording = r;
      if (!chain.rests.empty()) {
        const HeldRest& from = chain.rests.back();
        chain.links.push_back(from.recording == r ? MakeLink(recording, from, rest)
                                                  : LinkRecordings(*recordings[from.recording],
                                                                   recording, from, rest));
      }
      chain.rests.push_back(rest);
    }
  }
  return chain;
}

}  // namespace gyrobench::calibration
