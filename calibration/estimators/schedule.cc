#include "calibration/estimators/schedule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/signal/intake.h"

namespace gyrobench::calibration {
namespace {

// One end of an interval.
struct End {
  IntegralMark at;
  Vector3 rotation_deg = {};
  Vector3 earth_deg = {};
};

End EndOf(const Node& node) { return {node.at, node.rotation_deg, node.earth_deg}; }

std::size_t FirstNodeAfter(const Columns& columns, double t_s) {
  const auto found = std::upper_bound(columns.nodes.begin(), columns.nodes.end(), t_s,
                                      [](double t, const Node& node) { return t < node.at.t_s; });
  return static_cast<std::size_t>(found - columns.nodes.begin());
}

Vector3 EarthAt(const Columns& columns, double t_s) {
  if (columns.nodes.empty()) return {};
  const std::size_t next = FirstNodeAfter(columns, t_s);
  if (next == 0) return columns.nodes.front().earth_deg;
  if (next == columns.nodes.size()) return columns.nodes.back().earth_deg;
  const Node& a = columns.nodes[next - 1];
  const Node& b = columns.nodes[next];
  const double part = (t_s - a.at.t_s) / (b.at.t_s - a.at.t_s);
  Vector3 out;
  for (std::size_t c = 0; c < 3; ++c)
    out[c] = a.earth_deg[c] + part * (b.earth_deg[c] - a.earth_deg[c]);
  return out;
}

// Mean of the nodes' temperatures over (begin, end]; of the nearest node where none lies inside.
double TemperatureOver(const Columns& columns, double begin_s, double end_s) {
  double sum = 0.0;
  int n = 0;
  std::size_t i = FirstNodeAfter(columns, begin_s);
  for (; i < columns.nodes.size(); ++i) {
    const bool inside = columns.nodes[i].at.t_s <= end_s;
    if (!inside && n > 0) break;
    if (std::isfinite(columns.nodes[i].temperature_degC)) {
      sum += columns.nodes[i].temperature_degC;
      ++n;
    }
    if (!inside) break;
  }
  return n > 0 ? sum / n : kMissing;
}

// Says for rows in order of time which channels may be used.
class BadCursor {
 public:
  explicit BadCursor(const Columns& columns) : bad_(columns.bad) {}
  void Mark(Row* row) {
    row->usable = {true, true, true};
    for (std::size_t i = first_; i < bad_.size() && bad_[i].begin_s < row->end_s; ++i) {
      if (bad_[i].end_s <= row->begin_s) {
        if (i == first_) ++first_;
        continue;
      }
      for (std::size_t c = 0; c < 3; ++c) row->usable[c] = row->usable[c] && !bad_[i].channel[c];
    }
  }

 private:
  const std::vector<BadStretch>& bad_;
  std::size_t first_ = 0;
};

Row MakeRow(const Columns& columns, const End& a, const End& b, bool still, std::size_t rest) {
  Row row;
  row.begin_s = a.at.t_s;
  row.end_s = b.at.t_s;
  row.still = still;
  row.rest = rest;
  for (std::size_t c = 0; c < 3; ++c) {
    row.z[c] = b.at.z[c] - a.at.z[c];
    row.rotation_deg[c] = still ? 0.0 : b.rotation_deg[c] - a.rotation_deg[c];
    row.earth_deg[c] = b.earth_deg[c] - a.earth_deg[c];
  }
  row.temperature_degC = TemperatureOver(columns, row.begin_s, row.end_s);
  return row;
}

class RowMaker {
 public:
  // `inner`: one for each of the rests; none where they are not asked for.
  RowMaker(const Columns& columns, double piece_s, std::vector<InnerRest> inner = {})
      : columns_(columns), piece_s_(piece_s), bad_(columns), inner_(std::move(inner)) {}

  End BeginOfRest(std::size_t index) const { return EndAt(index, inner_[index].begin); }
  End EndOfRest(std::size_t index) const { return EndAt(index, inner_[index].end); }

  void Add(const End& a, const End& b, bool still, std::size_t rest) {
    if (!(b.at.t_s > a.at.t_s)) return;
    Row row = MakeRow(columns_, a, b, still, rest);
    bad_.Mark(&row);
    rows_.push_back(row);
  }
  void AddRest(std::size_t index) {
    End begin = BeginOfRest(index);
    const End end = EndOfRest(index);
    for (std::size_t i = FirstNodeAfter(columns_, begin.at.t_s); i < columns_.nodes.size(); ++i) {
      const Node& node = columns_.nodes[i];
      if (node.at.t_s > end.at.t_s - 0.5 * piece_s_) break;
      if (node.at.t_s - begin.at.t_s < piece_s_ - 1e-3) continue;
      Add(begin, EndOf(node), true, index);
      begin = EndOf(node);
    }
    Add(begin, end, true, index);
  }
  std::vector<Row> Take() { return std::move(rows_); }

 private:
  End EndAt(std::size_t rest, const IntegralMark& at) const {
    return {at, columns_.rests[rest].rotation_deg, EarthAt(columns_, at.t_s)};
  }

