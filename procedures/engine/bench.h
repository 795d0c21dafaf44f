// The bench as a procedure sees it. Two implementations: DryBench (here, checks and adds up time
// without moving anything) and the daemon's, which moves.
#pragma once

#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kinematics/stand_frame.h"

namespace gyrobench::procedures {

// What a procedure may know of an axis.
struct AxisFacts {
  std::string name;  // outer, middle, inner
  double gear_ratio = 40.0;
  double angle_deg = 0.0;  // table angle now
  double min_deg = 0.0;
  double max_deg = 0.0;
  double max_rate_deg_s = 0.0;
  double max_acceleration_deg_s2 = 0.0;
};

// Table turn by a bounded relative move. Positive angle: right-handed about the axis.
struct TurnCommand {
  std::string axis;
  double angle_deg = 0.0;
  double rate_deg_s = 0.0;
  double acceleration_deg_s2 = 0.0;
};

struct TurnOutcome {
  double moved_deg = 0.0;   // by the reference sensor
  double rate_deg_s = 0.0;  // that the drive used
  double duration_s = 0.0;
};

// Whole periods of a swing to both sides of where the table stands, nearly a sine: bounded moves
// with a rate that rises, stays and falls for a third of the half period each.
struct SwingCommand {
  std::string axis;
  double amplitude_deg = 0.0;
  double frequency_hz = 0.0;
  int periods = 1;
};

struct SwingOutcome {
  double frequency_hz = 0.0;  // that was reached, with what a drive needs between two moves
  double duration_s = 0.0;
};

// Rest until the sensor's temperature settles: its change over `window_s` is below `drift_degC`.
struct SoakCommand {
  double window_s = 120.0;
  double drift_degC = 0.1;
  double min_s = 0.0;
  double max_s = 3600.0;
};

struct SoakOutcome {
  bool settled = false;
  double duration_s = 0.0;
  double temperature_degC = 0.0;
};

struct Question {
  std::string id;                    // what a configuration answers by
  std::string text;                  // what the operator reads
  std::vector<std::string> choices;  // empty: any text
  double timeout_s = 3600.0;
};

// An estimate so far. `std_error` is NaN where there is none yet.
struct Estimate {
  bool available = false;
  double value = 0.0;
  double std_error = 0.0;
  std::string unit;
};

// A number of an effect that was traced. `std_error` is NaN where it is not known.
struct TracedParameter {
  std::string name;
  double value = 0.0;
  double std_error = 0.0;
  std::string unit;
};

struct TracedEffect {
  std::string id;     // angle.latency ...
  std::string owner;  // gyro, reference, bench
  std::vector<TracedParameter> parameters;
  std::vector<std::string> rivals;  // ids that the data so far cannot tell from it
  std::string settled_by;           // the manoeuvre that would; empty when certain
  bool may_be_a_step = false;       // it, or a rival, happens at one time
};

// What the residual of one gyro axis is traced to.
struct AxisVerdict {
  std::string axis;     // x, y, z of the sensor
  std::string verdict;  // none, explained, partly_explained, unexplained
  std::string summary;
  std::vector<TracedEffect> effects;
};

// Angles of the table.
struct PlannedMove {
  std::string axis;
  double begin_s = 0.0;
  double duration_s = 0.0;
  double from_deg = 0.0;
  double to_deg = 0.0;
  double rate_deg_s = 0.0;
  double acceleration_deg_s2 = 0.0;
};

// A manoeuvre that was tried without moving.
struct Rehearsal {
  std::string name;
  double duration_s = 0.0;
  bool affordable = true;  // there is time for it; others are weighed and not chosen
  double at_most_s = std::numeric_limits<double>::infinity();  // the time that there is
  double warms_degC = 0.0;         // what somebody's hand does to the sensor's temperature by it
  std::vector<AxisFacts> axes;     // where it begins
  std::vector<PlannedMove> moves;  // times since its begin
};

// Which of some manoeuvres tells the most, and what is open.
struct Choice {
  bool settled = false;           // effects are named, and nothing else explains the same
  std::string open;               // what is not settled, in words
  std::string never = {};         // what no manoeuvre tells apart within reason: not counted
  std::string newly_closed = {};  // what of it was open until now
  // Effects that are small beside others, as axis and id, and what is open of them, in words: that
  // does not count either.
  std::set<std::pair<std::string, std::string>> small = {};
  std::string small_pairs = {};
  std::optional<std::size_t> best;  // none: no manoeuvre tells anything more
  std::string because;              // "tells angle.latency from bandwidth.first_order"
  double nats = 0.0;                // expected, of the logarithm of odds
};

// What of a stand is not as its file says, and the lines of it that this makes wrong.
struct WiringFinding {
  std::string what;
  std::string reason;
  std::vector<std::string> lines;  // "axis.inner.encoder.sign = -1 (was 1)"
};
struct WiringReport {
  bool measured = false;  // else nothing has moved
  std::vector<WiringFinding> findings;
  std::vector<std::string> notes;  // what is as it should be
  std::string file;                // that a corrected stand file is written to
};

// Each table turns by up to this, either way, to find it out.
inline constexpr double kWiringRoom_deg = 12.0;

// A measurement against its declared limits. A part that misses them is data, not an error.
struct LimitCheck {
  std::string name;
  double value = 0.0;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::string unit;
  bool passed = false;  // min <= value <= max; never with NaN
};

// "offset = 0.31 deg/s: PASS (-1 .. 1 deg/s)"
std::string Describe(const LimitCheck& check);

// "inner ±5 deg at 0.4 Hz"
std::string Describe(const SwingCommand& command);

// Everything a procedure can do. Each of Turn, Swing, Rest and Soak is one segment of the run. All
// may throw LimitError (before motion), DeviceError and Aborted.
class Bench {
 public:
  virtual ~Bench() = default;
  // Seconds since the run began.
  virtual double ElapsedS() const = 0;
  virtual std::vector<AxisFacts> Axes() const = 0;
  // How the sensor is mounted and the axes lean.
  virtual StandGeometry Geometry() const = 0;
  virtual double TemperatureDegC() const = 0;
  // What the stand switches by itself: fan, heater. Others are the operator's.
  virtual std::vector<std::string> Outputs() const = 0;
  // Throws LimitError for an output that it has not. All are off after a run.
  virtual void SwitchOutput(const std::string& output, bool on) = 0;
  virtual TurnOutcome Turn(const TurnCommand& command) = 0;
  virtual SwingOutcome Swing(const SwingCommand& command) = 0;
  virtual void Rest(double duration_s) = 0;
  virtual SoakOutcome Soak(const SoakCommand& command) = 0;
  virtual std::string Ask(const Question& question) = 0;
  // `what`: "scale_factor" or "bias".
  virtual Estimate ReadEstimate(const std::string& what) = 0;
  // Traces what has been measured so far. Empty while there is nothing that could be traced.
  virtual std::vector<AxisVerdict> Trace() = 0;
  // The manoeuvre that tells the most per minute of what has been measured and traced so far.
  // `small_below`: share of the angle error that is left, below which an effect's own is small.
  virtual Choice Choose(const std::vector<Rehearsal>& menu, double small_below) = 0;
  // Turns each drive a little and finds out how the stand is wired. Throws LimitError where the
  // procedure does not say that it commissions a stand.
  virtual WiringReport FindWiring();
  // With the lines of the last report corrected, each with its reason, beside the stand file.
  // Returns its path.
  virtual std::string WriteStandFile();
  // The engine has judged the check; here it is shown and recorded.
  virtual void RecordLimit(const LimitCheck& check) = 0;
  virtual void Say(const std::string& text) = 0;
  // 0..1, shown to the operator. Without it the engine shows time against the dry run's.
  virtual void Progress(double fraction) = 0;
  // Called between commands: waits here while the run is paused, throws Aborted when it is to end.
  virtual void SafePoint() = 0;
};

// Fan and heater are switched by the stand where it can, by the operator where it cannot: what the
// operator is asked where the stand has not the output; `id` is "fan_on", "heater_off" ...
Question SwitchQuestion(const std::string& output, bool on);

// All that may be switched.
const std::vector<std::string>& KnownOutputs();

}  // namespace gyrobench::procedures
