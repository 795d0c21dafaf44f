// The parts that a history is made of. Its rests come first.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calibration/state/state_history.h"

namespace gyrobench::calibration {

inline constexpr std::size_t kNoRest = static_cast<std::size_t>(-1);

// Axes whose angle is read as such: the stand's, or the one of the sensor.
std::array<bool, 3> AnglesRead(const MeasurementInfo& info);

// Of each node: index of the rest that it is in, or kNoRest. A rest ends where the gyro feels the
// motion, or the reference shows it, less the time for which neither would.
// A short one in which the rate changes or the readings go on, or of half a second, is none: a
// noisy reference shows reversals and the ends of motions so.
std::vector<std::size_t> RestsOfNodes(const Recording& recording);
struct NodeRange {
  std::size_t begin = 0, end = 0;
};
struct ReferenceStep {
  std::size_t at = 0;   // first node after it
  double sigmas = 0.0;  // of the two means' difference
};
// The axis was read since the node before.
bool HasReading(const ReadingsMean& mean, std::size_t axis);
// How far the readings of an axis change between nodes of a rest that follow each other, each as
// much as single readings would [deg].
std::vector<double> ChangesAtRest(const std::vector<Node>& nodes, const NodeRange& rest,
                                  std::size_t axis);
// Standard deviation of one reading of an axis [deg], from its changes between nodes that follow
// each other, in all stretches in which it stands still. NaN where there are too few to tell.
double ScatterAtRest(const std::vector<Node>& nodes, const std::vector<NodeRange>& rests,
                     std::size_t axis);
// What an axis shows without a step [deg]: rounding to its counts, and the scatter of one reading.
struct StepLimits {
  double count_deg = kMissing, scatter_deg = kMissing;
};
// The clear step of an axis that stands still, if there is one: over 7 standard deviations, and
// more than rounding makes. Three nodes and three readings of the axis on either side are needed,
// and a scatter that is known.
std::optional<ReferenceStep> LargestStep(const std::vector<Node>& nodes, const NodeRange& rest,
                                         std::size_t axis, const StepLimits& limits);
// The rests in their order.
std::vector<NodeRange> RangesOfRests(const std::vector<std::size_t>& rest_of);
// Makes two of a rest in which the reference steps: those after the step get indices beyond those
// of the recording's rests.
void SplitRestsAtSteps(const Recording& recording, std::vector<std::size_t>* rest_of);

// What may be used of it, channel by channel: no bad stretches, and rests alone where there is no
// reference; none in which the reference says rest and the gyro says turning. Needs `still`.
void MarkUnusable(const Recording& recording, const Vector3& units_per_deg_s,
                  StateHistory* history);

// Angles of the table's axes at the nodes. An axis that stands still while another turns would
// bring the noise of its readings into the rotation: along such stretches its angle is their mean.
struct SettledAngles {
  std::vector<Vector3> angle_deg;
  std::vector<std::array<bool, 3>> is_settled;
  // All axes are settled, and this one is not, or has another angle, just before or after: it may
  // creep there already.
  std::vector<std::array<bool, 3>> may_creep;
};
// `error_deg`: of each axis's angle at one node while it rests and others turn.
SettledAngles SettleAxes(const Recording& recording, const std::vector<Node>& epochs,
                         const Vector3& error_deg);

// The rests of a recording: index of each node's, or kNoRest, and how often each rest was read, and
// where it is.
struct RestReadings {
  const std::vector<std::size_t>& rest_of;
  const std::vector<double>& readings;
  const std::vector<Vector3>& angle_deg;
};

// How the error of several readings' mean compares with one reading's, as variances. Noise
// averages; the rounding to the steps of a coarse encoder does not, where neither noise nor motion
// carries the readings over several steps.
class ReadingErrors {
 public:
  // `rest_of`: index of each node's rest, or kNoRest.
  ReadingErrors(const Recording& recording, const std::vector<Node>& nodes,
                const std::vector<std::size_t>& rest_of);
  const std::array<RestFlicker, 3>& flicker() const { return flicker_; }
  // Standard deviation of the mean of so many while the table moves [deg].
  double ErrorInMotion_deg(double readings) const;
  // The same, or what rounding errs by at most.
  double MostInMotion_deg(double readings) const;
  // What rounding errs by at most, of the axes of which noise leaves more than that part.
  double LargestRounding_deg(double least_left = 0.0) const;
  // Of each node and axis: the readings since the node before, or in the rest that it is in. Where
  // an axis was not read since then, of the last one before. On a coarse encoder nodes within half a
  // count misread alike, and so do all rests on one count: each of so many is worth as much less.
  std::vector<Vector3> Shares(const std::vector<Node>& epochs, const RestReadings& rests) const;

