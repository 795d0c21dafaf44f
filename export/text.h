// What the formats have in common: the head of a file, comments, numbers, and the worked example,
// computed by the corrector, not by what it is to show.
#pragma once

#include <string>
#include <vector>

#include "base/geometry.h"
#include "calibration/artefact/calibration_file.h"
#include "export/exporter.h"
#include "export/linear_model.h"

namespace gyrobench::exporting {

using Lines = std::vector<std::string>;

// Where the file comes from and of which sensor it is.
Lines OriginLines(const calibration::Calibration& calibration, const Origin& origin);
// What xi is: ", less 32768, ..." of counts of an unsigned converter, else nothing.
std::string ZeroClause(const calibration::Calibration& calibration);
// For each axis, the temperatures and rates that the calibration saw.
Lines ValidityLines(const LinearModel& model);
// Effects that a file does not hold, gathered by axis and reason.
class LeftOut {
 public:
  void Add(SensorAxis axis, const std::string& id, const std::string& because);
  // "gyro x: bias.g_linear, scale.g left out: ...", one sentence for each axis and reason.
  Lines Notes() const;

 private:
  struct Group {
    SensorAxis axis;
    std::string because, ids;
  };
  std::vector<Group> groups_;
};

// "Not in this file, ..." and the notes, or nothing where there is none.
Lines NoteLines(const Lines& notes);
void Append(Lines* lines, const Lines& more);

// `lines` as comments, `mark` before each ("# ", " * "), broken between words at 100 columns.
// Whatever a calibration's texts hold, no comment ends or nests by them.
std::string Commented(const Lines& lines, const std::string& mark);

// "gyro_x" of "Gyro-X.h": what identifiers may begin with.
std::string Identifier(const std::string& file_name);

// Throws DataError for what a float cannot hold, NaN among it.
void RequireFloat(double value);
// Without an exponent, for files whose readers know none; nine significant digits. Throws DataError
// for what a float cannot hold.
std::string Fixed(double value);
// To four digits; "not known" for NaN.
std::string Figure(double value);

// A sensor at one temperature that turns steadily, lying as `gravity_g` says, just switched on.
struct Example {
  Vector3 xi = {};
  double temperature_degC = 25.0;
  Vector3 gravity_g = {0.6, 0.0, 0.8};
  Vector3 rate_deg_s = {};  // corrected, frame S
};

// Within the range of the calibration. Throws DataError where that has no correction.
Example WorkedExample(const calibration::Calibration& calibration);

// "2.5, -1, 0.25": as many digits as bring the values back.
std::string ListOf(const Vector3& values);

}  // namespace gyrobench::exporting
