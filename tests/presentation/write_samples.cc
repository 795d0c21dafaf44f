// report_samples FOLDER: writes a report of each sample, to be looked at and checked as a page.
#include <cstdio>
#include <filesystem>

#include "tests/presentation/sample_content.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: report_samples FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const auto& [name, content] : gyrobench::presentation::AllSamples()) {
    gyrobench::presentation::WriteReport(content, folder / (name + ".html"));
  }
  return 0;
}
