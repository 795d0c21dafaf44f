#include "calibration/signal/reference_track.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/geometry.h"
#include "base/measurement_fields.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLost_s = 2.0;         // silence of one angle, and at least
constexpr double kLostIntervals = 5.0;  // so many of its usual intervals
constexpr double kOrientationLost_s = 0.2;
// Beyond what a table, a hand or the blur of a reading between two encoders' digits can do.
constexpr double kWildRate_deg_s = 5000.0;
constexpr double kWildStep_deg = 1.0;
// A jump that is no further from whole turns is an angle that was wrapped.
constexpr double kWrap_deg = 10.0;
// A step by a whole turn within this time is no motion: it would take over 1500 deg/s from one
// reading to the next.
constexpr double kWrapWithin_s = 0.24;
constexpr double kWaitForAngles_s = 5.0;
constexpr std::int64_t kWaitForReadings = 20;  // of an axis that is read
constexpr double kNormTolerance = 0.05;
// A larger step is no count of an encoder, but a motion between readings.
constexpr double kCoarsestCount_deg = 0.25;

double Length(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

}  // namespace

void ReferenceTrack::Start(const MeasurementInfo& info) {
  info_ = info;
  stand_ = kinematics::StandFrame(info.geometry);
  const bool full = info.reference == ReferenceKind::kStandAngles ||
                    info.reference == ReferenceKind::kOrientation;
  orientation_known_ = full;
  if (full && info.site_latitude_deg) {
    earth_rate_deg_s_ = kinematics::EarthRate(*info.site_latitude_deg, info.site_heading_deg);
  }
  if (info.reference == ReferenceKind::kStandAngles) watched_ = info.stand_axis_present;
  if (info.reference == ReferenceKind::kSensorAngle) {
    watched_[static_cast<std::size_t>(info.reference_axis)] = true;
  }
  if (info.reference == ReferenceKind::kOrientation) watched_ = {true, true, true};
}

// Common to all kinds. False: this reading repeats or precedes the last of its kind.
bool ReferenceTrack::BeginUpdate(double t_s, Pace* pace) {
  updated_ = false;
  rest_began_ = false;
  rest_ended_ = false;
  lost_since_s_.reset();
  if (pace->intervals >= 0 && t_s <= pace->last_s) {
    defects_.Add("repeated_time", "reference", t_s);
    return false;
  }
  const bool orientation = info_.reference == ReferenceKind::kOrientation;
  if (const auto since_s = pace->LostSince(t_s, orientation ? kOrientationLost_s : kLost_s)) {
    defects_.Add("lost_reference", "", *since_s);
    Lose(*since_s);
  }
  return true;
}

// The first interval alone does not say whether the reference is slow or was lost in it: the second
// one does.
std::optional<double> ReferenceTrack::Pace::LostSince(double t_s, double least_s) const {
  if (intervals < 1) return std::nullopt;
  const double since_s = t_s - last_s;
  if (since_s > std::max(least_s, kLostIntervals * interval_s)) return last_s;
  if (intervals == 1 && interval_s > std::max(least_s, kLostIntervals * since_s))
    return last_s - interval_s;
  return std::nullopt;
}

void ReferenceTrack::Pace::Take(double t_s) {
  constexpr double kNewestCounts = 0.1;
  const double since_s = t_s - last_s;
  if (intervals == 0) interval_s = since_s;
  // A first interval in which the reference was lost is none of its usual ones.
  if (intervals == 1 && interval_s > kLostIntervals * since_s) interval_s = since_s;
  if (intervals > 0) interval_s += (since_s - interval_s) * kNewestCounts;
  ++intervals;
  last_s = t_s;
}

void ReferenceTrack::Lose(double since_s) {
  lost_since_s_ = since_s;
  CloseRest();
  for (RestFinder& finder : finder_) finder.Reset();
}

