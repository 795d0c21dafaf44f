// Procedures: what a script declares, where scripts are found, and whether given parameters fit.
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "procedures/engine/sandbox.h"

namespace gyrobench::procedures {

enum class ParameterType { kNumber, kInteger, kNumbers, kChoice, kText, kBoolean };
// "number", "integer", "numbers", "choice", "text", "boolean".
const char* Name(ParameterType type);

// Numbers and integers are doubles; lists of numbers ("5, 10"), choices and texts are strings.
using Value = std::variant<double, std::string, bool>;
using Parameters = std::map<std::string, Value>;
// As messages and tables show it.
std::string Show(const Value& value);

struct Parameter {
  std::string name;
  ParameterType type = ParameterType::kNumber;
  Value default_value;
  std::string unit;  // empty: none
  // Range of a number, of an integer or of each number of a list, both ends allowed; infinite where
  // the script gives none.
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices;
  std::string help;
};

// What a script says of itself in its global table `procedure`.
struct ProcedureInfo {
  std::string name;  // of the file, without .lua
  std::string summary;
  std::string description;
  std::filesystem::path file;
  std::vector<Parameter> parameters;
  std::vector<std::string> measures;  // "bias", "scale": which results the run is to give
  // Whether a run whose daemon ended may go on in the middle: each command measures the same
  // whatever went on before.
  bool resumable = false;
  // Whether it is for a stand whose file may still be wrong: it is run while devices are not well,
  // and nothing that is measured is evaluated.
  bool commissions = false;
  std::string problem;  // why it cannot be used; empty when it can
};

// No procedure of that name.
class UnknownProcedure : public Error {
 public:
  using Error::Error;
};

// A parameter that the procedure does not have, or a value that it does not take.
class ParameterError : public Error {
 public:
  using Error::Error;
};

// A script that was read and found in order.
class Procedure {
 public:
  // Throws ScriptError that names file and, where known, line; Aborted where `limits` say so.
  // `file` is for the record and for messages. `limits`: of the script's top level.
  static Procedure FromSource(const std::string& name, const std::filesystem::path& file,
                              std::string source, const SandboxLimits& limits = {});
  // As FromSource; DataError where the file cannot be read.
  static Procedure Load(const std::filesystem::path& file, const SandboxLimits& limits = {});

  const ProcedureInfo& info() const { return info_; }
  // The text as read, to be kept with the run.
  const std::string& source() const { return source_; }

 private:
  Procedure(ProcedureInfo info, std::string source);

  ProcedureInfo info_;
  std::string source_;
};

// NAME.lua of some directories; the first directory wins. Files are read anew at each call: an
// edited script needs no restart. A name consists of letters, digits, _ and -.
class ProcedureLibrary {
 public:
  // `limits`: of the top level of each script.
  explicit ProcedureLibrary(std::vector<std::filesystem::path> directories,
                            SandboxLimits limits = {});
  // In the order of names. A script that cannot be used is there, with its problem.
  std::vector<ProcedureInfo> List() const;
  // Throws UnknownProcedure, or what Procedure::Load throws.
  Procedure Find(const std::string& name) const;

 private:
  std::map<std::string, std::filesystem::path> Files() const;

  std::vector<std::filesystem::path> directories_;
  SandboxLimits limits_;
};

// Checks `given` and completes it with the defaults. A text given for a number, integer or boolean
// is read as one (command lines give text). Throws ParameterError that names parameter, value, unit
// and range.
Parameters CheckParameters(const ProcedureInfo& procedure, const Parameters& given);

// Checks one value, and reads it where it is text. Throws ParameterError as above.
Value CheckValue(const std::string& procedure, const Parameter& parameter, const Value& value);

}  // namespace gyrobench::procedures
