// The devices of the stand at work: polled on their buses, their samples sent on, their motion
// commanded.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"
#include "config/stand_config.h"
#include "daemon/axis_unit.h"
#include "daemon/bus_worker.h"
#include "daemon/gyro_feed.h"
#include "daemon/notices.h"
#include "daemon/outputs.h"
#include "daemon/polled_device.h"
#include "daemon/telemetry.h"
#include "drivers/device_maker.h"

namespace gyrobench::daemon {

// Runs one BusWorker a bus. Views may be asked from any thread; motion is commanded by a thread
// that waits as the participant it gives.
class Acquisition {
 public:
  // `devices`: where they come from; outlives this. `on_silence`: a device that was there answers
  // no more. `on_fault`: the stand is where it must not be, or a drive reports an alarm. Both are
  // told with the last samples. `notices`: of what was found and mended.
  Acquisition(const config::StandConfig& stand, Clock& clock, drivers::DeviceMaker& devices,
              Telemetry& telemetry, FaultHandler on_silence, FaultHandler on_fault,
              Notices& notices);
  ~Acquisition();

  // `on_well`: told, in the buses' threads, whenever all devices are well or one is no more. Before
  // Start.
  void WhenWellnessChanges(std::function<void(bool all_well)> on_well) {
    on_well_ = std::move(on_well);
  }
  void Start();
  void Stop();

  // From now on no device is polled until Resume; what is commanded is still done. Waits, as
  // `caller`, for the end of what the buses are doing.
  void Hold(Clock::Participant& caller);
  void Resume();

  // Waits, as `caller`, until every device was tried once, for `patience` at most.
  void AwaitFirstTry(Clock::Participant& caller, Utime patience) const;
  std::vector<DeviceStatus> Devices() const;
  AxisView Axis(const std::string& name) const;
  // How often its drive was found without power when it was opened.
  int PowerLosses(const std::string& axis) const;
  SensorView Sensor() const;
  // Whether a sample of the gyro has come that was taken at `since` or later.
  bool HasSampleOf(Utime since) const { return gyro_->newest_sample() >= since; }
  // The bus whose thread has been at one thing for longer than its devices' silence can explain;
  // empty where there is none.
  std::string StuckBus() const;
  // Of every axis and of the gyro; asked for when something went wrong.
  LastSamples Last() const;
  MeasurementInfo Info() const;
  // How the lines do.
  std::vector<drivers::LineFigures> Lines() const { return maker_.Lines(); }

  // Axes whose reference is read at its full rate; the others at their idle rate.
  void SetActiveAxes(const std::set<std::string>& names);

  // The drive's rate. `may_move` is asked in the bus's thread right before the drive is, and throws
  // when the run is to end: nothing moves after a stop. Throws DeviceError, LimitError, and what
  // `may_move` throws.
  double MoveBy(Clock::Participant& caller, const std::string& axis, double angle_deg,
                double rate_deg_s, double acceleration_deg_s2,
                const std::function<void()>& may_move);
  // Asks drive and reference now, not at the next poll. Throws DeviceError.
  AxisView ReadNow(Clock::Participant& caller, const std::string& axis);
  // The drive alone: to be asked even when the reference is silent.
  drivers::AxisState ReadDriveNow(Clock::Participant& caller, const std::string& axis);
  // Stops all axes, those that move first, and before all else that was asked of their buses; does
  // not wait. From any thread.
  void PostStopAll();
  // The same of a run that waits for a device: a drive that is silent is stopped when it is opened
  // again.
  void PostStopWhatAnswers();
  // Stops all axes, waits for the drives' answers. What failed is returned, or thrown as one, after
  // all were tried.
  std::vector<Fault> TryStopAll(Clock::Participant& caller);
  void StopAll(Clock::Participant& caller);
  // What is beyond a limit and was told is told once more; does not wait.
  void PostRearm();
  // Clears latched alarms of the drives; does not wait. One that is still there shows at the next
  // poll. A drive that does not answer is a line in the status, as ever between runs.
  void PostClearAlarms();
  // Does something in the thread of a bus, and waits for it as `caller`: while it is held, with
  // devices of another configuration than its own.
  void OnBus(Clock::Participant& caller, const std::string& bus, const std::function<void()>& work);
  drivers::DeviceMaker& devices() { return maker_; }
  // The next poll of each device opens it: somebody else asked it meanwhile, and turned the axes.
  void OpenAnew(Clock::Participant& caller);
  // Fan and heater; nullptr where the stand cannot switch any.
  Outputs* outputs() const { return outputs_.get(); }

 private:
  FaultHandler WithLastSamples(FaultHandler handler) const;
  void AddAxis(const config::AxisConfig& config);
  void AddDrive(AxisUnit& axis);
  void AddEncoder(AxisUnit& axis);
  void AddGyro();
  void AddOutputs();
  // Beyond the range of the part at two blocks on end, all is stopped and switched off.
  void WatchTemperature(double temperature_degC);
  void TellWellness();
  // `not_stopped`: why, empty where it was.
  void SayFoundMoving(const config::AxisConfig& axis, const std::string& not_stopped);
  void AddDevice(BusWorker& bus, DeviceStatus identity, PolledDevice::Actions actions);
  BusWorker& BusOf(const std::string& name);
  AxisUnit& AxisNamed(const std::string& name) const;
  void SendAxes(Utime utime);
  // `done`: told how it went, with nullptr where the drive took it. A drive that does not answer is
  // tried again behind the others that wait for its line. `key`: as of PostUrgentOnce.
  using StopHandler = std::function<void(const std::exception* error)>;
  void PostStop(AxisUnit& axis, const std::string& key, StopHandler done, int turn = 1);
  // What may move before what is at rest, and drives that answer before those that are silent, which
  // take their time.
  std::vector<AxisUnit*> MostUrgentFirst() const;

  const config::StandConfig& stand_;
  Clock& clock_;
  drivers::DeviceMaker& maker_;
  Telemetry& telemetry_;
  const FaultHandler on_silence_;
  const FaultHandler on_fault_;
  Notices& notices_;
  std::vector<std::unique_ptr<BusWorker>> buses_;
  std::vector<std::unique_ptr<AxisUnit>> axes_;
  std::unique_ptr<GyroFeed> gyro_;
  std::unique_ptr<Outputs> outputs_;
  std::vector<std::unique_ptr<PolledDevice>> devices_;
  std::function<void(bool)> on_well_ = [](bool) {};
  std::mutex well_mutex_;  // guards the next, and the order in which it is told
  bool all_well_ = true;   // as told last
  int beyond_range_ = 0;   // blocks on end; of the gyro's bus thread
};

}  // namespace gyrobench::daemon
