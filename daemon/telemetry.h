// Where every message passes: numbered, published, recorded and handed to the live analysis, in one
// order.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"
#include "calibration/estimators/results.h"
#include "calibration/signal/collector.h"
#include "calibration/trace/trace.h"
#include "calibration/trace/trace_result.h"
#include "daemon/lcm_publisher.h"
#include "gyrobench/reflection.hpp"
#include "gyrobench/run_t.hpp"

namespace gyrobench::calibration {
class Analyzer;
}
namespace gyrobench::recording {
class EventLogWriter;
class MessageDecoder;
}  // namespace gyrobench::recording

namespace gyrobench::daemon {

// The live analysis sees the messages in the order in which the record holds them, through the
// decoder that reads records: so `gyrobench analyze` of the record gives the same numbers.
//
// Thread-safe. Send fills in run_id and seq of the message that it is given.
class Telemetry {
 public:
  // `on_record_failure` is called, once a run, when the record can no longer be written.
  Telemetry(LcmPublisher& publisher, std::function<void(const std::string&)> on_record_failure);
  ~Telemetry();

  // From here on messages carry `run_id` and go to the log of `run_folder`. `earlier`: fills in one
  // message of what was measured before the run after the other, false behind the last one; they
  // are recorded and analysed as the run's own. Throws DataError, and what `earlier` throws.
  void BeginRun(const std::string& run_id, const std::string& log_file, const MeasurementInfo& info,
                Utime start, const std::function<bool(AnyMessage&)>& earlier = {});
  // From here on samples are neither recorded nor analysed: what follows are results and the end. A
  // later analysis of the record then sees just what the last live one sees.
  void EndMeasurement();
  // Closes the log. Returns what went wrong with it, empty if nothing.
  std::string EndRun();
  // Makes what is recorded safe against a crash of the machine.
  void Sync();

  // Message: any type of msgs/ (instantiated in telemetry.cc for all of them).
  template <typename Message>
  void Send(Message& message);
  // The last message of a run in two steps: numbered and recorded before the log is closed, and
  // published as it was numbered once it is known what became of the record.
  void RecordOnly(run_t& message);
  void PublishOnly(const run_t& message);
  // One message per result: _BIAS_RESULT and _SCALE_RESULT.
  void SendResults(const calibration::AnalysisResult& results, Utime utime, bool final);

  // A message for the verdict of each axis and one for each effect: _TRACE_RESULT.
  void SendTrace(const calibration::TraceResult& trace, Utime utime, bool final);
  // The three axes as one, where the trace has them.
  void SendModel(const calibration::Traced& traced, Utime utime, bool final);

  // What the run has measured so far; nullptr without a run. Taken at once, however much it is, and
  // evaluated wherever there is time: acquisition goes on meanwhile.
  using Snapshot = std::shared_ptr<const calibration::Analyzer>;
  Snapshot TakeSnapshot() const;
  // The same, for a trace: with the reference's readings on the gyro's clock where the two part so
  // far that it matters (calibration/signal/clock_drift.h), for which the log is read once more.
  calibration::Recording Recorded();
  // ResultOf now.
  calibration::AnalysisResult Analyse() const;

 private:
  struct Run;
  bool Measures() const;
  calibration::Recording ReadAgain(double drift_ppm, std::int64_t least_samples);
  template <typename Message>
  void Number(Message& message);
  void TakeOver(const std::string& run_id, Run& run, AnyMessage& message) const;
  template <typename Message>
  std::size_t Encode(const Message& message);
  template <typename Message>
  void Emit(Message& message);
  void Record(std::string_view suffix, Utime utime, std::size_t size);

  LcmPublisher& publisher_;
  const std::function<void(const std::string&)> on_record_failure_;
  mutable std::mutex mutex_;
  std::vector<std::uint8_t> buffer_;
  std::string channel_;
  std::unique_ptr<Run> run_;
  std::string run_id_;
  std::vector<std::int64_t> seq_;  // of each type of messages, the next number
};

// Its analysis. Where that is not possible yet, a remark says why.
calibration::AnalysisResult ResultOf(const Telemetry::Snapshot& snapshot);

}  // namespace gyrobench::daemon
