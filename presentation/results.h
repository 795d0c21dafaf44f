// The documents of results: every fact of a result is put into words here, once.
#pragma once

#include <string>
#include <vector>

#include "calibration/estimators/results.h"
#include "calibration/hold/calibrate_hold.h"
#include "calibration/trace/trace_result.h"
#include "presentation/document.h"

namespace gyrobench::presentation {

// A line for each axis with its verdict first; then axis by axis effects, baseline, figures, noise
// and what remains; then the three axes together; then what the data could not show, the inputs and
// the remarks, each said once for all axes. Without curves.
Document TraceDocument(const calibration::TraceResult& trace);
// One sentence for each axis: "gyro z: explained by angle.latency, bias.g_linear". Empty when there
// is no channel. `not_known`: sentences on what a stored trace has and this version cannot read.
Document TraceSummary(const calibration::TraceResult& trace,
                      const std::vector<std::string>& not_known = {});
// What the report says of a trace, with its curves, in two parts: what was found, and the noise.
Document TracePage(const calibration::TraceResult& trace);
Document NoisePage(const calibration::TraceResult& trace);

// Scale and bias with units and standard errors, a curve of the bias against temperature where it
// was what was measured, defects and remarks.
Document AnalysisDocument(const calibration::AnalysisResult& result);
// The baseline as the paper has it, next to the joint estimate: a part of the report.
Document AnalysisPage(const calibration::AnalysisResult& result);
// "alpha z 0.0076336 ± 0.0000021 deg/s per LSB" of one result, for a line of a list; empty when
// there is none.
std::string AnalysisSummary(const calibration::AnalysisResult& result);
// `result` with remarks on the scale factors and biases that effects of the same run's trace touch:
// these numbers are averages over what the effects did in it.
calibration::AnalysisResult WithTraceRemarks(calibration::AnalysisResult result,
                                             const calibration::TraceResult& trace);

// A calibration by held poses, or why there is none.
Document HoldDocument(const calibration::HoldResult& result);

// "partly explained" of "partly_explained".
std::string VerdictWords(const std::string& verdict);

}  // namespace gyrobench::presentation
