#include "tests/daemon/fake_bench.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>

#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest_s = 3600.0;

fs::path MakeFolder() {
  std::string pattern = (fs::temp_directory_path() / "gyrobench-XXXXXX").string();
  return ::mkdtemp(pattern.data());
}

config::StandConfig StandIn(const fs::path& folder, const FakeBench::Change& change) {
  config::StandConfig stand = StandOfFakes();
  stand.name = "fakes";
  stand.records = folder / "records";
  stand.procedure_dirs = {folder / "procedures"};
  if (change) change(stand);
  return stand;
}

}  // namespace

FakeBench::FakeBench(const std::string& lcm_url, const Change& change)
    : folder(MakeFolder()),
      stand(StandIn(folder, change)),
      clock(MakeVirtualClock(kStart)),
      publisher(lcm_url, "TEST") {
  fs::create_directories(stand.procedure_dirs.front());
  supervisor = std::make_unique<Supervisor>(
      Supervisor::Context{stand, *clock, control, telemetry, [this] { status->Changed(); }});
  const auto fault = [this](const Fault& what) { supervisor->Report(what); };
  acquisition = std::make_unique<Acquisition>(
      stand, *clock, devices, telemetry,
      [this](const Fault& what) { supervisor->FellSilent(what); }, fault, notices);
  supervisor->Watch(*acquisition);
  status =
      std::make_unique<StatusPublisher>(stand, *clock, *acquisition, control, telemetry, publisher);
  time = std::make_unique<BenchTime>(stand, nullptr, *acquisition, control, *status);
  engine = std::make_unique<RunEngine>(RunEngine::Context{
      stand, *clock, *acquisition, telemetry, control, *time, [this] { status->Changed(); }, fault,
      [this] { supervisor->ClearFault(); }, [](const std::string&) {}});
  api_ = std::make_unique<ControlApi>(ControlApi::Context{stand, *clock, *time, *acquisition,
                                                          *engine, control, publisher, notices});
  acquisition->WhenWellnessChanges([this](bool all_well) { control.SetAllWell(all_well); });
  me_ = clock->Join("test");
  acquisition->Start();
  status->Start();
  acquisition->AwaitFirstTry(*me_, 5 * kMicrosecondsPerSecond);
}

FakeBench::~FakeBench() {
  EndRun();
  acquisition->Stop();
  std::error_code ignored;  // what is left is the test's own
  fs::remove_all(folder, ignored);
}

void FakeBench::EndRun() {
  me_.reset();
  engine->Shutdown();
}

void FakeBench::Script(const std::string& name, const std::string& body) const {
  std::ofstream file(stand.procedure_dirs.front() / (name + ".lua"));
  file << "procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }\n"
       << "function run(p)\n"
       << body << "\nend\n";
}

void FakeBench::Wait(double duration_s) {
  me_->WaitUntil(clock->Now() + static_cast<Utime>(duration_s * 1e6));
}

bool FakeBench::WaitFor(const std::function<bool()>& so) {
  for (int s = 0; s < 120 && !so(); ++s) Wait(1.0);
  return so();
}

bool FakeBench::InnerTurns() {
  return WaitFor([&] { return devices.drives.at("inner")->AngleDeg() > 1.0; });
}

std::vector<std::vector<std::string>> FakeBench::CallsOfAll() const {
  std::vector<std::vector<std::string>> out;
  for (const config::AxisConfig& axis : stand.axes) out.push_back(CallsOf(axis.name));
  return out;
}

RunView FakeBench::Ended() {
  for (double waited_s = 0.0; waited_s < kLongest_s; waited_s += 0.5) {
    if (!control.run_is_on()) return engine->View().value();
    Wait(0.5);
  }
  ADD_FAILURE() << "the run is still on after an hour";
  return engine->View().value();
}

}  // namespace gyrobench::daemon
