#include "cli/noise_text.h"

#include <nlohmann/json.hpp>

#include "cli/json_field.h"
#include "cli/number_text.h"
#include "report/noise_limits.h"

namespace gyrobench::cli {
namespace {

NoiseLine Line(const std::string& name, const report::NoiseFigure& figure,
               const std::string& unit) {
  if (!figure.hidden()) return {name, FormatNumber(figure.value, 3), unit, ""};
  return {name, "not seen", "", figure.why};
}

}  // namespace

std::array<NoiseLine, 3> NoiseLines(const nlohmann::json& noise, double duration_s) {
  calibration::TraceNoise figures;
  figures.angle_random_walk_deg_sqrt_s = Number(noise, "angle_random_walk_deg_sqrt_s");
  figures.bias_random_walk_deg_s_sqrt_s = Number(noise, "bias_random_walk_deg_s_sqrt_s");
  figures.reference_deg = Number(noise, "reference_deg");
  const report::NoiseFigures judged = report::JudgeNoise(figures, duration_s);
  return {Line("angle random walk", judged.angle_random_walk, "deg/sqrt(s)"),
          Line("bias random walk", judged.bias_random_walk, "deg/s/sqrt(s)"),
          Line("reference noise", judged.reference, "deg")};
}

}  // namespace gyrobench::cli
