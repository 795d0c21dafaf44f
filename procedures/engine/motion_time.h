// How long a move takes, and whether it may be made at all.
#pragma once

#include "procedures/engine/bench.h"

namespace gyrobench::procedures {

// Duration [s] of a move of `angle_deg` from rest to rest with a trapezoidal profile of rate:
//   |angle| >= rate^2 / acceleration:  |angle| / rate + rate / acceleration
//   else (the rate is not reached):    2 sqrt(|angle| / acceleration)
// rate_deg_s and acceleration_deg_s2 > 0.
double MoveDuration_s(double angle_deg, double rate_deg_s, double acceleration_deg_s2);

// How far beyond a soft limit a live table may seem to end: stops scatter and the reference is
// noisy, and a plan that ends on the limit is not to be refused half way.
inline constexpr double kLiveSlack_deg = 0.1;

// Checks a move that starts at axis.angle_deg: finite values, rate and acceleration above zero and
// within the axis's, end within the soft limits (with them the whole move, which is monotonic).
// From beyond a limit only the way back inside is allowed. Throws LimitError that names axis, value
// and limit.
void CheckTurn(const TurnCommand& command, const AxisFacts& axis,
               double slack_deg = kLiveSlack_deg);

// The moves of a swing, one after the other: to one side, over to the other and back for every half
// period, and home. With T = 1 / frequency:
//   rate = 6 amplitude / T,  acceleration = 36 amplitude / T^2   (a sine: 6.28 and 39.5)
// Throws LimitError where a field is not above 0 or the swing has more than 10000 periods; each
// move is still to be checked.
std::vector<TurnCommand> MovesOf(const SwingCommand& command);

// The largest amplitude [deg] of a swing about axis.angle_deg that the axis's limits leave, 0 where
// they leave none. Throws LimitError for a frequency that is not above 0.
double SwingRoom_deg(const AxisFacts& axis, double frequency_hz);

// Throw LimitError where a duration is not finite, negative or beyond a day, or a soak's fields
// contradict one another.
void CheckRest(double duration_s);
void CheckSoak(const SoakCommand& command);

// The axis of that name. Throws LimitError that names those there are.
const AxisFacts& FindAxis(const std::vector<AxisFacts>& axes, const std::string& name);

}  // namespace gyrobench::procedures
