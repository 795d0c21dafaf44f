#include "daemon/daemon.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "base/clock.h"
#include "base/error.h"
#include "daemon/acquisition.h"
#include "daemon/bench_facts.h"
#include "daemon/bench_time.h"
#include "daemon/control_api.h"
#include "daemon/control_server.h"
#include "daemon/lcm_publisher.h"
#include "daemon/run_control.h"
#include "daemon/run_engine.h"
#include "daemon/run_record.h"
#include "daemon/simulated_buses.h"
#include "daemon/status_publisher.h"
#include "daemon/stranger_watch.h"
#include "daemon/supervisor.h"
#include "daemon/telemetry.h"
#include "drivers/factory.h"
#include "drivers/stand_lock.h"

namespace gyrobench::daemon {
namespace {

constexpr Utime kFirstTryPatience = 5 * kMicrosecondsPerSecond;

Utime WallClock() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

void CheckLcm(const config::LcmConfig& lcm, const LcmPublisher& publisher) {
  if (publisher.health().empty()) return;
  if (lcm.required) {
    throw Error(publisher.health() + " (lcm.required = true in the stand file: not starting)");
  }
  spdlog::warn("{}", publisher.health());
}

}  // namespace

// In the order of construction; destruction goes the other way: first nobody can ask for motion,
// then the run ends, then the buses, last what they were served by.
struct Daemon::Parts {
  explicit Parts(const config::StandConfig& configured)
      : stand(configured), publisher(stand.lcm.url, stand.lcm.channel_prefix) {
    RequireSocketOrNothing(stand.control_socket);
    CheckLcm(stand.lcm, publisher);
    MakeClockAndBuses();
    devices = std::make_unique<drivers::ModbusDevices>(*clock);
    supervisor = std::make_unique<Supervisor>(
        Supervisor::Context{stand, *clock, control, telemetry, [this] { status->Changed(); }});
    acquisition = std::make_unique<Acquisition>(
        stand, *clock, *devices, telemetry,
        [this](const Fault& fault) { supervisor->FellSilent(fault); },
        [this](const Fault& fault) { supervisor->Report(fault); }, notices);
    supervisor->Watch(*acquisition);
    status = std::make_unique<StatusPublisher>(stand, *clock, *acquisition, control, telemetry,
                                               publisher);
    time = std::make_unique<BenchTime>(stand, virtual_clock, *acquisition, control, *status);
    engine = std::make_unique<RunEngine>(RunEngine::Context{
        stand, *clock, *acquisition, telemetry, control, *time, [this] { status->Changed(); },
        [this](const Fault& fault) { supervisor->Report(fault); }, [this] { ClearFault(); },
        [this](const std::string& question_id) {
          if (simulated) simulated->Answered(question_id);
        }});
    api = std::make_unique<ControlApi>(ControlApi::Context{stand, *clock, *time, *acquisition,
                                                           *engine, control, publisher, notices,
                                                           Access(stand.control_movers)});
    acquisition->WhenWellnessChanges([this](bool all_well) {
      control.SetAllWell(all_well);
      status->Changed();
    });
    const auto starting = clock->Join("start");
    acquisition->Start();
    status->Start();
    acquisition->AwaitFirstTry(*starting, kFirstTryPatience);
    for (const DeviceStatus& device : acquisition->Devices()) {
      if (!device.ok) spdlog::warn("{}: {}", device.name, device.message);
    }
    TellOfInterruptedRuns();
    strangers = std::make_unique<StrangerWatch>(StrangerWatch::Context{
        stand.lcm.url, publisher.prefix() + "_STATUS", publisher.sender(),
        [this] { return publisher.goes_out(); },
        [this](const std::string& text) { notices.Add(clock->Now(), text); }});
    time->Idle(*starting);
    server = std::make_unique<ControlServer>(
        stand.control_socket,
        SocketRights{stand.control_socket_mode, stand.control_socket_owner,
                     stand.control_socket_group},
        [this](const HttpRequest& request) { return api->Handle(request); },
        ControlServer::Lanes{ControlApi::kLanes, ControlApi::LaneOf,
                             [this] { return api->Stamp(); }, ControlApi::kQuickLanes});
  }

