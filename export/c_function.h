// The function of the C header.
#pragma once

#include <string>

#include "export/held_terms.h"
#include "export/linear_model.h"

namespace gyrobench::exporting {

// Each round takes the error of the rates down by the effects' slope, which is 0.1 at the very
// most.
inline constexpr int kRounds = 12;

// NAME_correct with the comment above it. It takes a NAME_input and returns flags of NAME_.
std::string FunctionText(const LinearModel& model, const HeldTerms& held, const std::string& name);

}  // namespace gyrobench::exporting