// Whether a step from the last believed reading, at `last_s`, can be true. `since_s`: from the last
// reading of any kind. `from_suspect_deg`: the step from that one where it was left out.
bool ReferenceTrack::WithinGate(double step_deg, double since_s,
                                std::optional<double> from_suspect_deg, double last_s) {
  const double limit_deg = kWildRate_deg_s * since_s + kWildStep_deg;
  if (std::fabs(step_deg) <= limit_deg) return true;
  if (from_suspect_deg && std::fabs(*from_suspect_deg) <= limit_deg) {
    const double off_turns_deg = std::fabs(std::remainder(step_deg, kFullTurn_deg));
    const bool wrapped = std::fabs(step_deg) > kWrap_deg && off_turns_deg <= kWrap_deg;
    defects_.Add("reference_jump", wrapped ? kByWholeTurns : "", last_s);
    Lose(last_s);
    return true;
  }
  defects_.Add("reference_outlier", "", last_s);
  return false;
}

// The reading as it would be if its angle ran on, where it begins again after a turn.
double ReferenceTrack::Unwrapped(StandAngle* angle, const AngleSample& sample) {
  const double range_deg = std::fmax(angle->highest_read_deg, sample.angle_deg) -
                           std::fmin(angle->lowest_read_deg, sample.angle_deg);
  const double since_s = sample.t_s - angle->t_s;
  if (angle->known && since_s <= kWrapWithin_s && range_deg <= kFullTurn_deg + kWrapSlack_deg) {
    const double step_deg = sample.angle_deg + angle->wrapped_deg - angle->angle_deg;
    const double turns_deg = std::copysign(kFullTurn_deg, step_deg);
    const double motion_deg =
        std::min(kFullTurn_deg / 4, kWrap_deg + 2.0 * std::fabs(angle->rate_deg_s) * since_s);
    if (std::fabs(step_deg - turns_deg) <= motion_deg) {
      angle->wrapped_deg -= turns_deg;
      defects_.Add("reference_wrapped", "", sample.t_s);
    }
  }
  return sample.angle_deg + angle->wrapped_deg;
}

void ReferenceTrack::Add(const AngleSample& reading) {
  AngleSample sample = reading;
  const auto axis = static_cast<std::size_t>(sample.axis);
  updated_ = rest_began_ = rest_ended_ = false;
  lost_since_s_.reset();
  turns_since_s_.reset();
  const bool stand = info_.reference == ReferenceKind::kStandAngles;
  if (axis > 2 || !(watched_[axis] || silent_[axis]) ||
      (!stand && info_.reference != ReferenceKind::kSensorAngle))
    return;
  ++readings_;
  if (!std::isfinite(sample.angle_deg) || !std::isfinite(sample.t_s)) {
    defects_.Add("not_a_number", "reference", time_s_);
    return;
  }
  StandAngle& angle = angle_[axis];
  if (!BeginUpdate(sample.t_s, &angle.pace)) return;
  if (silent_[axis]) HearAgain(axis, sample.t_s);
  sample.angle_deg = Unwrapped(&angle, reading);
  if (!Accepts(&angle, sample)) return;
  angle.lowest_read_deg = std::fmin(angle.lowest_read_deg, reading.angle_deg);
  angle.highest_read_deg = std::fmax(angle.highest_read_deg, reading.angle_deg);
  if (!started_) first_s_ = time_s_ = sample.t_s;
  started_ = true;
  time_s_ = std::max(time_s_, sample.t_s);
  // Of an axis that has been read once nobody knows whether it rests.
  const bool turned_unseen =
      angle.pace.intervals == 0 &&
      std::fabs(sample.angle_deg - angle.angle_deg) > finder_[axis].tolerance_deg();
  const double before_s = angle.t_s;
  if (stand) {
    TurnStand(sample.t_s, axis, sample.angle_deg);
  } else if (angle.known) {
    Vector3 step = {};
    step[axis] = sample.angle_deg - angle.angle_deg;
    Turn(step);
  }
  angle.Take(sample.t_s, sample.angle_deg);
  newest_axis_ = axis;
  bool all_known = true;
  for (std::size_t a = 0; a < 3; ++a) all_known = all_known && (!watched_[a] || angle_[a].known);
  if (!all_known) {
    if (sample.t_s - first_s_ < kWaitForAngles_s) return;
    if (angle.pace.intervals >= kWaitForReadings) LeaveOutSilent();
  }
  updated_ = true;
  const bool rested = finder_[axis].resting();
  UpdateRest(axis, sample.t_s, sample.angle_deg);
  // The last reading that counts as rest may have been of motion already, too little to be seen.
  if (stand && rested && !finder_[axis].resting())
    turns_since_s_ = angle.LastBefore(finder_[axis].last_at_rest_s());
  if (stand && turned_unseen) turns_since_s_ = before_s;
}

