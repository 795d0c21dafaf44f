// What of a turn its rests have taken.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "calibration/estimators/schedule.h"

namespace gyrobench::calibration {
namespace {

constexpr double kOfHalfRise = 0.7, kMostEdge_s = 0.5, kMostOfRest = 0.25;

// The output's integral as the columns keep it: in ten even steps from one node to the next.
class FineMarks {
 public:
  explicit FineMarks(const std::vector<Node>& nodes) : nodes_(nodes) {}
  std::size_t count() const { return nodes_.empty() ? 0 : (nodes_.size() - 1) * kWaySteps + 1; }
  IntegralMark at(std::size_t i) const {
    if (i == 0) return nodes_.front().at;
    const std::size_t before = (i - 1) / kWaySteps, step = (i - 1) % kWaySteps;
    if (step + 1 == kWaySteps) return nodes_[before + 1].at;
    const double from_s = nodes_[before].at.t_s, to_s = nodes_[before + 1].at.t_s;
    const double part = static_cast<double>(step + 1) / static_cast<double>(kWaySteps);
    return {from_s + part * (to_s - from_s), nodes_[before + 1].z_way[step]};
  }
  // The first mark not before a time, `count` where there is none.
  std::size_t NotBefore(double t_s) const {
    const auto node =
        std::ranges::lower_bound(nodes_, t_s, {}, [](const Node& n) { return n.at.t_s; });
    if (node == nodes_.begin() || node == nodes_.end()) return node == nodes_.end() ? count() : 0;
    std::size_t i = static_cast<std::size_t>(node - nodes_.begin() - 1) * kWaySteps + 1;
    while (at(i).t_s < t_s) ++i;
    return i;
  }

 private:
  const std::vector<Node>& nodes_;
};

Vector3 RateOf(const IntegralMark& a, const IntegralMark& b) {
  Vector3 out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = (b.z[c] - a.z[c]) / (b.t_s - a.t_s);
  return out;
}

// How far two rates of the output are apart, all channels together.
double Apart(const Vector3& a, const Vector3& b) {
  double square = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double apart = a[c] - b[c];
    if (std::isfinite(apart)) square += apart * apart;
  }
  return std::sqrt(square);
}

// From nothing to half of the turn's largest rate at its begin, and back at its end.
struct HalfRise {
  double begin_s = 0.0, end_s = 0.0;
};

HalfRise HalfRiseOf(const FineMarks& marks, const Rest& before, const Rest& after) {
  const Vector3 at_rest = RateOf(before.begin, before.end);
  const std::size_t first = marks.NotBefore(before.end.t_s);
  const std::size_t last = std::min(marks.NotBefore(after.begin.t_s), marks.count() - 1);
  if (first >= last) return {};
  const auto rate = [&](std::size_t from, std::size_t to) {
    return Apart(RateOf(marks.at(from), marks.at(to)), at_rest);
  };
  // Over several samples, which their noise makes too large by less.
  double largest = last - first < kWaySteps ? rate(first, last) : 0.0;
  for (std::size_t i = first; i + kWaySteps <= last; i += kWaySteps)
    largest = std::max(largest, rate(i, i + kWaySteps));
  std::size_t rise = first, fall = last;
  while (rise < last && rate(rise, rise + 1) < 0.5 * largest) ++rise;
  while (fall > rise && rate(fall - 1, fall) < 0.5 * largest) --fall;
  if (rise == last) return {};
  return {marks.at(rise).t_s - before.end.t_s, after.begin.t_s - marks.at(fall).t_s};
}

double Edge_s(double half_s, const Rest& rest) {
  const double most_s = std::min(kMostEdge_s, kMostOfRest * (rest.end.t_s - rest.begin.t_s));
  return std::clamp(kOfHalfRise * half_s, 0.0, std::max(0.0, most_s));
}

}  // namespace

std::vector<InnerRest> FindInnerRests(const Columns& columns) {
  std::vector<InnerRest> out;
  for (const Rest& rest : columns.rests) out.push_back({rest.begin, rest.end});
  const FineMarks marks(columns.nodes);
  for (std::size_t i = 0; i + 1 < columns.rests.size(); ++i) {
    const Rest& before = columns.rests[i];
    const Rest& after = columns.rests[i + 1];
    if (!std::isfinite(before.reference_end_s)) continue;
    const HalfRise half = HalfRiseOf(marks, before, after);
    // On a mark of the columns, not beyond what was found; where they lie far apart, as where the
    // reference was silent, there may be none.
    const double end_s = before.end.t_s - Edge_s(half.begin_s, before);
    const double begin_s = after.begin.t_s + Edge_s(half.end_s, after);
    const std::size_t begun = marks.NotBefore(end_s), ended = marks.NotBefore(begin_s);
    if (begun < marks.count() && marks.at(begun).t_s < before.end.t_s) out[i].end = marks.at(begun);
    if (ended > 0 && marks.at(ended - 1).t_s > after.begin.t_s)
      out[i + 1].begin = marks.at(ended - 1);
  }
  return out;
}

}  // namespace gyrobench::calibration
