// Words and figures that the report and the terminal share.
#pragma once

#include <string>

#include "calibration/trace/trace_result.h"

namespace gyrobench::report {

// Why an effect was not to be seen, apart from its figures, so that effects with the same reason
// stand together: "its bound here, 0.03 deg/s/g, is beyond what parts show, 0.02" is "its bound
// here is beyond what parts show" with "0.03 deg/s/g, 0.02". Figures are what begins with a digit
// between commas.
struct Reason {
  std::string kind, figures;
};
Reason SplitReason(const std::string& because);

// Largest rate that the curve of the rate error reaches [deg/s]; NaN without such a curve.
double LargestRate_deg_s(const calibration::ChannelTrace& channel);

// What a nonlinearity of the scale, in 1/(deg/s) or a power of it, makes of the scale at a rate:
// "-0.052 % at 40 deg/s", in ppm below 0.01 %. Empty for other units and without a rate.
std::string ScaleAtRate(double value, const std::string& unit, double rate_deg_s);

}  // namespace gyrobench::report
