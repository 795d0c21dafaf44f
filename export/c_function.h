// The function of the C header, and the effects of a calibration that it can hold.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "export/c_term.h"
#include "export/linear_model.h"
#include "export/text.h"

namespace gyrobench::exporting {

// By channel.
struct HeldTerms {
  std::array<std::map<Dependence, std::vector<std::string>>, 3> texts;
  CNeeds needs;
  calibration::Calibration calibration;  // with these effects only
  Lines notes;                           // the other ones of the gyro, and why

  bool Any(Dependence dependence) const;
  bool rates() const { return Any(Dependence::kStraightInRate) || Any(Dependence::kBentInRate); }
};

// Throws DataError for a number that a float cannot hold.
HeldTerms HoldTerms(const calibration::Calibration& calibration);

// Each round takes the error of the rates down by the effects' slope, which is 0.1 at the very
// most.
inline constexpr int kRounds = 12;

// NAME_correct with the comment above it. It takes a NAME_input and returns flags of NAME_.
std::string FunctionText(const LinearModel& model, const HeldTerms& held, const std::string& name);

}  // namespace gyrobench::exporting
