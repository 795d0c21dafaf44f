// The effects of one channel of a trace, for a person. Effects of one id stand together: what they
// share is said once.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/text_layout.h"

namespace gyrobench::cli {

// Texts are broken at this width also where there is no terminal.
inline constexpr int kTextColumns = 100;

// `text` broken to the terminal's width, at most kTextColumns. Ends in a newline.
std::string Paragraph(const std::string& text, const Terminal& terminal, int indent);

// "0.620 → 0.150"; "-" where neither is known.
std::string BeforeAfter(const nlohmann::json& held_out);

// "p < 1e-16", "p = 0.0021", "p not known".
std::string PValue(double p);

// "angle.latency, angle.ripple (4 times), scale.cubic or scale.quadratic_odd".
std::string NamesOfEffects(const nlohmann::json& effects);

// A table with one line an effect, then each id with equation, cause, parameters, rivals and what
// would settle them. `largest_rate_deg_s`: of the channel, NaN where it is not known.
std::string EffectsText(const nlohmann::json& effects, const Terminal& terminal,
                        double largest_rate_deg_s);

// "name  value  unit  note", one line a parameter.
std::string ParametersText(const nlohmann::json& parameters, const Terminal& terminal,
                           double largest_rate_deg_s);

}  // namespace gyrobench::cli