// Axes that are announced and never read: a column that is not filled. Nothing would rest, or be
// oriented, as long as their angle is waited for.
void ReferenceTrack::LeaveOutSilent() {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!watched_[a] || angle_[a].known) continue;
    watched_[a] = false;
    silent_[a] = true;
    defects_.Add(kSilentReference, kStandAxisNames[a], first_s_);
  }
}

// What was measured before has an angle that nobody knows.
void ReferenceTrack::HearAgain(std::size_t axis, double t_s) {
  silent_[axis] = false;
  watched_[axis] = true;
  defects_.Add(kSilentReference, kStandAxisNames[axis], t_s);
  Lose(first_s_);
}

bool ReferenceTrack::Accepts(StandAngle* angle, const AngleSample& sample) {
  const std::optional<double> suspect_deg = std::exchange(angle->suspect_deg, std::nullopt);
  if (!angle->known || lost_since_s_) return true;
  std::optional<double> from_suspect_deg;
  if (suspect_deg) from_suspect_deg = sample.angle_deg - *suspect_deg;
  const double since_s = sample.t_s - (suspect_deg ? angle->suspect_s : angle->t_s);
  if (!WithinGate(sample.angle_deg - angle->angle_deg, since_s, from_suspect_deg, angle->t_s)) {
    angle->suspect_deg = sample.angle_deg;
    angle->suspect_s = sample.t_s;
    return false;
  }
  if (lost_since_s_) angle->angle_deg = sample.angle_deg;
  return true;
}

// One axis of the stand has been read: what it turned by, at the angles of the others in the middle
// of its step.
void ReferenceTrack::TurnStand(double t_s, std::size_t axis, double angle_deg) {
  const StandAngle& angle = angle_[axis];
  Vector3 at = {};
  for (std::size_t a = 0; a < 3; ++a) {
    const double ahead_s = 0.5 * (t_s + angle.t_s) - angle_[a].t_s;
    at[a] = angle_[a].angle_deg;
    if (a != axis && angle_[a].known)
      at[a] += angle_[a].rate_deg_s * std::clamp(ahead_s, -0.1, 0.1);
  }
  if (info_.site_latitude_deg) AddEarth(t_s, stand_.Orientation(at));
  if (!angle.known) return;
  const Matrix3 rates = stand_.Rates(at);
  const double step = angle_deg - angle.angle_deg;
  Turn({rates[0][axis] * step, rates[1][axis] * step, rates[2][axis] * step});
}

double ReferenceTrack::StandAngle::LastBefore(double time_s) const {
  for (const double reading_s : seen_s) {
    if (reading_s < time_s) return reading_s;
  }
  return seen_s.back();
}

void ReferenceTrack::StandAngle::Take(double now_s, double now_deg) {
  if (known) {
    const double since_s = now_s - t_s;
    rate_deg_s = since_s < 0.5 ? (now_deg - angle_deg) / since_s : 0.0;
  }
  pace.Take(now_s);
  if (!known) {
    seen_s.fill(now_s);
  } else if (now_s - seen_s[0] >= RestFinder::kClosestReadings_s) {
    std::shift_right(seen_s.begin(), seen_s.end(), 1);
    seen_s[0] = now_s;
  }
  known = true;
  t_s = now_s;
  angle_deg = now_deg;
}

