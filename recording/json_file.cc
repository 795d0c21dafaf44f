#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json_text.h"
#include "base/part_file.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void Fail(const fs::path& file, const char* action) {
  throw DataError(fmt::format("{}: {}: {}", file.string(), action, std::strerror(errno)));
}

}  // namespace

void WriteJsonAtomically(const fs::path& file, const nlohmann::json& value) {
  // Text that is no UTF-8 (a device's name, a script) must not stop the record: it is replaced.
  const std::string text = JsonText(value, 2) + "\n";
  PartFile part(file);
  part.Write(text);
  part.Replace(PartFile::Safety::kOnDisk);
}

nlohmann::json ReadJson(const fs::path& file) {
  using Event = nlohmann::json::parse_event_t;
  constexpr int kDeepest = 100;  // what walks over a value calls itself once a level
  std::ifstream in(file, std::ios::binary);
  if (!in) Fail(file, "cannot be opened");
  try {
    return nlohmann::json::parse(in, [&](int depth, Event, nlohmann::json&) {
      if (depth <= kDeepest) return true;
      throw DataError(fmt::format("{}: JSON nested deeper than {}", file.string(), kDeepest));
    });
  } catch (const nlohmann::json::parse_error& error) {
    throw DataError(
        fmt::format("{}: no valid JSON at byte {}: {}", file.string(), error.byte, error.what()));
  } catch (const nlohmann::json::exception& error) {  // a number beyond all doubles
    throw DataError(fmt::format("{}: no usable JSON: {}", file.string(), error.what()));
  }
}

nlohmann::json RunDirectory::ReadRun() const { return ReadJson(RunJson()); }

nlohmann::json RunDirectory::ReadResult() const { return ReadJson(ResultJson()); }

}  // namespace gyrobench::recording
