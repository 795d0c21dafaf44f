// What must hold of any bytes that a reader is given: an error that names the file, or a
// measurement whose numbers are numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>

#include "calibration/signal/collector.h"

namespace gyrobench::testing {

// What a reader did that none may do.
class BrokenLaw : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

// Replays a table or a record into a collector and looks at everything that comes out: samples in
// the order of time, none infinite; columns, rests and clock fit without a NaN where a number is
// meant. nullopt: a DataError that names `path`. Throws BrokenLaw.
std::optional<calibration::Recording> Digest(const std::filesystem::path& path);

// Exports `path` as a table into `folder`, and digests that: what the writer writes, the reader
// reads. Throws BrokenLaw.
void DigestExported(const std::filesystem::path& path, const std::filesystem::path& folder);

// Reads a stand file (a scenario); true when it is accepted. Throws BrokenLaw where the error names
// no file.
bool DigestStandFile(const std::filesystem::path& file);
bool DigestScenario(const std::filesystem::path& file);

}  // namespace gyrobench::testing