void ReferenceTrack::Add(const OrientationSample& sample) {
  updated_ = rest_began_ = rest_ended_ = false;
  lost_since_s_.reset();
  turns_since_s_.reset();
  if (info_.reference != ReferenceKind::kOrientation) return;
  ++readings_;
  std::array<double, 4> q = sample.q_wxyz;
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::fabs(norm - 1.0) < kNormTolerance) || !std::isfinite(sample.t_s)) {
    defects_.Add("not_a_number", "reference", std::isfinite(sample.t_s) ? sample.t_s : time_s_);
    return;
  }
  for (double& part : q) part /= norm;
  if (!BeginUpdate(sample.t_s, &q_pace_)) return;
  if (!Accepts(q, sample.t_s)) return;
  started_ = true;
  time_s_ = sample.t_s;
  if (info_.site_latitude_deg) AddEarth(sample.t_s, kinematics::QuaternionOrientation(q));
  if (q_known_ && !lost_since_s_) Turn(kinematics::RotationBetween(q_, q));
  q_pace_.Take(sample.t_s);
  q_ = q;
  q_known_ = true;
  q_time_s_ = sample.t_s;
  updated_ = true;
  for (std::size_t c = 0; c < 3; ++c) UpdateRest(c, sample.t_s, rotation_deg_[c]);
}

bool ReferenceTrack::Accepts(const std::array<double, 4>& q, double t_s) {
  const std::optional<std::array<double, 4>> suspect = std::exchange(suspect_q_, std::nullopt);
  if (!q_known_ || lost_since_s_) return true;
  std::optional<double> from_suspect_deg;
  if (suspect) from_suspect_deg = Length(kinematics::RotationBetween(*suspect, q));
  const double since_s = t_s - (suspect ? suspect_s_ : q_time_s_);
  if (WithinGate(Length(kinematics::RotationBetween(q_, q)), since_s, from_suspect_deg, q_time_s_))
    return true;
  suspect_q_ = q;
  suspect_s_ = t_s;
  return false;
}

bool ReferenceTrack::SettledAt(double t_s) const {
  constexpr double kPatience_s = 0.5;
  if (time_s_ <= t_s) return false;
  if (info_.reference != ReferenceKind::kStandAngles || time_s_ - t_s > kPatience_s) return true;
  for (std::size_t a = 0; a < 3; ++a) {
    if (watched_[a] && angle_[a].known && angle_[a].seen_s[2] <= t_s) return false;
  }
  return true;
}

// What the axis has turned since it was read, at its last rate [deg].
double ReferenceTrack::Ahead(std::size_t axis) const {
  const StandAngle& angle = angle_[axis];
  if (!angle.known || axis == newest_axis_ || finder_[axis].resting()) return 0.0;
  return angle.rate_deg_s * std::clamp(time_s_ - angle.t_s, 0.0, 0.1);
}

Vector3 ReferenceTrack::rotation_now_deg() const {
  Vector3 out = rotation_deg_;
  if (info_.reference != ReferenceKind::kStandAngles) return out;
  const Matrix3 rates = stand_.Rates(table_now_deg());
  for (std::size_t a = 0; a < 3; ++a) {
    const double ahead_deg = watched_[a] ? Ahead(a) : 0.0;
    if (ahead_deg == 0.0) continue;
    for (std::size_t c = 0; c < 3; ++c) out[c] += rates[c][a] * ahead_deg;
  }
  return out;
}

bool ReferenceTrack::leading() const {
  if (info_.reference != ReferenceKind::kStandAngles) return true;
  // One that rests never does while another moves: where that reverses or stops it is slower for a
  // moment than the noise of the one at rest, and not where its last rate would have it.
  const bool rests = finder_[newest_axis_].resting();
  const double rate = std::fabs(angle_[newest_axis_].rate_deg_s);
  for (std::size_t a = 0; a < 3; ++a) {
    if (a == newest_axis_ || !watched_[a] || !angle_[a].known || finder_[a].resting()) continue;
    if (rests || std::fabs(angle_[a].rate_deg_s) > rate) return false;
  }
  return true;
}

Vector3 ReferenceTrack::table_now_deg() const {
  Vector3 out = {kMissing, kMissing, kMissing};
  if (info_.reference == ReferenceKind::kOrientation) return out;
  for (std::size_t a = 0; a < 3; ++a) {
    if (watched_[a] && angle_[a].known) out[a] = angle_[a].angle_deg + Ahead(a);
    if (!watched_[a] && info_.reference == ReferenceKind::kStandAngles) out[a] = 0.0;
  }
  return out;
}

