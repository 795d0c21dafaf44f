#include "presentation/noise_limits.h"

#include <algorithm>
#include <cmath>

#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

constexpr double kInterval_s = 0.1;  // the tracer's columns

// A limit that is not known hides nothing but a zero.
NoiseFigure Judge(double value, double limit, const char* why) {
  NoiseFigure figure{value, std::isfinite(limit) ? limit : 0.0, ""};
  if (std::isfinite(value) && (value <= 0.0 || value < figure.limit)) figure.why = why;
  return figure;
}

}  // namespace

NoiseFigures JudgeNoise(const calibration::NoiseModel& noise, double duration_s) {
  NoiseFigures figures;
  const double n = noise.angle_random_walk_deg_sqrt_s;
  figures.angle_random_walk = Judge(n, noise.reference_deg * std::sqrt(kInterval_s) / duration_s,
                                    "the reference's noise hides it");
  // The walk may be as large as its limit.
  const double n_most = std::fmax(n, figures.angle_random_walk.limit);
  figures.bias_random_walk = Judge(noise.bias_random_walk_deg_s_sqrt_s, n_most / duration_s,
                                   "the angle random walk hides it");
  figures.reference = Judge(noise.reference_deg,
                            n * std::sqrt(kInterval_s) * std::pow(kInterval_s / duration_s, 0.25),
                            noise.reference_deg > 0.0 ? "the angle random walk hides it"
                                                      : "none, or the angle random walk hides it");
  return figures;
}

std::vector<NoiseLine> NoiseLines(const calibration::NoiseModel& noise, double duration_s) {
  const NoiseFigures figures = JudgeNoise(noise, duration_s);
  std::vector<NoiseLine> lines;
  const auto add = [&](const char* name, const NoiseFigure& figure, const char* unit) {
    const std::string value = FormatNumber(figure.value, 3);
    if (figure.hidden()) {
      lines.push_back({name, "not seen", "", figure.why});
    } else if (value != "-") {
      lines.push_back({name, value, unit, ""});
    }
  };
  add("angle random walk", figures.angle_random_walk, "deg/sqrt(s)");
  add("bias random walk", figures.bias_random_walk, "deg/s/sqrt(s)");
  add("reference noise", figures.reference, "deg");
  if (!lines.empty() && lines.back().name == "reference noise" && lines.back().note.empty())
    lines.back().note = "standard deviation of one reading";
  return lines;
}

Table NoiseTable(const calibration::NoiseModel& noise, double duration_s) {
  Table table = ValueTable();
  for (const NoiseLine& line : NoiseLines(noise, duration_s))
    table.Add({line.name, line.unit.empty() ? Text(line.value) : Number(line.value),
               Unit(line.unit), line.note});
  return table;
}

double LongestDuration_s(const calibration::TraceResult& trace) {
  double longest_s = kMissing;
  for (const auto& input : trace.inputs) longest_s = std::fmax(longest_s, input.duration_s);
  return longest_s;
}

}  // namespace gyrobench::presentation
