// The files that a command reads, and those that it will write, looked at before it works for
// minutes.
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

// Throws Error, with what to do, where `file` could not be written in the end: its folder is not
// there or may not be written, it is a folder or a device, or it is one of `inputs` (files that are
// read). `what`: "calibration", "report" ...
void CheckTarget(const std::string& what, const std::filesystem::path& file,
                 const std::vector<std::filesystem::path>& inputs);

// Throws Error where `file` exists and `overwrite` is not asked for.
void RefuseToReplace(const std::filesystem::path& file, bool overwrite);

// "report: a.html", and that it takes the place of another where there is one. To be asked before
// it is written.
std::string TargetLine(const std::string& what, const std::filesystem::path& file);

}  // namespace gyrobench::cli
