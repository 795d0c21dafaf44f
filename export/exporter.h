// The door of the room: a calibration in the form that other programs take. The room is `export`;
// its namespace is `exporting`, because `export` is a word of C++.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"

namespace gyrobench::exporting {

enum class Format { kC, kPx4, kArduPilot, kKalibr, kJson };

struct FormatName {
  Format format;
  const char* name;  // as the command line has it
  const char* what;  // of what is written
};
inline constexpr std::array<FormatName, 5> kFormats = {{
    {Format::kC, "c", "C header"},
    {Format::kPx4, "px4", "PX4 parameters"},
    {Format::kArduPilot, "ardupilot", "ArduPilot parameters"},
    {Format::kKalibr, "kalibr", "Kalibr IMU file"},
    {Format::kJson, "json", "JSON"},
}};

// What the written file says of its origin.
struct Origin {
  std::string file;     // name of the calibration's file
  std::string sha256;   // of its bytes
  std::string version;  // of gyrobench
  std::string target;  // name of the file that is written: the C header's identifiers begin with it
};

struct Exported {
  std::string text;
  // What the target cannot hold, and what is left to the user to do: one sentence each. They stand
  // in the text as well.
  std::vector<std::string> notes;
};

// Throws DataError where nothing of the calibration can be written in this format: channels of
// different units, a matrix without an inverse, temperatures that no axis shares, no noise for
// Kalibr, a number that a float cannot hold for C.
Exported Export(const calibration::Calibration& calibration, Format format, const Origin& origin);

}  // namespace gyrobench::exporting
