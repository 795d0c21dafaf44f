// Which of a scenario's faults act, and since when.
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/scenario.h"

namespace gyrobench::stand {

// What the faults make of a device's answer to one request.
struct AnswerFault {
  bool silent = false, garbage = false, spoiled = false, stale = false, impostor = false;
  bool lost_power = false;  // since the request before
  int exception = 0;        // Modbus exception code; 0: none
  double late_s = 0.0;
};

// The faults of a scenario in time. A fault that waits for a move or a request begins with it. What
// is left to chance is drawn from the seed, request by request, so that a scenario repeats. Times
// are seconds since power-on; calls may come from several threads.
class Faults {
 public:
  using Kind = config::FaultScenario::Kind;

  Faults(const config::Scenario& specimen, std::uint64_t seed);

  // The drive of an axis takes a move.
  void Moved(std::size_t axis, double t_s);
  // A device takes a request.
  AnswerFault Requested(std::string_view device, double t_s);
  // The amount of the first fault of that kind that acts on the device; nothing where none does.
  std::optional<double> Acting(std::string_view device, Kind kind, double t_s) const;

  struct Begun {
    double begin_s = 0.0, end_s = 0.0;
    config::FaultScenario fault;
  };
  // The earliest fault that has begun by `t_s`, each once.
  std::optional<Begun> TakeBegun(double t_s);

 private:
  struct Entry {
    config::FaultScenario fault;
    std::uint64_t source_seed = 0;
    double begin_s = std::numeric_limits<double>::infinity();
    double end_s = std::numeric_limits<double>::infinity();
    std::int64_t events = 0;    // moves or requests so far
    std::int64_t requests = 0;  // to its device so far
    bool taken = false;
    bool power_loss_told = false;

    bool Acts(double t_s) const { return t_s >= begin_s && t_s < end_s; }
  };
  void Begin(Entry& entry, double from_s) const;
  static bool Hits(const Entry& entry);
  static void Add(const Entry& entry, AnswerFault& answer);

  const double boot_time_s_;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace gyrobench::stand