 private:
  std::vector<double> Alike(const std::vector<Node>& epochs, const RestReadings& rests,
                            std::size_t axis) const;
  double ShareInMotion(const std::vector<Node>& epochs, std::size_t k, std::size_t axis,
                       double alike) const;
  Vector3 step_deg_ = {};
  double RoundingOf_deg(std::size_t axis) const;
  double scatter_deg_ = 0.0;
  std::array<RestFlicker, 3> flicker_;
  // LeftOfRounding of each axis, or 0 without a rest, where the errors are not known.
  Vector3 rounded_ = {};
};

// Gravity and heading in the sensor's frame: by the reference where it gives an orientation, by the
// accelerometer where one axis turns or none. `rest_of`: index of each node's rest, or kNoRest.
void FillGravity(const Recording& recording, const std::vector<std::size_t>& rest_of,
                 StateHistory* history);
// Rates of midpoints and nodes: size by the reference, shape between its readings by the gyro; both
// by the gyro where the noise of two readings is far larger than its own.
// `units_per_deg_s`: of each channel, NaN where it is not known. `settled_deg`: rotation over each
// interval, without the noise of axes that rest.
void FillRates(const Recording& recording, const Vector3& units_per_deg_s,
               const std::vector<Vector3>& settled_deg, StateHistory* history);
// Rates below the first are no motion; less than so many standard deviations of what two readings
// say is their noise.
inline constexpr double kLeastMotion_deg_s = 0.3, kNoiseSigmas = 4.0;
// The mean of a node's readings, whose output is known, is one of a motion: also of a slow turn
// that passed for rest.
bool IsOfMotion(const ReadingsMean& mean, const Columns& columns);
// Fills StateHistory::slow_rate_deg_s.
void MarkSlowTurns(const SettledAngles& settled, StateHistory* history);
// The reference says that an axis of the table turned up to a node; not beyond the last.
bool TurnsUpTo(const StateHistory& history, std::size_t node, std::size_t axis);
// What the readings' errors can make of the rate over an interval [deg/s]; 0 beyond the last.
double RateNoise(const StateHistory& history, std::size_t interval);
// Of each node: the mean rate of each channel [deg/s] over the last seconds of the rest it is in,
// or of the last one before (`backward`: over the first seconds, or of the next one after); where
// there is none, of the one on the other side. Where the channel never rests, as no rest is seen by
// a reference whose noise is large, what it shows beside its turns, by least squares over all. Over
// a long rest the zero-rate offset follows the temperature.
std::vector<Vector3> RatesAtRest(const std::vector<Node>& nodes, const Vector3& units_per_deg_s,
                                 const std::vector<Vector3>& settled_deg,
                                 const StateHistory& history, bool backward);
// What is needed to take a channel's output for a turn: its scale, at each node its rate at rest
// and that of the next rest (NaN where it never rests), and the largest angle random walk of the
// channels.
struct FeltByGyro {
  const Vector3& units_per_deg_s;
  const std::vector<Vector3>&at_rest_deg_s, &next_rest_deg_s;
  double walk_deg_sqrt_s = 0.0;
};
// The turns of the table's axes as the gyro felt them.
void FillTableWays(const Recording& recording, const FeltByGyro& gyro, StateHistory* history);
// Needs the ways. What lies between the readings of a node is the same whatever wave is looked for
// in it, so that it is worked out once.
void FillReadingAngles(StateHistory* history);
// With them the angles at the nodes without the noise of their own reading, what that adds, and how
// far the times of the readings are off. `walk_deg_sqrt_s`: each channel's angle random walk.
void SmoothAngles(const Vector3& walk_deg_sqrt_s, StateHistory* history);
// Smoothed. What is missing is bridged where the gap is short (slow_quantity.h); longer stretches
// are left out, counted as a defect. Unknown where it is known for less than half of the time.
void FillTemperature(const Recording& recording, StateHistory* history);
// Vibration, and the columns `covariates` in this order, missing values as of the temperature.
void FillCovariates(const Recording& recording, const std::vector<std::string>& covariates,
                    StateHistory* history);

// At the nodes, as measured. The column must be there.
std::vector<double> NodeTimes(const Recording& recording);
std::vector<double> TemperatureOf(const Recording& recording);
std::vector<double> CovariateOf(const Recording& recording, const std::string& name);
// A quantity that is known for a smaller share of the time counts as unknown.
inline constexpr double kLeastKnownShare = 0.5;

}  // namespace gyrobench::calibration
