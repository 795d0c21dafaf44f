#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/signal/output_unit.h"
#include "calibration/state/state_history.h"

namespace gyrobench::calibration {
namespace {

// The noise of two readings must be small against what a block of time turns by.
constexpr double kBlock_s = 0.5;
constexpr double kLeastPath_deg = 5.0;
// A block counts as motion beyond so many standard deviations of what blocks at rest show, and
// beyond this angle.
constexpr double kMotionSigmas = 6.0, kLeastBlock_deg = 0.2;
// Of what all parts turn by: whole motions with less are those that go to and fro.
constexpr double kMostOfPath = 0.7;

struct Block {
  double duration_s = 0.0;
  bool at_rest = false;
  Vector3 rotation_deg = {}, output = {};
};

// Index of the rest that a time is in; rests.size() where there is none. Asked in order of time.
class RestAt {
 public:
  explicit RestAt(const std::vector<Rest>& rests) : rests_(rests) {}
  std::size_t operator()(double t_s) {
    while (next_ < rests_.size() && End(next_) < t_s) ++next_;
    return next_ < rests_.size() && Begin(next_) <= t_s ? next_ : rests_.size();
  }

 private:
  double Begin(std::size_t k) const {
    return std::max(rests_[k].begin.t_s, rests_[k].reference_begin_s);
  }
  double End(std::size_t k) const { return std::min(rests_[k].end.t_s, rests_[k].reference_end_s); }
  const std::vector<Rest>& rests_;
  std::size_t next_ = 0;
};

// Where a block may end: anywhere, or only at rest, so that a motion is whole in it.
enum class Ends { kAnywhere, kAtRest };

std::vector<Block> BlocksOf(const Recording& recording, Ends ends) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  RestAt rest_at(recording.columns.rests);
  const std::size_t none = recording.columns.rests.size();
  std::vector<Block> blocks;
  std::size_t from = 0, rest = nodes.empty() ? none : rest_at(nodes.front().at.t_s);
  bool one_rest = rest != none;
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    const std::size_t here = rest_at(nodes[k].at.t_s);
    one_rest = one_rest && here == rest;
    if (nodes[k].at.t_s - nodes[from].at.t_s < kBlock_s) continue;
    if (ends == Ends::kAtRest && here == none) continue;
    Block block;
    block.duration_s = nodes[k].at.t_s - nodes[from].at.t_s;
    block.at_rest = one_rest;
    for (std::size_t c = 0; c < 3; ++c) {
      block.rotation_deg[c] = nodes[k].rotation_deg[c] - nodes[from].rotation_deg[c];
      block.output[c] = nodes[k].at.z[c] - nodes[from].at.z[c];
    }
    blocks.push_back(block);
    from = k;
    rest = here;
    one_rest = rest != none;
  }
  return blocks;
}

// Standard deviation of what a block at rest turns by: the noise of the reference; 0 without one.
double NoiseOf(const std::vector<Block>& blocks, std::size_t channel) {
  double sum = 0.0, count = 0.0;
  for (const Block& block : blocks) {
    if (!block.at_rest || !std::isfinite(block.rotation_deg[channel])) continue;
    sum += block.rotation_deg[channel] * block.rotation_deg[channel];
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

struct Slope {
  double units_per_deg_s = kMissing;
  double path_deg = 0.0;  // of the blocks that it rests on
};

// Of the straight line of the output on the rate; NaN where too little turns, and where it is none
// beside its own error: a channel that feels nothing of the turns would have all its noise taken
// for them. What a block at rest shows of a rate is noise, and taken as none.
Slope SlopeOf(const std::vector<Block>& blocks, std::size_t channel) {
  const double motion_deg = std::max(kLeastBlock_deg, kMotionSigmas * NoiseOf(blocks, channel));
  constexpr double kFelt = 5.0;        // standard errors
  constexpr double kRounding = 1e-12;  // of the squares
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, path_deg = 0;
  for (const Block& block : blocks) {
    const double turned_deg = block.rotation_deg[channel];
    const double output = block.output[channel] / block.duration_s;
    if (!std::isfinite(turned_deg) || !std::isfinite(output)) continue;
    const bool moves = !block.at_rest && std::fabs(turned_deg) > motion_deg;
    if (!block.at_rest && !moves) continue;
    const double rate = moves ? turned_deg / block.duration_s : 0.0;
    n += 1;
    x += rate;
    y += output;
    xx += rate * rate;
    xy += rate * output;
    yy += output * output;
    path_deg += moves ? std::fabs(turned_deg) : 0.0;
  }
  const double spread = xx - x * x / n;
  if (!(path_deg > kLeastPath_deg) || !(spread > 0)) return {kMissing, path_deg};
  const double together = xy - x * y / n, slope = together / spread;
  const double left = std::max(yy - y * y / n - slope * together, kRounding * yy);
  const bool felt = n > 2.0 && slope * slope * spread > kFelt * kFelt * left / (n - 2.0);
  return {felt ? slope : kMissing, path_deg};
}

}  // namespace

Vector3 RoughSensitivity(const Recording& recording) {
  // In parts of a motion a channel that is late against the reference seems less sensitive.
  const std::vector<Block> whole = BlocksOf(recording, Ends::kAtRest);
  const std::vector<Block> parts = BlocksOf(recording, Ends::kAnywhere);
  const double nominal = NominalUnitsPerDegPerS(recording.info);
  Vector3 out = {kMissing, kMissing, kMissing};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!recording.info.gyro_present[c]) continue;
    const Slope of_whole = SlopeOf(whole, c), of_parts = SlopeOf(parts, c);
    // Of a swing or a long motion of a hand hardly anything is left between its rests.
    const bool whole_tells = of_whole.path_deg > kMostOfPath * of_parts.path_deg;
    const double measured = whole_tells && std::isfinite(of_whole.units_per_deg_s)
                                ? of_whole.units_per_deg_s
                                : of_parts.units_per_deg_s;
    out[c] = std::isfinite(measured) ? measured : nominal;
  }
  return out;
}

}  // namespace gyrobench::calibration
