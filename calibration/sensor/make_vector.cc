#include "calibration/sensor/make_vector.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibration/gls/statistics.h"
#include "calibration/sensor/accelerometer.h"
#include "calibration/sensor/least_squares.h"
#include "calibration/sensor/sensor_matrix.h"
#include "calibration/state/state_history.h"

namespace gyrobench::calibration {
namespace {

using ChannelRows = std::array<const ChannelRow*, 3>;

void ListMissing(const ChannelRows& rows, std::vector<std::string>* missing) {
  std::vector<std::string> absent, unturned;
  for (std::size_t c = 0; c < 3; ++c)
    if (rows[c] == nullptr) absent.push_back(std::string(1, "xyz"[c]));
  if (!absent.empty()) {
    missing->push_back(fmt::format(
        "gyro {} {} not traced: the matrix takes three axes, measured and turned together",
        fmt::join(absent, " and "), absent.size() == 1 ? "was" : "were"));
  }
  for (std::size_t j = 0; j < 3; ++j) {
    const bool seen = std::all_of(rows.begin(), rows.end(), [j](const ChannelRow* row) {
      return row == nullptr || std::isfinite(row->values[static_cast<Eigen::Index>(j)]);
    });
    if (!seen) unturned.push_back(std::string(1, "xyz"[j]));
  }
  if (!unturned.empty()) {
    missing->push_back(fmt::format(
        "the sensor never turned about {0}: what the axes feel of it is not known; turn about {0} "
        "against the reference",
        fmt::join(unturned, " and ")));
  }
}

// Of the values of two rows.
Eigen::MatrixXd CommonCovariance(const ChannelRow& a, const ChannelRow& b) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(a.values.size(), b.values.size());
  for (std::size_t i = 0; i < a.common.size(); ++i) {
    for (std::size_t j = 0; j < b.common.size(); ++j) {
      if (a.common[i] != b.common[j]) continue;
      out += a.by_common.col(static_cast<Eigen::Index>(i)) *
             b.by_common.col(static_cast<Eigen::Index>(j)).transpose();
    }
  }
  return out;
}

void FillMatrix(const ChannelRows& rows, VectorCalibration* out) {
  MatrixWithCovariance m;
  Eigen::Vector3d s0;
  ReferenceError reference;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    m.value.row(i) = rows[c]->values.head<3>().transpose();
    m.covariance.block<3, 3>(3 * i, 3 * i) = rows[c]->covariance.topLeftCorner<3, 3>();
    for (std::size_t d = 0; d < 3; ++d) {
      if (d == c) continue;
      m.covariance.block<3, 3>(3 * i, 3 * static_cast<Eigen::Index>(d)) =
          CommonCovariance(*rows[c], *rows[d]).topLeftCorner<3, 3>();
    }
    s0[i] = rows[c]->units_per_deg_s;
    // One reference for all three: where channels took different parts of its error off, the
    // larger rest.
    const ReferenceError& own = rows[c]->reference;
    reference.said = reference.said || own.said;
    reference.common = std::max(reference.common, own.common);
    reference.across = std::max(reference.across, own.across);
    for (std::size_t j = 0; j < 3; ++j) reference.own[j] = std::max(reference.own[j], own.own[j]);
  }
  const MatrixWithCovariance statistical = InverseOver(m, s0);
  const Matrix9 m_statistical = m.covariance;
  m.covariance += ReferenceCovariance(m.value, reference);
  const MatrixWithCovariance a = InverseOver(m, s0);
  if (!a.value.allFinite()) {
    out->missing.emplace_back("the matrix has no inverse: its axes do not span space");
    return;
  }
  VectorMatrix& matrix = out->matrix.emplace();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      const Eigen::Index k = 3 * row + column;
      matrix.m[i][j] = m.value(row, column);
      matrix.a[i][j] = a.value(row, column);
      matrix.m_std_error[i][j] = std::sqrt(m.covariance(k, k));
      matrix.a_std_error[i][j] = std::sqrt(a.covariance(k, k));
      matrix.m_statistical_std_error[i][j] = std::sqrt(m_statistical(k, k));
      matrix.a_statistical_std_error[i][j] = std::sqrt(statistical.covariance(k, k));
    }
  }
  matrix.m_covariance.assign(m.covariance.data(), m.covariance.data() + 81);
  matrix.a_covariance.assign(a.covariance.data(), a.covariance.data() + 81);
  out->split = SplitAxes(m);
  if (!out->split) {
    out->remarks.emplace_back(
        "the gyro's axes are left-handed or nearly in one plane: there is no mounting rotation; is "
        "the sign of one axis reversed?");
  }
}

