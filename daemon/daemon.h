// The bench as one object: configuration in, a running daemon out.
#pragma once

#include <memory>
#include <string>

#include "config/stand_config.h"

namespace gyrobench::daemon {

// Joins clock, virtual stand (only where the stand file has a [virtual] table), drivers, telemetry,
// run engine and control socket. Everything runs while the object lives; destruction is the
// controlled stop: the run is aborted, the axes are stopped, the record is closed.
class Daemon {
 public:
  // Throws Error with what is wrong and how to mend it. A device that does not answer is no error:
  // the daemon says so in its status, tries again, and refuses runs until it is well.
  explicit Daemon(const config::StandConfig& stand);
  ~Daemon();
  // What hangs in the daemon, so that axes can be neither watched nor stopped; empty where nothing
  // does. From any thread.
  std::string Stuck() const;
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrobench::daemon
