#include "daemon/telemetry.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "calibration/estimators/analyzer.h"
#include "calibration/signal/clock_drift.h"
#include "daemon/messages.h"
#include "gyrobench/reflection.hpp"
#include "recording/event_log.h"
#include "recording/message_decoder.h"
#include "recording/replay.h"

namespace gyrobench::daemon {

struct Telemetry::Run {
  Run(const std::string& run_id, const std::string& log_file, const MeasurementInfo& info,
      Utime start)
      : record(std::filesystem::path(log_file).parent_path()),
        log(std::make_shared<recording::EventLogWriter>(log_file)),
        decoder(info, start, analyzer, run_id) {}
  const std::filesystem::path record;
  // Shared with who syncs it, so that no sample waits for the disk.
  std::shared_ptr<recording::EventLogWriter> log;
  calibration::Analyzer analyzer;
  recording::MessageDecoder decoder;
  std::string failure;
  bool measuring = true;
  double reference_drift_ppm = 0.0;  // that was found last
};

Telemetry::Telemetry(LcmPublisher& publisher,
                     std::function<void(const std::string&)> on_record_failure)
    : publisher_(publisher),
      on_record_failure_(std::move(on_record_failure)),
      seq_(std::variant_size_v<AnyMessage>, 0) {}

Telemetry::~Telemetry() = default;

void Telemetry::BeginRun(const std::string& run_id, const std::string& log_file,
                         const MeasurementInfo& info, Utime start,
                         const std::function<bool(AnyMessage&)>& earlier) {
  auto run = std::make_unique<Run>(run_id, log_file, info, start);
  AnyMessage message;
  while (earlier && earlier(message)) TakeOver(run_id, *run, message);
  const std::lock_guard lock(mutex_);
  run_ = std::move(run);
  run_id_ = run_id;
}

void Telemetry::EndMeasurement() {
  const std::lock_guard lock(mutex_);
  if (run_) run_->measuring = false;
}

// Nobody else knows of the run yet: what is sampled meanwhile comes before it.
void Telemetry::TakeOver(const std::string& run_id, Run& run, AnyMessage& message) const {
  std::visit(
      [&](auto& body) {
        using Message = std::decay_t<decltype(body)>;
        body.run_id = run_id;
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(body.getEncodedSize()));
        body.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
        run.log->Write(std::string(publisher_.prefix()).append(Reflection<Message>::kSuffix),
                       body.utime, bytes.data(), bytes.size());
        if constexpr (std::is_same_v<Message, gyro_t>) run.decoder.Gyro(body);
        if constexpr (std::is_same_v<Message, angle_t>) run.decoder.Angle(body);
        if constexpr (std::is_same_v<Message, run_t>) run.decoder.Run(body);
      },
      message);
}

// Whether samples go to the record and the analysis. With mutex_ held.
bool Telemetry::Measures() const { return run_ && run_->measuring && run_->failure.empty(); }

