// What the control socket understands: docs/control-api.md. No transport here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/access.h"
#include "daemon/acquisition.h"
#include "daemon/control_server.h"
#include "daemon/lcm_publisher.h"
#include "daemon/notices.h"
#include "daemon/request_log.h"
#include "daemon/run_control.h"
#include "daemon/run_engine.h"
#include "drivers/line_figures.h"

namespace gyrobench::daemon {

// {"buses": [...]}: of each line how busy it is and what is expected of it, of each unit how often
// it was asked, how it answered, and how fast; since the daemon started, and of late.
nlohmann::json BusStatus(const config::StandConfig& stand,
                         const std::vector<drivers::LineFigures>& lines);

class ControlApi {
 public:
  struct Context {
    const config::StandConfig& stand;
    Clock& clock;
    const BenchTime& time;
    Acquisition& acquisition;
    RunEngine& engine;
    RunControl& control;
    LcmPublisher& publisher;
    Notices& notices;
    Access access = Access({});  // who may move the stand; others look, check and stop it
  };
  explicit ControlApi(const Context& context);

  // Requests that must not wait for each other: `stop` for nothing, and what looks or steers
  // neither for a start nor for a dry run, which take as long as their script.
  static constexpr std::size_t kLanes = 4;
  // The first so many: no request of theirs takes long.
  static constexpr std::size_t kQuickLanes = 2;
  static std::size_t LaneOf(const HttpRequest& request);
  // How often a stop was called for, as a request finds it when it comes. From any thread.
  std::int64_t Stamp() const;

  // Never throws: every failure is a reply with a status and {"error": ...}. From any thread.
  // Who asked is told to the log afterwards, and is not waited for.
  HttpReply Handle(const HttpRequest& request);

 private:
  Context context_;
  RequestLog log_;
};

}  // namespace gyrobench::daemon
