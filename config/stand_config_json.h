// The stand file as a record keeps it.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace gyrobench::config {

struct StandConfig;

// All of the stand and of its device maps, with the keys of the files. Of a simulation only that it
// is one
// ("virtual": true): its truth, seed and answers stay out of records, so that no analysis can know
// them.
nlohmann::json ToJson(const StandConfig& stand);

}  // namespace gyrobench::config
