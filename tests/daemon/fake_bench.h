// The daemon's parts on devices in memory and a virtual clock: all but its sockets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/control_api.h"
#include "daemon/status_publisher.h"
#include "daemon/supervisor.h"
#include "tests/daemon/fake_stand.h"

namespace gyrobench::daemon {

// Records and scripts are in a folder of its own that goes with it. What holds time is the test's
// thread: bench time passes in Wait and Ended alone.
class FakeBench {
 public:
  using Change = std::function<void(config::StandConfig&)>;
  // `lcm_url`: where it publishes; `change`: what its stand file has otherwise.
  explicit FakeBench(const std::string& lcm_url = "memq://", const Change& change = {});
  ~FakeBench();
  FakeBench(const FakeBench&) = delete;
  FakeBench& operator=(const FakeBench&) = delete;

  // A procedure without parameters; `body` is that of its run(p).
  void Script(const std::string& name, const std::string& body) const;
  HttpReply Ask(const std::string& method, const std::string& path, const std::string& body = "") {
    return api_->Handle({method, path, body});
  }
  // As it is answered where it waited since `stamp`, that of Stamp then.
  HttpReply AskLate(std::int64_t stamp, const std::string& path, const std::string& body) {
    return api_->Handle({"POST", path, body, stamp});
  }
  std::int64_t Stamp() const { return api_->Stamp(); }
  void Wait(double duration_s);
  // The test's thread, for what waits as somebody.
  Clock::Participant& me() { return *me_; }
  // Waits until the run has ended. Fails the test where it is on after an hour.
  RunView Ended();
  // As the daemon does at its end; time passes for the others from then on.
  void EndRun();
  // Waits until it is so, in steps of a second. False where it is not after two minutes.
  bool WaitFor(const std::function<bool()>& so);
  // The procedure has moved the inner axis. Waits for it.
  bool InnerTurns();
  std::vector<std::string> CallsOf(const std::string& axis) const {
    return devices.drives.at(axis)->calls();
  }
  // Of all drives, in the stand's order.
  std::vector<std::vector<std::string>> CallsOfAll() const;

  const std::filesystem::path folder;
  const config::StandConfig stand;
  const std::unique_ptr<VirtualClock> clock;
  FakeStand devices{*clock};
  RunControl control;
  Notices notices;
  LcmPublisher publisher;
  std::vector<std::string> record_failures;
  Telemetry telemetry{publisher, [this](const std::string& message) {
                        record_failures.push_back(message);
                        control.Report({"record", message});
                      }};
  std::unique_ptr<Supervisor> supervisor;
  std::unique_ptr<Acquisition> acquisition;
  std::unique_ptr<StatusPublisher> status;
  std::unique_ptr<BenchTime> time;
  std::unique_ptr<RunEngine> engine;

 private:
  std::unique_ptr<ControlApi> api_;
  std::unique_ptr<Clock::Participant> me_;
};

}  // namespace gyrobench::daemon
