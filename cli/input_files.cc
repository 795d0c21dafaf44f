#include "cli/input_files.h"

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

}  // namespace gyrobench::cli
