// Parts of results that more than one document has.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "presentation/noise_limits.h"
#include "presentation/results.h"

namespace gyrobench::presentation {

// Of the columns of tables.
inline constexpr auto kNumber = Column::Kind::kNumber;
inline constexpr auto kCount = Column::Kind::kCount;
inline constexpr auto kNote = Column::Kind::kNote;

// A table of name, value, unit, note.
Table ValueTable();
// Nothing where there is no value ("-").
void AddValue(Table& table, const std::string& name, const std::string& value,
              const std::string& unit, const std::string& note = "");

std::string AxisName(SensorAxis axis);  // "z"
std::string GyroName(SensorAxis axis);  // "gyro z"
std::string Capitalized(std::string text);

// "0.620 → 0.150", "0.620" where there is no after; "-" where there is neither.
std::string BeforeAfter(const calibration::HeldOut& figure, std::string (*format)(double));
// By how much the figure fell, beside its interval: "73.7 % less (95 %: 71.2 to 76.3 % less)", or
// "73.7 % less" without one. Empty where one of the two is missing.
Text Reduction(const calibration::HeldOut& figure);

// Effects of one id in the order in which they were found.
using EffectGroup = std::vector<const calibration::TracedEffect*>;
std::vector<EffectGroup> GroupById(const calibration::ChannelTrace& channel);
// One line an effect: what it is of, its figures without it and with it, its chance.
Table GainTable(const std::vector<EffectGroup>& groups);
// What that table's chance is, and its mark where an effect has it. Empty where there is no effect.
Document ExplainGains(const std::vector<EffectGroup>& groups);
// " (the bench's, not the sensor's)"; empty of an effect of the gyro.
std::string Whose(const calibration::TracedEffect& effect);
// Equation, cause and origin: what all of a group share once.
Text AboutEffects(const EffectGroup& group);
// What else is said of a group: the equations that differ, parameters, what it was chosen on,
// rivals.
Document EffectBlocks(const EffectGroup& group, double largest_rate_deg_s);
// Whatever else these data might have taken for it, and what would settle it; empty where certain.
Text RivalsText(const calibration::TracedEffect& effect);
// Rows of name, value with error, unit, note. `largest_rate_deg_s` of the channel, to judge
// nonlinearities by; may be NaN.
Table ParameterTable(const std::vector<calibration::ModelParameter>& parameters,
                     double largest_rate_deg_s);
// Largest rate that the curve of the rate error reaches [deg/s]; NaN without such a curve.
double LargestRate_deg_s(const calibration::ChannelTrace& channel);
// What a nonlinearity of the scale, in 1/(deg/s) or a power of it, makes of the scale at a rate:
// "-0.052 % at 40 deg/s", in ppm below 0.01 %. Empty for other units and without a rate.
std::string ScaleAtRate(double value, const std::string& unit, double rate_deg_s);

// "angle.latency, angle.ripple (4 times); scale.cubic or scale.quadratic_odd", with owners "(4
// times, the bench's)".
Text NamesOfEffects(const calibration::ChannelTrace& channel, bool owners);
// "partly explained by angle.latency".
Text VerdictSentence(const calibration::ChannelTrace& channel);
// Error and whitened residual, held out, forecast and of all data, and what they are of where it is
// not the effects that were named. Empty where there is no figure.
Document ErrorBlocks(const calibration::ChannelTrace& channel);
// At which temperature the zero-rate offset holds; empty where it does not depend on it.
Paragraph OffsetNote(const calibration::ChannelTrace& channel);
// Whether the rest is white, and what was found in it; empty where nothing was fitted.
Document RemainingBlocks(const calibration::ChannelTrace& channel);

// Angle random walk, bias random walk and reference noise; what the data could not have shown is
// "not seen", with what hides it. None where nothing is known.
struct NoiseLine {
  std::string name, value, unit, note;
};
std::vector<NoiseLine> NoiseLines(const calibration::NoiseModel& noise, double duration_s);
Table NoiseTable(const calibration::NoiseModel& noise, double duration_s);

// What these data could not show, by reason, and what would show it.
Section UnseenSection(const calibration::TraceResult& trace);
// Texts that several axes say, each once, after the axes that say it where these are not all.
class SharedTexts {
 public:
  void Add(SensorAxis axis, const std::string& text);
  // `all`: how many might have said it.
  std::vector<Text> Texts(std::size_t all) const;

 private:
  std::vector<std::pair<std::string, std::vector<std::string>>> texts_;
};
List TraceRemarks(const calibration::TraceResult& trace);

// Residual against all that was looked at, spectrum, Allan deviation.
Section ResidualCharts(const calibration::ChannelTrace& channel);

// The three axes as one sensor, and the accelerometer. `frame`: which one the matrix leads to.
Section VectorSection(const calibration::VectorCalibration& vector, const std::string& frame);

// Kind, count, first place, file of each defect; `files` and their defects.
using DefectsOfFile = std::pair<std::string, const std::vector<Defect>*>;
Section DefectSection(const std::vector<DefectsOfFile>& files);

}  // namespace gyrobench::presentation
