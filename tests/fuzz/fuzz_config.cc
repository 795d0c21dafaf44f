// libFuzzer target: the bytes are a stand file, and a scenario.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/laws.h"
#include "tests/recording/sinks.h"

namespace {

// A folder with all that a stand file names.
class ConfigFolder {
 public:
  ConfigFolder() {
    std::filesystem::copy(std::filesystem::path(GYROBENCH_SOURCE_DIR) / "config", file("config"),
                          std::filesystem::copy_options::recursive);
  }
  std::filesystem::path file(const char* name) const { return folder_ / name; }

 private:
  gyrobench::TemporaryFolder folder_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ConfigFolder folder;
  const std::filesystem::path file = folder.file("config/fuzzed.toml");
  gyrobench::recording::WriteFile(file, {reinterpret_cast<const char*>(data), size});
  gyrobench::testing::DigestStandFile(file);
  gyrobench::testing::DigestScenario(file);
  return 0;
}