Matrix3 ReferenceTrack::world_now() const {
  if (info_.reference == ReferenceKind::kStandAngles) return stand_.Orientation(table_now_deg());
  if (info_.reference == ReferenceKind::kOrientation) return kinematics::QuaternionOrientation(q_);
  Matrix3 out;
  for (Vector3& row : out) row.fill(kMissing);
  return out;
}

void ReferenceTrack::Turn(const Vector3& increment_deg) {
  for (std::size_t c = 0; c < 3; ++c) {
    rotation_deg_[c] += increment_deg[c];
    path_deg_[c] += std::fabs(increment_deg[c]);
  }
}

void ReferenceTrack::AddEarth(double t_s, const Matrix3& orientation) {
  const Vector3 rate = kinematics::TransposedTimes(orientation, earth_rate_deg_s_);
  if (earth_time_s_ && t_s > *earth_time_s_) {
    for (std::size_t c = 0; c < 3; ++c) earth_deg_[c] += rate[c] * (t_s - *earth_time_s_);
  }
  if (!earth_time_s_ || t_s > *earth_time_s_) earth_time_s_ = t_s;
}

Vector3 ReferenceTrack::read_range_deg() const {
  Vector3 range_deg = {};
  for (std::size_t a = 0; a < 3; ++a)
    range_deg[a] = angle_[a].highest_read_deg - angle_[a].lowest_read_deg;
  return range_deg;
}

bool ReferenceTrack::AllRest() const {
  for (std::size_t a = 0; a < 3; ++a) {
    if (watched_[a] && !finder_[a].resting()) return false;
  }
  return true;
}

void ReferenceTrack::KeepReading() {
  recent_[recent_count_ % kRecent] = Recent{time_s_, rotation_deg_};
  ++recent_count_;
}

void ReferenceTrack::CloseRest() {
  if (!open_) return;
  ended_ = *open_;
  open_.reset();
  rest_ended_ = true;
}

void ReferenceTrack::UpdateRest(std::size_t axis, double t_s, double angle_deg) {
  const RestFinder::Change change = finder_[axis].Add(t_s, angle_deg);
  if (change == RestFinder::Change::kOutlier) defects_.Add("reference_outlier", "", t_s);
  if (open_ && change == RestFinder::Change::kRestEnded) {
    open_->last_at_rest_s = finder_[axis].last_at_rest_s();
    CloseRest();
  } else if (open_ && finder_[axis].within()) {
    // The reading before is at rest for certain: it was followed by another at rest.
    // Of axes that are read at once the last one's reading has them all.
    const Recent& before = recent_[(recent_count_ + kRecent - 1) % kRecent];
    if (pending_ && recent_count_ > 0 && before.t_s < t_s)
      open_->Add(before.t_s, before.rotation_deg);
    open_->last_at_rest_s = t_s;
  }
  pending_ = finder_[axis].within();
  if (!open_ && change == RestFinder::Change::kRestBegan && AllRest()) {
    OpenRest rest;
    rest.origin_deg = rotation_deg_;
    rest.last_at_rest_s = t_s;
    for (std::size_t a = 0; a < 3; ++a) {
      if (watched_[a])
        rest.coarse_begin_s = std::max(rest.coarse_begin_s, finder_[a].rest_begin_s());
      if (watched_[a] && step_deg(a) < kCoarsestCount_deg)
        rest.count_deg = std::max(rest.count_deg, step_deg(a));
    }
    rest.axes = static_cast<int>(std::ranges::count(watched_, true));
    const std::size_t kept = std::min(recent_count_, kRecent);
    for (std::size_t age = kept; age-- > 0;) {
      const Recent& reading = recent_[(recent_count_ - 1 - age) % kRecent];
      const double next_s = age > 0 ? recent_[(recent_count_ - age) % kRecent].t_s : t_s;
      // The first readings within the tolerance may still creep.
      if (reading.t_s > rest.coarse_begin_s + 0.05 && reading.t_s < next_s)
        rest.Add(reading.t_s, reading.rotation_deg);
    }
    open_ = rest;
    rest_began_ = true;
  }
  KeepReading();
}

}  // namespace gyrobench::calibration
