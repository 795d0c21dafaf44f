// What the analysis keeps of a measurement: columns at about 10 Hz, in motion each reading of the
// reference about its node's mean, the rests, and the stretches that must not be used. No sample is
// kept.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/geometry.h"
#include "base/measurement.h"

namespace gyrobench::calibration {

// The integral of the output at one time: z = int xi dt since the first sample, of a cubic spline
// through the samples [output unit * s].
struct IntegralMark {
  double t_s = 0.0;
  Vector3 z = {};
};

// How the rate may have gone between samples that are the values of single moments, summed up since
// the first sample. With J the jump of the slope at a sample, J' that at the next, tau apart:
//   corners  variance of the integral [(output unit s)^2]: (J + J')^2 tau^4 / 1200
//   steps    the same: -J J' tau^4 / 12 where it is positive
//   bends    what a rate that goes straight on either side of one corner, at the part J' / (J + J')
//            of the interval, makes the integral larger by than the spline's [output unit s]:
//              -J J' tau^2 / (2 (J + J')) + tau^2 (m' - m) / 12
//            m being the spline's slopes at the begin and the end
// Where the acceleration jumps by a, once, at a part f of an interval, the spline through the
// samples is off by a tau^2 (f (1 - f) / 2 - 1 / 12), in the mean square over f by a^2 tau^4 / 720;
// J is (1 - f) a and f a, so that the three intervals about it have 5/3 a^2 together. Where the
// rate itself jumps by v, as of a ramp shorter than an interval, it is off by up to v tau / 2, in
// the mean square by v^2 tau^2 / 12; J is v / tau and -v / tau.
struct BetweenSamples {
  Vector3 corners = {}, steps = {}, bends = {};
};

// Samples that are means from half way to half way, evenly: their sum is the integral up to there.
// AsMeans is what the cubic through these sums, less what it is off by at a corner, makes the
// integral at one time larger by than the spline's [output unit s]. At a sample, with the slope m
// of the spline and m_c of the line from the sample before to the one after, without a corner:
//   tau^2 (m / 12 - m_c / 8)
// which is -tau^2 / 24 times the acceleration where that is constant. From a sample to half way it
// goes in a straight line. Means over the interval before the samples' times are late by half of
// it: what they say of a time is AsMeans half an interval later.
using AsMeans = Vector3;

// The sum of the samples up to one time, each standing for the time half way to its neighbours
// [output unit * s]. It ends half way between two samples, so that the noise of one sum less
// another is that of whole samples: two intervals that follow each other share none.
// `t_s`: NaN where it is not known.
struct SampleSum {
  double t_s = kMissing;
  Vector3 z = {};
};

// Times about a node [s], evenly, and a vector at each of them.
inline constexpr double kNearStep_s = 0.01;
inline constexpr std::array<double, 8> kNear_s = {-0.04, -0.03, -0.02, -0.01,
                                                  0.01,  0.02,  0.03,  0.04};
using Near = std::array<Vector3, kNear_s.size()>;
// Even steps from one node to the next, and a vector at the end of each.
inline constexpr std::size_t kWaySteps = 10;
using Way = std::array<Vector3, kWaySteps>;

// What all readings of the reference since the node before say together: means over the readings,
// and over the same times of the output's integral (node_readings.h).
struct ReadingsMean {
  double readings = 0.0;  // how many; 0: none, and nothing else is known
  double t_s = 0.0;
  Vector3 rotation_deg = {}, earth_deg = {}, table_deg = {}, world_x = {}, world_z = {};
  // Of each axis of the stand alone: how often it was read, and the mean of that. Where another
  // axis is read more often, table_deg holds the last reading in between.
  Vector3 own_readings = {}, own_deg = {};
  bool output_known = false;
  bool passed_for_rest = false;  // when it came
  Vector3 z = {};                // as IntegralMark's
  AsMeans as_means = {}, as_means_later = {};
  // Half the mean distance in time of two of the readings: the random walk of the angle is averaged
  // with them, and makes the covariance of the rotation before with the one after larger by
  // walk_s N^2.
  double walk_s = 0.0;
  // As if they came evenly: so many, by so much.
  std::size_t steps = 0;
  double step_s = 0.0;
};

// What a reading of a moving node, or some that are close together, says beyond the mean of all.
struct ReadingWithin {
  float after_s = 0.0F;  // time after that of the mean
  // The output's integral [output unit s] and the rotation of the reference, less their means.
  std::array<float, 3> z = {}, rotation_deg = {};
};

// One node. Rotations are sums since the start.
struct Node {
  IntegralMark at;
  Vector3 rotation_deg = {};           // of the reference, about the sensor's axes
  Vector3 earth_deg = {};              // Earth's rotation about the sensor's axes; 0 when not known
  double temperature_degC = kMissing;  // mean since the node before
  Vector3 accel_g = {kMissing, kMissing, kMissing};  // mean since the node before
  double vibration_g2 = kMissing;  // mean square of the specific force about that mean
  ReadingsMean mean;
  // Of `mean` where the table moves: which of Columns::within.
  std::uint32_t within_begin = 0, within_count = 0;
  SampleSum samples;            // up to the node's time; counted as `at` is
  BetweenSamples between;       // up to the last sample not after the node's time
  AsMeans as_means = {};        // at the node's time
  AsMeans as_means_later = {};  // half an interval of the samples after it
  // Integral of the output at kNear_s from the node's time, less that at the node; where the mean
  // of the output is known, the mean of the same over the readings.
  Near z_near = {};
  // Integral of the output on the way from the node before to this one; the last is `at.z`.
  Way z_way = {};
  // Integral of the output since the first sample at `half_s`, half way from the node before.
  Vector3 z_half = {};
  double half_s = kMissing;
  // The reference: angles of the stand's axes (of the one axis of a single-axis table); world x and
  // z in the sensor's frame. NaN where it does not say.
  Vector3 table_deg = {kMissing, kMissing, kMissing};
  Vector3 world_x = {kMissing, kMissing, kMissing};
  Vector3 world_z = {kMissing, kMissing, kMissing};
};

// A stretch in which the reference stood still and the gyro felt nothing.
struct Rest {
  IntegralMark begin, end;
  Vector3 rotation_deg = {};  // mean over the readings at rest
  double scatter_deg = 0.0;   // largest standard deviation of one reading among the axes
  std::int64_t readings = 0;
  // First and last reading of the reference at rest; the last may already belong to motion. What
  // `begin` and `end` say is the gyro's word, which a turn about another axis can escape.
  double reference_begin_s = -std::numeric_limits<double>::infinity();
  double reference_end_s = std::numeric_limits<double>::infinity();
  // It is none: the axis turns, so slowly that it stayed within the tolerance for a while.
  bool turns = false;
  double count_deg = 0.0;  // step of a coarse encoder, or something smaller
};

// A stretch that must not be used.
struct BadStretch {
  double begin_s = 0.0;
  double end_s = 0.0;
  std::array<bool, 3> channel = {true, true, true};
};

struct TimeSpan {
  double begin_s = 0.0, end_s = 0.0;
};

struct Columns {
  std::vector<Node> nodes;
  std::vector<ReadingWithin> within;  // of all nodes
  // Covariates, node by node in the order of MeasurementInfo::covariates: means since the node
  // before.
  std::vector<double> covariates;
  std::vector<Rest> rests;
  std::vector<TimeSpan> slow_turns;  // that passed for rest at first, in order
  std::vector<BadStretch> bad;       // in order of begin_s
};

}  // namespace gyrobench::calibration