  const Columns& columns_;
  double piece_s_;
  BadCursor bad_;
  std::vector<InnerRest> inner_;
  std::vector<Row> rows_;
};

}  // namespace

std::vector<Vector3> GravityOver(const Columns& columns, const std::vector<Row>& rows) {
  std::vector<double> t_s;
  std::vector<Vector3> integral_g_s;
  const Vector3* before = nullptr;
  for (const Node& node : columns.nodes) {
    const bool known = std::ranges::all_of(node.world_z, [](double x) { return std::isfinite(x); });
    if (!known) continue;
    Vector3 sum = {};
    if (before != nullptr) {
      const double half_s = 0.5 * (node.at.t_s - t_s.back());
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] = integral_g_s.back()[c] + half_s * ((*before)[c] + node.world_z[c]);
    }
    t_s.push_back(node.at.t_s);
    integral_g_s.push_back(sum);
    before = &node.world_z;
  }
  if (t_s.size() < 2) return {};
  // Beyond the first and the last as between the two nodes that are next.
  const auto at = [&](double time_s) {
    const auto above = std::upper_bound(t_s.begin() + 1, t_s.end() - 1, time_s) - t_s.begin();
    const auto b = static_cast<std::size_t>(above), a = b - 1;
    const double part = (time_s - t_s[a]) / (t_s[b] - t_s[a]);
    Vector3 out;
    for (std::size_t c = 0; c < 3; ++c)
      out[c] = std::lerp(integral_g_s[a][c], integral_g_s[b][c], part);
    return out;
  };
  std::vector<Vector3> out;
  for (const Row& row : rows) {
    const Vector3 begin = at(row.begin_s), end = at(row.end_s);
    out.push_back({end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]});
  }
  return out;
}

std::vector<Row> RestRows(const Columns& columns, double piece_s) {
  RowMaker maker(columns, piece_s, FindInnerRests(columns));
  for (std::size_t i = 0; i < columns.rests.size(); ++i) maker.AddRest(i);
  return maker.Take();
}

std::vector<Row> StopRows(const Columns& columns, double piece_s) {
  RowMaker maker(columns, piece_s, FindInnerRests(columns));
  for (std::size_t i = 0; i < columns.rests.size(); ++i) {
    maker.AddRest(i);
    if (i + 1 == columns.rests.size()) break;
    maker.Add(maker.EndOfRest(i), maker.BeginOfRest(i + 1), false, i);
  }
  return maker.Take();
}

std::vector<Row> NodeRows(const Columns& columns, double piece_s) {
  RowMaker maker(columns, piece_s);
  std::size_t rest = 0, begin = 0;
  const std::vector<Node>& nodes = columns.nodes;
  while (begin + 1 < nodes.size()) {
    const double t_s = nodes[begin].at.t_s;
    while (rest < columns.rests.size() && columns.rests[rest].end.t_s <= t_s) ++rest;
    const bool in_rest = rest < columns.rests.size() && columns.rests[rest].begin.t_s <= t_s;
    std::size_t end = begin + 1;
    if (in_rest && nodes[end].at.t_s <= columns.rests[rest].end.t_s) {
      while (end + 1 < nodes.size() && nodes[end + 1].at.t_s <= columns.rests[rest].end.t_s &&
             nodes[end].at.t_s - t_s < piece_s - 1e-3) {
        ++end;
      }
      maker.Add(EndOf(nodes[begin]), EndOf(nodes[end]), true, rest);
    } else {
      maker.Add(EndOf(nodes[begin]), EndOf(nodes[end]), false, rest);
    }
    begin = end;
  }
  return maker.Take();
}

namespace {

// By the accelerometer: its mean changed its side along some axis.
bool WasTurnedOver(const MeasurementInfo& info, const std::vector<Node>& nodes) {
  constexpr double kSides_g = 1.0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info.accel_present[c] || !info.gyro_present[c]) return false;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    double low = 0.0, high = 0.0;
    for (const Node& node : nodes) {
      low = std::fmin(low, node.accel_g[c]);
      high = std::fmax(high, node.accel_g[c]);
    }
    if (high - low > kSides_g) return true;
  }
  return false;
}

}  // namespace

void RemarkOnReference(const Estimation& estimation, std::vector<std::string>* remarks) {
  const MeasurementInfo& info = estimation.info;
  const std::vector<Node>& nodes = estimation.columns.nodes;
  if (info.reference == ReferenceKind::kNone) {
    remarks->push_back("no reference: the sensor is taken to be at rest; no scale factor");
    if (estimation.columns.rests.empty()) {
      remarks->push_back("no stretch at rest of 2 s was found: no bias");
    }
    if (WasTurnedOver(info, nodes)) {
      remarks->push_back("gravity turned through the sensor: " + WithoutReference(info));
    }
    return;
  }
  if (nodes.size() < 2) {
    remarks->push_back("the reference gave no usable reading while the gyro ran: no scale factor");
    return;
  }
  double range = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto [low, high] = std::minmax_element(
        nodes.begin(), nodes.end(),
        [c](const Node& a, const Node& b) { return a.rotation_deg[c] < b.rotation_deg[c]; });
    range = std::max(range, high->rotation_deg[c] - low->rotation_deg[c]);
  }
  if (range < estimation.options.min_rotation_deg) {
    remarks->push_back(fmt::format(
        "the reference moved by {:.3g} deg in all, at least {:.3g} is needed: no scale factor",
        range, estimation.options.min_rotation_deg));
  }
  if (!info.site_latitude_deg) {
    remarks->push_back(
        "site latitude is not given: Earth's rotation stays in the bias (0.0042 deg/s at most)");
  } else if (!estimation.orientation_known) {
    remarks->push_back(
        "the sensor's orientation in the room is not known: Earth's rotation stays in the bias");
  }
}

TemperatureRange Temperatures(const std::vector<Row>& rows, std::size_t channel) {
  TemperatureRange out;
  double sum = 0.0, time_s = 0.0;
  for (const Row& row : rows) {
    if (!row.usable[channel] || !std::isfinite(row.temperature_degC)) continue;
    sum += row.temperature_degC * row.duration_s();
    time_s += row.duration_s();
    out.min = std::fmin(out.min, row.temperature_degC);
    out.max = std::fmax(out.max, row.temperature_degC);
  }
  if (time_s > 0) out.mean = sum / time_s;
  return out;
}

}  // namespace gyrobench::calibration
