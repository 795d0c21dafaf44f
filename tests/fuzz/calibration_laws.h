// What must hold of any bytes that are given as a calibration.
#pragma once

#include <filesystem>
#include <string>

namespace gyrobench::testing {

// A calibration with a term of every form, as it is written.
std::string SampleCalibration();

// Reads a calibration file and applies it to samples; true when it is accepted. What is read is
// written and read again as the same; corrected rates are finite or missing; each
// export is refused or holds numbers only. Throws BrokenLaw.
bool DigestCalibration(const std::filesystem::path& file);

}  // namespace gyrobench::testing
