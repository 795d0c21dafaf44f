#include "daemon/segment_analysis.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

namespace gyrobench::daemon {

SegmentAnalysis::SegmentAnalysis(Clock& clock, Telemetry& telemetry, Evaluate evaluate)
    : telemetry_(telemetry), evaluate_(std::move(evaluate)), worker_("analysis", clock) {
  worker_.Start();
}

SegmentAnalysis::~SegmentAnalysis() { worker_.Stop(); }

void SegmentAnalysis::Begin(Utime utime) {
  Telemetry::Snapshot now = telemetry_.TakeSnapshot();
  {
    const std::lock_guard lock(mutex_);
    next_ = std::move(now);
    next_utime_ = utime;
  }
  worker_.Post([this] { Work(); });
}

void SegmentAnalysis::Finish(Clock::Participant& caller) {
  {
    const std::lock_guard lock(mutex_);
    next_ = nullptr;
  }
  worker_.Finish(caller);
}

void SegmentAnalysis::Work() {
  Telemetry::Snapshot snapshot;
  Utime utime = 0;
  {
    const std::lock_guard lock(mutex_);
    if (!next_) return;  // a newer one took its place, and is done
    snapshot = std::exchange(next_, nullptr);
    utime = next_utime_;
  }
  try {
    newest_ = evaluate_(snapshot);
    telemetry_.SendResults(newest_, utime, false);
  } catch (const std::exception& error) {  // the stand may be moving: the run goes on without it
    spdlog::error("results of a segment: {}", error.what());
  }
}

calibration::AnalysisResult SegmentAnalysis::Newest(Clock::Participant& caller) {
  return worker_.Call(caller, [this] { return newest_; });
}

}  // namespace gyrobench::daemon
