// Valid inputs of all readers, small: what mutations start from.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gyrobench::testing {

struct NamedBytes {
  std::string name;
  std::string bytes;
};

// Tables with every kind of reference and column: rests, a turn between them.
std::vector<NamedBytes> SampleTables();

// A record's files.
struct SampleRecord {
  std::string log;
  std::string run_json;
};
// Built in `scratch`.
SampleRecord MakeSampleRecord(const std::filesystem::path& scratch);

}  // namespace gyrobench::testing
