// The procedures that users get.
#pragma once

#include <filesystem>
#include <string>

#include "procedures/engine/dry_bench.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {

inline const std::filesystem::path kShippedFolder =
    std::filesystem::path(GYROBENCH_SOURCE_DIR) / "procedures";

inline Procedure Shipped(const std::string& name) {
  return ProcedureLibrary({kShippedFolder}).Find(name);
}

// Why a dry run is refused; empty where it is not.
inline std::string RefusalOf(const std::string& name, const Parameters& parameters,
                             const std::vector<AxisFacts>& axes) {
  return MessageOf<Error>([&] { DryRun(Shipped(name), parameters, axes); });
}

}  // namespace gyrobench::procedures
