// What a run has measured so far, worked out beside it.
#pragma once

#include <functional>
#include <mutex>

#include "base/clock.h"
#include "calibration/estimators/results.h"
#include "daemon/bus_worker.h"
#include "daemon/telemetry.h"

namespace gyrobench::daemon {

// The results of a run's segments, each sent when it is there. The run goes on meanwhile: its
// pauses do not grow with what has been measured. On a virtual clock time stands still until a
// result is there, so that a record does not depend on the machine's speed.
class SegmentAnalysis {
 public:
  // `evaluate`: what is done with a snapshot.
  using Evaluate = std::function<calibration::AnalysisResult(const Telemetry::Snapshot&)>;
  SegmentAnalysis(Clock& clock, Telemetry& telemetry, Evaluate evaluate = ResultOf);
  // Ends after what it is at, which takes no time once it was finished; else from a thread that
  // takes no part in the clock any more.
  ~SegmentAnalysis();

  // Of all until now, to be sent with this time. Does not wait; where the last is still at work,
  // the newest alone comes after it.
  void Begin(Utime utime);
  // Nothing is begun or asked any more: waits, as `caller`, for the end of what is at work.
  void Finish(Clock::Participant& caller);
  // The newest that was begun. Waits for it, as `caller`.
  calibration::AnalysisResult Newest(Clock::Participant& caller);

 private:
  void Work();

  Telemetry& telemetry_;
  const Evaluate evaluate_;
  std::mutex mutex_;  // guards the next two
  Telemetry::Snapshot next_;
  Utime next_utime_ = 0;
  calibration::AnalysisResult newest_;  // of the worker's thread
  BusWorker worker_;
};

}  // namespace gyrobench::daemon