void FillGravity(const ChannelRows& rows, VectorCalibration* out) {
  GSensitivity g;
  std::map<std::string, std::string> axes_by_reason;
  for (std::size_t c = 0; c < 3; ++c) {
    if (rows[c] == nullptr) continue;
    const GravityRow& row = rows[c]->gravity;
    for (std::size_t j = 0; j < 3; ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      g.value[c][j] = row.value[k];
      g.statistical_std_error[c][j] = row.std_error[k];
      g.std_error[c][j] = std::hypot(row.std_error[k], std::sqrt(row.earth_covariance(k, k)));
    }
    g.in_model[c] = row.in_model;
    if (!row.because.empty()) axes_by_reason[row.because] += "xyz"[c];
  }
  for (const auto& [reason, axes] : axes_by_reason)
    g.because.push_back(fmt::format("gyro {}: {}", fmt::join(axes, ", "), reason));
  out->g_sensitivity = std::move(g);
}

// Where a channel's values are in those of all.
struct Joint {
  JointEstimate separate;
  std::vector<Eigen::Index> matrix;  // elements of M
  struct Group {
    std::string unit, channels;
    std::vector<Eigen::Index> members;
  };
  std::map<std::string, Group> groups;
};

Joint Stack(const ChannelRows& rows) {
  Joint joint;
  Eigen::Index total = 0;
  for (const ChannelRow* row : rows) total += row == nullptr ? 0 : row->values.size();
  joint.separate.values.resize(total);
  joint.separate.covariance = Eigen::MatrixXd::Zero(total, total);
  Eigen::Index begin = 0;
  std::array<Eigen::Index, 3> begins = {};
  for (std::size_t c = 0; c < 3; ++c) {
    if (rows[c] == nullptr) continue;
    const ChannelRow& row = *rows[c];
    begins[c] = begin;
    const Eigen::Index count = row.values.size();
    joint.separate.values.segment(begin, count) = row.values;
    joint.separate.covariance.block(begin, begin, count, count) = row.covariance;
    for (std::size_t d = 0; d < c; ++d) {
      if (rows[d] == nullptr) continue;
      const Eigen::MatrixXd across = CommonCovariance(row, *rows[d]);
      joint.separate.covariance.block(begin, begins[d], count, across.cols()) = across;
      joint.separate.covariance.block(begins[d], begin, across.cols(), count) = across.transpose();
    }
    for (Eigen::Index j = 0; j < 3; ++j)
      if (std::isfinite(row.values[j])) joint.matrix.push_back(begin + j);
    for (std::size_t k = 0; k < row.shared.size(); ++k) {
      const Eigen::Index at = begin + 3 + static_cast<Eigen::Index>(k);
      if (!(row.covariance(3 + static_cast<Eigen::Index>(k), 3 + static_cast<Eigen::Index>(k)) > 0))
        continue;
      Joint::Group& group = joint.groups[row.shared[k].name];
      group.unit = row.shared[k].unit;
      group.channels += "xyz"[c];
      group.members.push_back(at);
    }
    begin += count;
  }
  return joint;
}

// Without what is not known; `kept` in the order of the values.
JointEstimate Kept(const JointEstimate& all, const std::vector<Eigen::Index>& kept) {
  return {all.values(kept), all.covariance(kept, kept), 0.0, 0};
}