std::string Telemetry::EndRun() {
  std::unique_ptr<Run> ended;
  {
    const std::lock_guard lock(mutex_);
    run_id_.clear();
    ended = std::move(run_);
  }
  if (!ended) return {};
  if (!ended->failure.empty()) return ended->failure;
  try {
    ended->log->Close();
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

void Telemetry::Sync() {
  std::shared_ptr<recording::EventLogWriter> log;
  {
    const std::lock_guard lock(mutex_);
    if (!run_ || !run_->failure.empty()) return;
    log = run_->log;
  }
  try {
    log->Sync();
  } catch (const DataError& error) {
    {
      const std::lock_guard lock(mutex_);
      // Whoever ended the run meanwhile has closed the log, and hears of its errors there.
      if (!run_ || run_->log != log || !run_->failure.empty()) return;
      run_->failure = error.what();
    }
    on_record_failure_(error.what());
  }
}

// With mutex_ held; the message is in buffer_.
void Telemetry::Record(std::string_view suffix, Utime utime, std::size_t size) {
  channel_.assign(publisher_.prefix()).append(suffix);
  try {
    run_->log->Write(channel_, utime, buffer_.data(), size);
  } catch (const DataError& error) {
    run_->failure = error.what();
    on_record_failure_(run_->failure);
  }
}

// With mutex_ held.
template <typename Message>
void Telemetry::Number(Message& message) {
  message.run_id = run_id_;
  message.seq = seq_[Reflection<Message>::kIndex]++;
}

// With mutex_ held: into buffer_. Returns how many bytes.
template <typename Message>
std::size_t Telemetry::Encode(const Message& message) {
  const int size = message.getEncodedSize();
  if (buffer_.size() < static_cast<std::size_t>(size)) {
    buffer_.resize(static_cast<std::size_t>(size));
  }
  message.encode(buffer_.data(), 0, size);
  return static_cast<std::size_t>(size);
}

// With mutex_ held.
template <typename Message>
void Telemetry::Emit(Message& message) {
  constexpr std::string_view kSuffix = Reflection<Message>::kSuffix;
  Number(message);
  const std::size_t size = Encode(message);
  constexpr bool kIsSample = std::is_same_v<Message, gyro_t> || std::is_same_v<Message, angle_t>;
  if (run_ && run_->failure.empty() && (run_->measuring || !kIsSample)) {
    Record(kSuffix, message.utime, size);
  }
  publisher_.Publish(kSuffix, buffer_.data(), size);
}

void Telemetry::RecordOnly(run_t& message) {
  const std::lock_guard lock(mutex_);
  Number(message);
  const std::size_t size = Encode(message);
  if (run_ && run_->failure.empty()) Record(Reflection<run_t>::kSuffix, message.utime, size);
}

void Telemetry::PublishOnly(const run_t& message) {
  const std::lock_guard lock(mutex_);
  const std::size_t size = Encode(message);
  publisher_.Publish(Reflection<run_t>::kSuffix, buffer_.data(), size);
}

template <typename Message>
void Telemetry::Send(Message& message) {
  const std::lock_guard lock(mutex_);
  Emit(message);
  if (!Measures()) return;
  if constexpr (std::is_same_v<Message, gyro_t>) run_->decoder.Gyro(message);
  if constexpr (std::is_same_v<Message, angle_t>) run_->decoder.Angle(message);
  if constexpr (std::is_same_v<Message, run_t>) run_->decoder.Run(message);
}

// NOLINTNEXTLINE(bugprone-macro-parentheses): a type has none.
#define GYROBENCH_INSTANTIATE(Message) template void Telemetry::Send(Message&);
GYROBENCH_FOR_EACH_MESSAGE(GYROBENCH_INSTANTIATE)
#undef GYROBENCH_INSTANTIATE

void Telemetry::SendResults(const calibration::AnalysisResult& results, Utime utime, bool final) {
  const std::lock_guard lock(mutex_);
  for (const calibration::BiasResult& bias : results.bias) {
    bias_result_t message = ToMessage(bias);
    message.utime = utime;
    message.final = final;
    Emit(message);
  }
  for (const calibration::ScaleResult& scale : results.scale) {
    scale_result_t message = ToMessage(scale);
    message.utime = utime;
    message.final = final;
    Emit(message);
  }
}

void Telemetry::SendTrace(const calibration::TraceResult& trace, Utime utime, bool final) {
  const std::lock_guard lock(mutex_);
  for (const calibration::ChannelTrace& channel : trace.channels) {
    for (trace_result_t& message : ToMessages(channel)) {
      message.utime = utime;
      message.final = final;
      Emit(message);
    }
  }
}

void Telemetry::SendModel(const calibration::Traced& traced, Utime utime, bool final) {
  std::optional<model_result_t> message = ModelMessage(traced);
  if (!message) return;
  message->utime = utime;
  message->final = final;
  const std::lock_guard lock(mutex_);
  Emit(*message);
}

Telemetry::Snapshot Telemetry::TakeSnapshot() const {
  const std::lock_guard lock(mutex_);
  return run_ ? std::make_shared<const calibration::Analyzer>(run_->analyzer) : nullptr;
}

calibration::Recording Telemetry::Recorded() {
  const Snapshot snapshot = TakeSnapshot();
  if (!snapshot) return calibration::Recording();
  double guess_ppm = 0.0;
  {
    const std::lock_guard lock(mutex_);
    if (run_) guess_ppm = run_->reference_drift_ppm;
  }
  std::vector<calibration::Recording> recordings;
  recordings.push_back(snapshot->Take());
  const std::int64_t samples = recordings.front().samples;
  const std::vector<Defect> defects = recordings.front().defects;
  const auto read = [&](double drift_ppm) {
    std::vector<calibration::Recording> again;
    again.push_back(ReadAgain(drift_ppm, samples));
    // The log may end in a message that is still being written.
    again.front().defects = defects;
    return again;
  };
  try {
    recordings = calibration::OnOneClock(std::move(recordings), guess_ppm, read);
  } catch (const std::exception& error) {  // the run goes on, and its trace with what there is
    spdlog::warn("the clocks of gyro and reference part, and the log was not read again: {}",
                 error.what());
    return snapshot->Take();
  }
  const std::lock_guard lock(mutex_);
  if (run_) run_->reference_drift_ppm = recordings.front().drift_correction.drift_ppm;
  return std::move(recordings.front());
}

calibration::Recording Telemetry::ReadAgain(double drift_ppm, std::int64_t least_samples) {
  Sync();
  std::filesystem::path record;
  {
    const std::lock_guard lock(mutex_);
    if (!run_ || !run_->failure.empty()) throw DataError("the log is not whole");
    record = run_->record;
  }
  calibration::EvenRows clocks;
  clocks.reference_drift_ppm = drift_ppm;
  calibration::Collector collector(calibration::Collector::kNode_s, clocks);
  recording::ReplayRun(record, collector);
  calibration::Recording out = collector.Take();
  if (out.samples < least_samples)
    throw DataError(fmt::format("{}: {} samples were read, and {} had come", record.string(),
                                out.samples, least_samples));
  return out;
}

calibration::AnalysisResult Telemetry::Analyse() const { return ResultOf(TakeSnapshot()); }

calibration::AnalysisResult ResultOf(const Telemetry::Snapshot& snapshot) {
  if (!snapshot) return {};
  try {
    return snapshot->Result();
  } catch (const std::exception& error) {  // too early to say anything, or too odd: the run goes on
    calibration::AnalysisResult nothing;
    nothing.remarks.push_back(error.what());
    return nothing;
  }
}

}  // namespace gyrobench::daemon
