// Contents of reports as a trace would give them, made of formulas and noise, and terminals to show
// them on.
#pragma once

#include <string>
#include <vector>

#include "presentation/report.h"
#include "presentation/text_layout.h"

namespace gyrobench::presentation {

// A sensor on a single-axis table: effects of gyro and reference, a rival, defects.
ReportContent ExplainedSample();
// Three axes with different verdicts, and the analysis by the paper.
ReportContent ThreeAxesSample();
// Nothing beyond the baseline.
ReportContent SilentSample();
// An analysis without a trace.
ReportContent AnalysisSample();
// Every text tries to be markup or a command; series are empty, short, NaN or infinite.
ReportContent HostileSample();

inline const std::string kHostileText =
    "</style></title><script>alert(1)</script>' \" & ]]> `touch pwned` @x $(touch pwned) "
    "\n\x01\xff "
    "system('touch pwned')";

struct NamedSample {
  std::string name;
  ReportContent content;
};
std::vector<NamedSample> AllSamples();

inline Terminal OfColumns(int columns) {
  Terminal terminal;
  terminal.is_terminal = true;
  terminal.columns = columns;
  return terminal;
}

}  // namespace gyrobench::presentation
