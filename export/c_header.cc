// Format `c`: a header with one function, for a microcontroller. C99 and C++, no allocation, no
// library but for expf of a warm-up; float unless GYROBENCH_DOUBLE is defined.
#include <fmt/format.h>

#include "export/c_function.h"
#include "export/formats.h"
#include "export/text.h"

namespace gyrobench::exporting {
namespace {

using calibration::Calibration;

Lines AboutLines(const LinearModel& model, const HeldTerms& held) {
  const std::string& unit = model.unit;
  const Example example = WorkedExample(held.calibration);
  Lines lines = {
      "",
      "Formula, of the axes c = x, y, z:",
      "  y_c = xi_c / s0_c - b_c(T) - effects_c",
      "  w = A y",
      fmt::format(
          "xi: output of the gyro [{}]{}; s0: its nominal sensitivity [{} per deg/s]; T: its "
          "temperature [degC]; b: polynomial in T [deg/s]; A: inverse of the matrix of "
          "scale factors and misalignment; w: rate about the sensor's axes [deg/s].",
          unit, ZeroClause(held.calibration), unit),
      "Temperatures beyond the range that an axis saw count as its ends."};
  if (held.rates()) {
    lines.push_back(fmt::format(
        "The effects depend on w: y and w are worked out {} times, each from the w before.",
        kRounds));
  }
  lines.emplace_back("");
  Append(&lines, ValidityLines(model));
  std::string with = fmt::format("xi = {{{}}} {}, T = {} degC", ListOf(example.xi), unit,
                                 example.temperature_degC);
  if (held.needs.gravity) with += fmt::format(", gravity = {{{}}} g", ListOf(example.gravity_g));
  if (held.needs.temperature_rate) with += ", dT/dt = 0";
  if (held.needs.time) with += ", just switched on";
  Append(&lines, {"", "Worked example: " + with,
                  fmt::format("  gives w = {{{:.6f}, {:.6f}, {:.6f}}} deg/s", example.rate_deg_s[0],
                              example.rate_deg_s[1], example.rate_deg_s[2])});
  return lines;
}

std::string Macros(const HeldTerms& held) {
  std::string text =
      "#ifndef GYROBENCH_REAL\n"
      "#ifdef GYROBENCH_DOUBLE\n"
      "#define GYROBENCH_REAL double\n"
      "#define GYROBENCH_C(number) number\n"
      "#else\n"
      "#define GYROBENCH_REAL float\n"
      "#define GYROBENCH_C(number) number##f\n"
      "#endif\n"
      "#define GYROBENCH_SIZE(x) ((x) < 0 ? -(x) : (x))\n"
      "/* x within low .. high; what is not a number stays so. */\n"
      "#define GYROBENCH_HELD(x, low, high) ((x) < (low) ? (low) : (x) > (high) ? (high) : (x))\n"
      "#endif\n\n";
  if (!held.needs.time) return text;
  return text +
         "#ifndef GYROBENCH_EXP\n"
         "#include <math.h>\n"
         "#ifdef GYROBENCH_DOUBLE\n"
         "#define GYROBENCH_EXP(x) exp(x)\n"
         "#else\n"
         "#define GYROBENCH_EXP(x) expf(x)\n"
         "#endif\n"
         "#endif\n\n";
}

std::string Types(const LinearModel& model, const HeldTerms& held, const std::string& name) {
  std::string text = fmt::format(
      "typedef struct {{\n"
      "  GYROBENCH_REAL xi[3];            /* output of the gyro, x y z [{}]; 0 for an axis that is "
      "not there */\n"
      "  GYROBENCH_REAL temperature_degC; /* of the gyro */\n",
      model.unit);
  if (held.needs.gravity) {
    text +=
        "  /* Specific force at rest, +1 on the axis that points up: the accelerometer's means "
        "over\n"
        "     0.1 s, made to length 1; the last ones while that is not between 0.5 and 1.5 g. */\n"
        "  GYROBENCH_REAL gravity_g[3];\n";
  }
  if (held.needs.temperature_rate) {
    text +=
        "  /* Slope of a line through the temperatures within 5 s on either side. */\n"
        "  GYROBENCH_REAL temperature_rate_degC_s;\n";
  }
  if (held.needs.time) text += "  GYROBENCH_REAL since_power_on_s;\n";
  return text +
         fmt::format(
             "}} {0}_input;\n\n"
             "enum {{\n"
             "  {0}_BEYOND_TEMPERATURE = 1, /* or not a number */\n"
             "  {0}_BEYOND_RATE = 2,        /* or not a number */\n"
             "  {0}_NO_SOLUTION = 4         /* the effects are not small beside the rate */\n"
             "}};\n\n",
             name);
}

std::string Upper(std::string text) {
  for (char& letter : text)
    letter = letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
  return text;
}

}  // namespace

Exported WriteCHeader(const Calibration& calibration, const Origin& origin) {
  const LinearModel model = MakeLinearModel(calibration);
  const HeldTerms held = HoldTerms(calibration);
  const std::string name = Identifier(origin.target);
  Exported out;
  out.warnings = SetToZero(calibration);
  out.notes = WhatNoCorrectionHolds(calibration, model);
  Append(&out.notes, held.notes);
  Lines about = OriginLines(calibration, origin);
  about[0] = "Correction of a gyro. " + about[0];
  Append(&about, AboutLines(model, held));
  Append(&about, NoteLines(out.notes));
  const std::string guard = "GYROBENCH_" + Upper(name) + "_H";
  out.text = fmt::format("/*\n{} */\n#ifndef {}\n#define {}\n\n{}\n#endif\n",
                         Commented(about, " * "), guard, guard,
                         Macros(held) + Types(model, held, name) + FunctionText(model, held, name));
  return out;
}

}  // namespace gyrobench::exporting
