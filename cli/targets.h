// The files that a command will write, looked at before it works for minutes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gyrobench::cli {

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