void FillShared(const ChannelRows& rows, VectorCalibration* out) {
  const Joint joint = Stack(rows);
  std::vector<Eigen::Index> kept = joint.matrix;
  std::vector<std::vector<Eigen::Index>> groups;
  for (const auto& [name, group] : joint.groups) {
    if (group.members.size() < 2) continue;
    std::vector<Eigen::Index> places, alone(group.members.size());
    for (const Eigen::Index member : group.members) {
      places.push_back(static_cast<Eigen::Index>(kept.size()));
      kept.push_back(member);
    }
    for (std::size_t k = 0; k < alone.size(); ++k) alone[k] = static_cast<Eigen::Index>(k);
    const JointEstimate one = HoldEqual(Kept(joint.separate, group.members), {alone});
    out->shared.push_back(
        {name, group.unit, group.channels, one.values[0], std::sqrt(one.covariance(0, 0)),
         std::exp(LogChiSquareTail(one.misfit, static_cast<double>(one.constraints)))});
    groups.push_back(places);
  }
  if (groups.empty()) return;
  const JointEstimate before = Kept(joint.separate, kept), after = HoldEqual(before, groups);
  out->shared_gain = 0.0;
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(joint.matrix.size()); ++k) {
    const double share = 1.0 - std::sqrt(after.covariance(k, k) / before.covariance(k, k));
    out->shared_gain = std::max(out->shared_gain, share);
  }
}

// The axis of the sensor that alone was turned about, where all three channels say what they feel.
std::optional<std::size_t> OnlyAxisTurned(const ChannelRows& rows) {
  std::optional<std::size_t> only;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto feels = [j](const ChannelRow* row) {
      return row != nullptr && std::isfinite(row->values[static_cast<Eigen::Index>(j)]);
    };
    if (std::ranges::none_of(rows, feels)) continue;
    if (only || !std::ranges::all_of(rows, feels)) return std::nullopt;
    only = j;
  }
  return only;
}

// A mounting can be declared, and none is yet.
bool MountIsOpen(std::span<const StateHistory> histories) {
  return std::ranges::all_of(histories, [](const StateHistory& history) {
    const MeasurementInfo& info = history.recording->info;
    return info.reference == ReferenceKind::kStandAngles && info.geometry.mount_deg == Vector3{};
  });
}

// "mount_x_deg = 1.2 and mount_y_deg = -0.8": of R_mount^T z = `felt`, where it can be declared.
// Empty else.
std::string MountKeys(const Eigen::Vector3d& felt, std::span<const StateHistory> histories) {
  if (!MountIsOpen(histories)) return "";
  return fmt::format(", or declare mount_x_deg = {:.2f} and mount_y_deg = {:.2f}",
                     kDegPerRad * std::atan2(felt.y(), felt.z()),
                     -kDegPerRad * std::asin(felt.x()));
}

// Of all three axes the matrix tells how the sensor sits. `kUnnoticed_deg`: a part that is soldered
// and clamped with care sits better.
void RemarkOnMounting(std::span<const StateHistory> histories, VectorCalibration* out) {
  constexpr double kUnnoticed_deg = 3.0, kSure = 3.0;
  if (!out->split) return;
  const AxisSplit& split = *out->split;
  double trace = 0.0, error_deg = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    trace += split.r_mount[i][i];
    error_deg = std::hypot(error_deg, split.mount_std_error_deg[i]);
  }
  const double turned_deg = kDegPerRad * std::acos(std::clamp(0.5 * (trace - 1.0), -1.0, 1.0));
  // Of angles that have no error, as where y is 90 deg, the size tells enough.
  if (!(turned_deg > kUnnoticed_deg + kSure * (std::isfinite(error_deg) ? error_deg : 0.0))) return;
  const std::string keys =
      fmt::format("mount_x_deg = {:.2f}, mount_y_deg = {:.2f} and mount_z_deg = {:.2f}",
                  split.mount_deg[0], split.mount_deg[1], split.mount_deg[2]);
  out->remarks.push_back(fmt::format(
      "the gyro sits turned by {:.1f} deg from what is declared. scale_factor and cross_axis of "
      "each channel are by the declared axes; the scale factors of its own axes stand with the "
      "matrix. If it was mounted so, {}. If not, look for columns that are exchanged or have "
      "another sign",
      turned_deg,
      MountIsOpen(histories) ? "declare " + keys
                             : "correct the mounting or the orientation by " + keys));
}

