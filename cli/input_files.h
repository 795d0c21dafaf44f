// What a command reads, on disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/options.h"
#include "recording/measurement_files.h"

namespace gyrobench::cli {

struct InputFiles {
  std::filesystem::path path;  // of a table, or a record's folder
  recording::MeasurementFiles on_disk;
};

// A file that was read.
struct HashedFile {
  std::size_t input = 0;  // index of the inputs
  std::filesystem::path path;
  std::string sha256;
};

// What `inputs` (runs, folders, tables) stand for on disk. Throws DataError or UsageError.
std::vector<InputFiles> LocateInputs(const std::vector<std::string>& inputs,
                                     const Options& options);
std::vector<std::filesystem::path> AllFiles(const std::vector<InputFiles>& inputs);

// Of every file that was read (recording/measurement_files.h). Throws DataError.
std::vector<HashedFile> HashFiles(const std::vector<InputFiles>& inputs);

}  // namespace gyrobench::cli
