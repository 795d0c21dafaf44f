// The door of the room: a calibration in the form that other programs take. The room is `export`;
// its namespace is `exporting`, because `export` is a word of C++.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/artefact/calibration_file.h"

namespace gyrobench::exporting {

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
  // Those of the notes that say that something is 0 because the data do not determine it.
  std::vector<std::string> warnings = {};
};

struct Format {
  const char* name;  // as the command line has it
  const char* what;  // of what is written
  // Throws DataError where nothing of the calibration can be written in this format: channels of
  // different units, a matrix without an inverse, temperatures that no axis shares, no noise for
  // Kalibr, a number that a float cannot hold for C.
  Exported (*write)(const calibration::Calibration& calibration, const Origin& origin);
};

std::span<const Format> Formats();
// nullptr where there is none of that name.
const Format* FindFormat(std::string_view name);

}  // namespace gyrobench::exporting