// One axis turned alone does not tell a sensor that sits crooked from one whose axes are: what the
// other two feel is the sine of either angle, and a scale factor by the first is too small by its
// cosine. `kUsual`: what a data sheet allows of one axis (docs/calibration.md).
void RemarkOnTilt(const ChannelRows& rows, std::span<const StateHistory> histories,
                  VectorCalibration* out) {
  constexpr double kUsual = 0.02, kSure = 3.0, kSameUnit = 0.1;
  const std::optional<std::size_t> only = OnlyAxisTurned(rows);
  if (!only) return;
  const auto j = static_cast<Eigen::Index>(*only);
  Eigen::Vector3d felt;
  bool unusual = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = felt[static_cast<Eigen::Index>(c)] = rows[c]->values[j];
    const double units = rows[c]->units_per_deg_s / rows[*only]->units_per_deg_s;
    if (!(std::fabs(units - 1.0) < kSameUnit)) return;
    const bool sure = std::fabs(value) > kSure * std::sqrt(rows[c]->covariance(j, j));
    unusual = unusual || (c != *only && sure && std::fabs(value) > kUsual);
  }
  felt.normalize();
  if (!unusual || !(felt[j] > 0.5)) return;
  const std::size_t a = *only == 0 ? 1 : 0, b = *only == 2 ? 1 : 2;
  out->remarks.push_back(fmt::format(
      "gyro {} feels {:.1f} % of what turns about {}, and gyro {} {:.1f} %: the sensor sits tilted "
      "to the axis by {:.2f} deg more than is declared, or its axes are misaligned by as much, and "
      "turns about one axis do not tell which; if it is tilted, the scale factor of {} is larger "
      "than stated here by {:.2g} %; turn about the other axes as well{}",
      "xyz"[a], 100.0 * felt[static_cast<Eigen::Index>(a)], "xyz"[*only], "xyz"[b],
      100.0 * felt[static_cast<Eigen::Index>(b)], kDegPerRad * std::acos(felt[j]), "xyz"[*only],
      100.0 * (1.0 / felt[j] - 1.0), *only == 2 ? MountKeys(felt, histories) : ""));
}

ChannelRows ByChannel(std::span<const ChannelRow> rows) {
  ChannelRows by_channel = {};
  for (const ChannelRow& row : rows)
    if (row.fitted) by_channel.at(row.channel) = &row;
  return by_channel;
}

}  // namespace

VectorCalibration JoinChannels(std::span<const ChannelRow> rows) {
  VectorCalibration out;
  const ChannelRows by_channel = ByChannel(rows);
  for (const ChannelRow& row : rows) out.unit = row.unit;
  ListMissing(by_channel, &out.missing);
  if (out.missing.empty()) FillMatrix(by_channel, &out);
  FillGravity(by_channel, &out);
  FillShared(by_channel, &out);
  return out;
}

VectorCalibration MakeVectorCalibration(std::span<const ChannelRow> rows,
                                        std::span<const StateHistory> histories) {
  VectorCalibration out = JoinChannels(rows);
  const std::vector<Pose> poses = FindPoses(histories);
  out.accelerometer = CalibrateAccelerometer(poses);
  RemarkOnTilt(ByChannel(rows), histories, &out);
  RemarkOnMounting(histories, &out);
  const bool earth =
      std::all_of(histories.begin(), histories.end(),
                  [](const StateHistory& history) { return history.earth_rate_known; });
  if (!earth && out.g_sensitivity) {
    out.remarks.emplace_back(
        "Earth's rotation is not taken off: its vertical part, up to 0.0042 deg/s/g, is one with "
        "the "
        "g-sensitivity of an axis to gravity along itself; the errors count it; to take it off "
        "takes "
        "the site's latitude and the orientation of the sensor");
  }
  return out;
}

}  // namespace gyrobench::calibration
