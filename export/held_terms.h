// The effects of a calibration that a function of C can hold.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "export/c_term.h"
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

}  // namespace gyrobench::exporting
