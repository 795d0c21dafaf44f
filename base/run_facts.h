// What the record of a run says of it, for people: run.json without the measurement's own facts.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"

namespace gyrobench {

// What is not known stays empty (times: 0). Times are microseconds since the epoch.
struct RunFacts {
  std::string run_id;
  std::string procedure;
  std::string configuration;  // name of the stand's configuration
  std::string sensor;         // serial number
  std::string version;        // of gyrobench, as the run began
  Utime started_utime = 0, ended_utime = 0;
  // The sensor's power-on, from which the times of the measurement count; 0: they count from the
  // run's begin.
  Utime power_on_utime = 0;
  // Of the procedure, by names that end in their units: rate_deg_s.
  std::vector<std::pair<std::string, std::string>> parameters;
  struct Said {
    double t_s = kMissing;  // since the run's begin
    std::string text;
  };
  std::vector<Said> said;  // by the procedure, its choices and their reasons among it
  // What could not be read and therefore is not among the above: which field, found and expected.
  std::vector<std::string> damage;
};

}  // namespace gyrobench
