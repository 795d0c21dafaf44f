// The parts of the page, in its order. Each gives markup, empty where it has nothing to say.
#pragma once

#include <string>
#include <vector>

#include "report/charter.h"
#include "report/markup.h"
#include "report/report.h"

namespace gyrobench::report {

// In words, first of all, with the error before and after.
Markup VerdictSection(const calibration::TraceResult& trace);
// Residual against all that was looked at, spectrum, Allan deviation.
Markup ChartSection(const calibration::ChannelTrace& channel, Charter& charter);
Markup ParameterSection(const calibration::TraceResult& trace);
// The three axes as one sensor, and the accelerometer. Empty where there is nothing of either.
Markup VectorSection(const calibration::VectorCalibration& vector);
// Each effect with its cause, and whose it is.
Markup EffectSection(const calibration::TraceResult& trace);
// What the procedure said while it ran; empty where it said nothing.
Markup CourseSection(const Provenance& provenance);
// Empty where no effect was named.
Markup RivalSection(const calibration::TraceResult& trace);
// By reason, each said once; axes of which the same holds share a line.
Markup UnidentifiableSection(const calibration::TraceResult& trace);
Markup RemainingSection(const calibration::TraceResult& trace);
Markup NoiseSection(const calibration::TraceResult& trace);
// The baseline as the paper has it, next to the joint estimate.
Markup AnalysisSection(const calibration::AnalysisResult& analysis);
Markup DefectSection(const ReportContent& content);
Markup ProvenanceSection(const ReportContent& content);

// Shared by the parts.
std::string AxisName(SensorAxis axis);  // "x"
// Effects of one id in the order in which they were found.
using EffectGroup = std::vector<const calibration::TracedEffect*>;
std::vector<EffectGroup> GroupById(const calibration::ChannelTrace& channel);
Markup Section(const std::string& title, const Markup& inside,
               const std::string& css_class = "short");
// A line of a list <dl>; none where there is no text.
void AddFact(Markup& facts, const std::string& name, const Markup& text);
// "0.620 → 0.150 deg", "0.620 deg" where there is no after.
std::string BeforeAfter(const calibration::HeldOut& figure, const std::string& unit, bool ratio);
// "75.8 % less, 95 % interval 71.2 % to 79.3 %".
std::string Reduction(const calibration::HeldOut& figure);

}  // namespace gyrobench::report
