// What a name of a measurement stands for on disk, the one place that tells records from tables;
// and what a result was made from, to the bit.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gyrobench::recording {

struct MeasurementFiles {
  bool is_record = false;  // else a measurement table
  // The record's folder; of a table, the one that it lies in ("." of a bare name).
  std::filesystem::path folder;
  // What is read of it, all there: a record's event log and run.json, or the table. A result is
  // known by the bytes of these. A record's log comes first; none where it is missing.
  std::vector<std::filesystem::path> files;
};

// A record is a folder, its run.json, result.json or event log, or a file that begins as an event
// log does; everything else is a table. Throws DataError when there is no such file or folder.
MeasurementFiles FilesOfMeasurement(const std::filesystem::path& path);

// Whether a folder holds an event log or a run.json.
bool IsRecordFolder(const std::filesystem::path& folder);

// SHA-256 of a file's bytes, 64 hexadecimal digits, read as a stream. Throws DataError.
std::string Sha256OfFile(const std::filesystem::path& file);

}  // namespace gyrobench::recording
