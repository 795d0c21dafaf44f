#include "cli/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include "base/error.h"
#include "cli/inputs.h"
#include "recording/measurement_files.h"

namespace gyrobench::cli {

namespace fs = std::filesystem;

std::vector<InputFiles> LocateInputs(const std::vector<std::string>& inputs,
                                     const Options& options) {
  std::vector<InputFiles> found;
  for (const std::string& input : inputs) {
    const fs::path path = LocateInput(input, options.bench);
    found.push_back({path, recording::FilesOfMeasurement(path)});
  }
  return found;
}

std::vector<fs::path> AllFiles(const std::vector<InputFiles>& inputs) {
  std::vector<fs::path> all;
  for (const InputFiles& input : inputs)
    all.insert(all.end(), input.on_disk.files.begin(), input.on_disk.files.end());
  return all;
}

std::vector<HashedFile> HashFiles(const std::vector<InputFiles>& inputs) {
  std::vector<HashedFile> files;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    for (const fs::path& file : inputs[i].on_disk.files)
      files.push_back({i, file, recording::Sha256OfFile(file)});
  }
  return files;
}

void CheckTarget(const std::string& what, const fs::path& file,
                 const std::vector<fs::path>& inputs) {
  const auto fail = [&](const std::string& why) {
    throw Error(fmt::format("{} {}: {}; nothing was done", what, file.string(), why));
  };
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) {
    fail(fmt::format("there is no folder {}; make it, or choose another", folder.string()));
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    fail(fmt::format("the folder {} may not be written by this user; choose another",
                     folder.string()));
  }
  const fs::file_status status = fs::status(file, error);
  if (fs::is_directory(status)) fail("that is a folder; expected the name of a file");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    fail("that is no plain file; expected the name of a file");
  }
  for (const fs::path& input : inputs) {
    if (fs::equivalent(file, input, error)) {
      fail("it would replace a file that is read; choose another name");
    }
  }
}

void RefuseToReplace(const fs::path& file, bool overwrite) {
  std::error_code none;
  if (overwrite || !fs::exists(file, none)) return;
  throw Error(
      fmt::format("{} exists already: choose another name, or add --overwrite", file.string()));
}

std::string TargetLine(const std::string& what, const fs::path& file) {
  std::error_code none;
  return fmt::format("{}: {}{}", what, file.string(),
                     fs::exists(file, none) ? " (replaces the file of that name)" : "");
}

}  // namespace gyrobench::cli
