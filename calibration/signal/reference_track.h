// The reference's readings as rotation about the sensor's axes, and its rests.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/measurement.h"
#include "calibration/signal/columns.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/rest_finder.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {

// Where a jump of the reference was, in its defect, when it left out whole turns.
inline constexpr const char* kByWholeTurns = "by whole turns";

// Defect of an axis of the stand that is announced and was not read as the others began, of which
// `where` is the name: counted twice where it was read later.
inline constexpr const char* kSilentReference = "silent_reference";

// What the noise of readings adds to the range of an angle that never leaves one turn.
inline constexpr double kWrapSlack_deg = 2.0;

// Adds up rotation about the sensor's axes from any kind of reference. The three angles of a stand
// are read at their own times: where others turn at once, their angles are carried forward at their
// last rate. Memory is bounded.
//
// Recognised: a reading that no table can have turned to since the last one (over 5000 deg/s) is
// left out, as `reference_outlier`; when the next one confirms it, the reference itself has jumped
// (its count was lost): `reference_jump`, a stretch without reference, across which nothing is
// taken to have turned. An angle that stays within a turn and steps by all of it is wrapped: it is
// read as one that runs on, `reference_wrapped`.An axis that is announced and not read
// within 5 s and 20 readings of another is taken to stand, `silent_reference`; where it is read
// later, what was measured before is a stretch without reference.
class ReferenceTrack {
 public:
  void Start(const MeasurementInfo& info);
  void Add(const AngleSample& reading);
  void Add(const OrientationSample& sample);

  // After each Add: whether it brought a usable reading, and where it stands.
  bool updated() const { return updated_; }
  double time_s() const { return time_s_; }
  const Vector3& rotation_deg() const { return rotation_deg_; }
  // The same at the time of this reading, where other axes of the stand were read before it and
  // moved on at their last rate.
  Vector3 rotation_now_deg() const;
  // No axis that was read at another time turns faster than the one of this reading.
  bool leading() const;
  // The axis of this reading was at rest and turns: since when, at the earliest. What other axes'
  // readings said since then has its angle from before.
  std::optional<double> turns_since_s() const { return turns_since_s_; }
  std::size_t newest_axis() const { return newest_axis_; }
  // Each watched axis has been read three times after `t_s`, or not for a while: whether one of
  // them had begun to turn by then is known, for a motion is believed at its second reading, and
  // the one before may have been too little to be seen.
  bool SettledAt(double t_s) const;
  // Angles of the watched axes now; NaN for others, and for an orientation reference.
  Vector3 table_now_deg() const;
  // World axes in the sensor's frame (rows of R_WS); NaN where the orientation is not known.
  Matrix3 world_now() const;
  const Vector3& earth_deg() const { return earth_deg_; }
  // Every watched axis rests.
  bool all_rest() const { return AllRest(); }
  // The least difference of two readings of a watched axis in a row: the step of a coarse encoder,
  // or something smaller.
  double step_deg(std::size_t axis) const { return finder_[axis].step_deg(); }
  // Of the stand's axes, or the one of a single-axis table, the largest reading less the smallest,
  // as they were read; NaN where there was none.
  Vector3 read_range_deg() const;
  // After each Add: a rest began (and is open), or ended.
  bool rest_began() const { return rest_began_; }
  bool rest_ended() const { return rest_ended_; }
  const std::optional<OpenRest>& open_rest() const { return open_; }
  // The rest that just ended.
  const OpenRest& ended_rest() const { return ended_; }
  // A stretch without reference ended with this reading: its begin.
  std::optional<double> lost_since_s() const { return lost_since_s_; }

  // The stand's axis was announced and has not been read: it is taken to stand at 0 deg.
  bool silent(std::size_t axis) const { return silent_[axis]; }
  bool orientation_known() const { return orientation_known_; }
  std::int64_t readings() const { return readings_; }
  double path_deg(std::size_t sensor_axis) const { return path_deg_[sensor_axis]; }
  const DefectLog& defects() const { return defects_; }

 private:
  // How often a reference is read.
  struct Pace {
    std::int64_t intervals = -1;  // so far; -1 before the first reading
    double last_s = 0.0;
    double interval_s = 0.0;  // mean of late
    // Where the silence before a reading at `t_s`, or the one before it, was too long for this
    // pace and longer than `least_s`: its begin.
    std::optional<double> LostSince(double t_s, double least_s) const;
    void Take(double t_s);
  };
  struct StandAngle {
    bool known = false;
    Pace pace;
    double t_s = 0.0;
    std::array<double, 4> seen_s = {};  // times that a rest finder judges by, the last first
    double angle_deg = 0.0;
    double rate_deg_s = 0.0;
    double wrapped_deg = 0.0;  // whole turns between what is read and an angle that runs on
    double lowest_read_deg = kMissing, highest_read_deg = kMissing;
    std::optional<double> suspect_deg;  // the reading before was left out
    double suspect_s = 0.0;
    // Time of the last reading before `time_s`, or of the earliest that is remembered.
    double LastBefore(double time_s) const;
    void Take(double now_s, double now_deg);
  };
  static constexpr std::size_t kRecent = 256;
  struct Recent {
    double t_s = 0.0;
    Vector3 rotation_deg = {};
  };

  double Ahead(std::size_t axis) const;
  bool WithinGate(double step_deg, double since_s, std::optional<double> from_suspect_deg,
                  double last_s);
  double Unwrapped(StandAngle* angle, const AngleSample& sample);
  bool Accepts(StandAngle* angle, const AngleSample& sample);
  bool Accepts(const std::array<double, 4>& q, double t_s);
  void Lose(double since_s);
  bool BeginUpdate(double t_s, Pace* pace);
  void Turn(const Vector3& increment_deg);
  void TurnStand(double t_s, std::size_t axis, double angle_deg);
  void AddEarth(double t_s, const Matrix3& orientation);
  void UpdateRest(std::size_t axis, double t_s, double angle_deg);
  void CloseRest();
  bool AllRest() const;
  void KeepReading();
  void LeaveOutSilent();
  void HearAgain(std::size_t axis, double t_s);

  MeasurementInfo info_;
  kinematics::StandFrame stand_;
  Vector3 earth_rate_deg_s_ = {};
  bool orientation_known_ = false, started_ = false;
  bool updated_ = false, rest_began_ = false, rest_ended_ = false;
  std::optional<double> lost_since_s_, turns_since_s_;
  double first_s_ = 0.0, time_s_ = 0.0;
  std::size_t newest_axis_ = 0;
  std::optional<double> earth_time_s_;
  std::int64_t readings_ = 0;
  Vector3 rotation_deg_ = {}, earth_deg_ = {}, path_deg_ = {};
  std::array<StandAngle, 3> angle_ = {};
  std::array<double, 4> q_ = {};
  bool q_known_ = false;
  std::optional<std::array<double, 4>> suspect_q_;
  double suspect_s_ = 0.0;
  Pace q_pace_;
  double q_time_s_ = 0.0;
  std::array<RestFinder, 3> finder_ = {};
  std::array<bool, 3> watched_ = {}, silent_ = {};
  std::optional<OpenRest> open_;
  OpenRest ended_;
  std::array<Recent, kRecent> recent_ = {};
  std::size_t recent_count_ = 0;
  bool pending_ = false;  // the newest reading waits for the next: it may already belong to motion
  DefectLog defects_;
};

}  // namespace gyrobench::calibration
