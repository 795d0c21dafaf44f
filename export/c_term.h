// An effect as an expression of C.
#pragma once

#include <optional>
#include <string>

#include "calibration/effects/channel_model.h"

namespace gyrobench::exporting {

// On what an effect depends, as the correction solves for the rates.
enum class Dependence { kNoRate, kStraightInRate, kBentInRate };

// Besides rates and temperature: what the function's input must hold.
struct CNeeds {
  bool gravity = false, temperature_rate = false, time = false;
};

struct CTerm {
  Dependence dependence = Dependence::kNoRate;
  // In deg/s. Of the variables w[3] (rates; h[3], held within the calibration's, where the effect
  // is bent), t[3] (the axes' temperatures, held), g[3], in->temperature_rate_degC_s and
  // in->since_power_on_s.
  std::string text;
  CNeeds needs;
};

// A number as both float and double take it: GYROBENCH_C(0.5). Below 1e-37 it is 0. Throws
// DataError for what a float cannot hold.
std::string CNumber(double value);
// The same without the macro.
std::string CLiteral(double value);

// An applied effect of channel `axis`. Without one, `why_not` says why the function cannot hold it:
// it remembers, or it depends on what is no input.
std::optional<CTerm> MakeCTerm(const calibration::ModelTerm& term, SensorAxis axis,
                               std::string* why_not);

}  // namespace gyrobench::exporting