  // Nothing is waited for before everything that moves or heats was told to stop. Who asks is
  // answered until the run's record is closed: its client then finds the end in it.
  ~Parts() {
    engine->StopForGood("aborted because the daemon was told to end");
    engine->Shutdown();
    server.reset();
    // A virtual bus at rest would answer nobody.
    if (virtual_clock != nullptr) virtual_clock->SetPace(VirtualClock::kUnpaced);
    TidyUp("stop", [this](Clock::Participant& caller) { acquisition->StopAll(caller); });
    TidyUp("relays", [this](Clock::Participant& caller) {
      if (Outputs* outputs = acquisition->outputs()) outputs->AllOff(caller);
    });
    acquisition->Stop();
  }

  // Not before what turns was told to stop: whole logs are read. Nothing moves until somebody says
  // that he has heard of it: whoever mounted the part may have been at the stand since.
  void TellOfInterruptedRuns() {
    std::map<std::string, std::optional<double>> now_deg;
    for (const DeviceStatus& device : acquisition->Devices()) {
      if (device.kind != "encoder" || !device.ok) continue;
      const std::string axis = device.name.substr(device.name.find('.') + 1);
      now_deg[axis] = acquisition->Axis(axis).reference.angle_deg;
    }
    interrupted = CloseInterruptedRuns(stand.records);
    for (const InterruptedRun& run : interrupted) {
      const std::string text = DescribeInterruption(run, stand, now_deg);
      notices.Add(clock->Now(), text);
      Fault fault{"run", text + ". Look at the stand, then: gyrobench reset"};
      if (IsResumable(run.procedure))
        fault.message += ", and to go on with it: gyrobench resume " + run.directory.run_id();
      fault.left = HowItIs(*acquisition);
      supervisor->Report(fault);
    }
  }

  bool IsResumable(const std::string& procedure) const {
    return std::ranges::any_of(engine->library().List(), [&](const auto& info) {
      return info.name == procedure && info.resumable;
    });
  }

  void MakeClockAndBuses() {
    if (!stand.virtual_stand) {
      clock = MakeSystemClock();
      return;
    }
    auto made = MakeVirtualClock(WallClock());
    virtual_clock = made.get();
    clock = std::move(made);
    simulated = MakeSimulatedBuses(stand, *clock);
    stand.buses = simulated->buses();
  }

  // Also without a run: an earlier try may have failed.
  template <typename Action>
  void TidyUp(const char* what, Action action) {
    const auto tidying = clock->Join(what);
    try {
      action(*tidying);
    } catch (const Error& error) {
      spdlog::error("{}: {}", what, error.what());
    }
  }

  void ClearFault() {
    supervisor->ClearFault();
    // Before the server is there, or in its one thread for what steers.
    for (const InterruptedRun& run : std::exchange(interrupted, {})) Acknowledge(run);
  }

  config::StandConfig stand;
  const drivers::StandLock lock{stand, "gyrobenchd"};  // before anything is opened
  LcmPublisher publisher;
  std::unique_ptr<Clock> clock;
  VirtualClock* virtual_clock = nullptr;
  std::unique_ptr<SimulatedBuses> simulated;
  RunControl control;
  Notices notices;
  std::vector<InterruptedRun> interrupted;  // that nobody has acknowledged
  // A record that fails is reported from within Send, which a fault message would need again: the
  // run is told directly.
  Telemetry telemetry{publisher, [this](const std::string& message) {
                        spdlog::error("fault: record: {}", message);
                        control.Report({"record", message});
                      }};
  std::unique_ptr<drivers::ModbusDevices> devices;
  std::unique_ptr<Supervisor> supervisor;
  std::unique_ptr<Acquisition> acquisition;
  std::unique_ptr<StatusPublisher> status;
  std::unique_ptr<BenchTime> time;
  std::unique_ptr<RunEngine> engine;
  std::unique_ptr<ControlApi> api;
  std::unique_ptr<ControlServer> server;
  std::unique_ptr<StrangerWatch> strangers;
};

Daemon::Daemon(const config::StandConfig& stand) : parts_(std::make_unique<Parts>(stand)) {}

Daemon::~Daemon() = default;

std::string Daemon::Stuck() const {
  constexpr double kLongestStatus_s = 30.0;
  const double status_s = parts_->status->BusyFor_s();
  if (status_s > kLongestStatus_s)
    return fmt::format("the thread of the status has been at one message for {:.0f} s", status_s);
  if (std::string stuck = parts_->server->Stuck(); !stuck.empty()) return stuck;
  // Those of buses on a virtual clock wait for each other, as long as it takes.
  return parts_->virtual_clock == nullptr ? parts_->acquisition->StuckBus() : "";
}

}  // namespace gyrobench::daemon
