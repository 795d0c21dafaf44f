#include "calibration/analyzer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/tick_fit.h"
#include "calibration/bias.h"
#include "calibration/columns.h"
#include "calibration/gyro_stream.h"
#include "calibration/reference_track.h"
#include "calibration/scale.h"
#include "calibration/schedule.h"

namespace gyrobench::calibration {
namespace {

// Mean of what came since the last node; values that are not a number do not count.
struct RunningMean {
  double sum = 0.0;
  std::int64_t n = 0;
  void Add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    ++n;
  }
  double Take() {
    const double mean = n > 0 ? sum / static_cast<double>(n) : kMissing;
    sum = 0.0;
    n = 0;
    return mean;
  }
};

// What waits for the gyro's samples to reach its time.
struct Pending {
  enum class Kind { kNode, kRestBegin, kRestEnd };
  Kind kind = Kind::kNode;
  double ready_s = 0.0;  // when the gyro has come so far, it can be done
  Node node;             // kNode
  double coarse_s = 0.0, moving_s = 0.0;
  OpenRest rest;  // kRestEnd
};

// Waiting jobs, in order. Bounded: a gyro that stays away cannot fill the memory.
class PendingQueue {
 public:
  bool empty() const { return size_ == 0; }
  const Pending& front() const { return jobs_[head_]; }
  void pop() {
    head_ = (head_ + 1) % kCapacity;
    --size_;
  }
  bool push(const Pending& job) {
    if (size_ == kCapacity) return false;
    jobs_[(head_ + size_) % kCapacity] = job;
    ++size_;
    return true;
  }

 private:
  static constexpr std::size_t kCapacity = 256;
  std::vector<Pending> jobs_ = std::vector<Pending>(kCapacity);
  std::size_t head_ = 0, size_ = 0;
};

Rest MakeRest(const IntegralMark& begin, const IntegralMark& end, const OpenRest& readings) {
  Rest rest;
  rest.begin = begin;
  rest.end = end;
  rest.readings = readings.readings;
  const double n = std::max<double>(1.0, static_cast<double>(readings.readings));
  for (std::size_t c = 0; c < 3; ++c) {
    const double mean = readings.sum_deg[c] / n;
    rest.rotation_deg[c] = readings.origin_deg[c] + mean;
    const double variance = std::max(0.0, readings.square_deg2[c] / n - mean * mean);
    rest.scatter_deg = std::max(rest.scatter_deg, std::sqrt(variance));
  }
  return rest;
}

}  // namespace

class Analyzer::Impl {
 public:
  explicit Impl(const AnalyzerOptions& options) : options_(options) {}

  void Start(const MeasurementInfo& info) {
    info_ = info;
    gyro_.Start(info);
    track_.Start(info);
    columns_.nodes.reserve(4096);
    columns_.rests.reserve(256);
  }

  void Gyro(const GyroSample& sample) {
    gyro_.Add(sample);
    temperature_.Add(sample.temperature_degC);
    for (std::size_t c = 0; c < 3; ++c) accel_[c].Add(sample.accel_g[c]);
    if (!gyro_.started()) return;
    if (info_.reference == ReferenceKind::kNone) {
      if (gyro_.last_time_s() >= next_node_s_ || columns_.nodes.empty())
        AddNode(gyro_.last_time_s(), {}, {});
    }
    if (!nodes_.empty() || !rests_.empty()) Work();
  }

  template <typename Sample>
  void Reference(const Sample& sample) {
    track_.Add(sample);
    if (track_.lost_since_s()) {
      columns_.bad.push_back(
          BadStretch{*track_.lost_since_s(), track_.time_s(), {true, true, true}});
    }
    if (!track_.updated()) return;
    if (track_.rest_ended()) {
      const OpenRest& rest = track_.ended_rest();
      Pending job;
      job.kind = Pending::Kind::kRestEnd;
      job.coarse_s = rest.last_at_rest_s;
      job.moving_s = track_.lost_since_s() ? rest.last_at_rest_s : track_.time_s();
      job.ready_s = job.moving_s + 0.1;
      job.rest = rest;
      Queue(&rests_, job);
    }
    if (track_.rest_began()) {
      Pending job;
      job.kind = Pending::Kind::kRestBegin;
      job.coarse_s = track_.open_rest()->coarse_begin_s;
      job.ready_s = job.coarse_s + 0.45;
      Queue(&rests_, job);
    }
    if (track_.time_s() >= next_node_s_ || !any_node_) {
      AddNode(track_.time_s(), track_.rotation_deg(), track_.earth_deg());
    }
    Work();
  }

  void Tick(const TickPair& pair) {
    if (std::isfinite(pair.tick_s) && std::isfinite(pair.host_s)) ticks_.Add(pair);
  }
  void Defect(const gyrobench::Defect& defect) {
    reported_.Add(defect.kind, defect.where, defect.first_t_s, defect.count);
  }

  AnalysisResult Result() const;

 private:
  void AddNode(double t_s, const Vector3& rotation_deg, const Vector3& earth_deg) {
    // On a grid, so that jitter of the readings does not thin the nodes.
    if (!any_node_ || t_s - next_node_s_ > options_.node_interval_s) next_node_s_ = t_s;
    next_node_s_ += options_.node_interval_s * 0.999;
    any_node_ = true;
    Pending job;
    job.node.at.t_s = t_s;
    job.node.rotation_deg = rotation_deg;
    job.node.earth_deg = earth_deg;
    job.ready_s = t_s;
    Queue(&nodes_, job);
  }

  void Queue(PendingQueue* queue, const Pending& job) {
    if (!queue->push(job)) reported_.Add("reference_without_gyro", "", job.ready_s);
  }

  void Work() {
    const double now_s = gyro_.last_time_s();
    while (!nodes_.empty() && gyro_.started() && nodes_.front().ready_s <= now_s) {
      FinishNode(nodes_.front().node);
      nodes_.pop();
    }
    while (!rests_.empty() && gyro_.started() && rests_.front().ready_s <= now_s) {
      FinishRest(rests_.front());
      rests_.pop();
    }
  }

  void FinishNode(Node node) {
    if (!gyro_.IntegralAt(node.at.t_s, &node.at)) {
      if (node.at.t_s >= gyro_.first_time_s()) reported_.Add("reference_late", "", node.at.t_s);
      return;
    }
    if (!columns_.nodes.empty() && node.at.t_s <= columns_.nodes.back().at.t_s) return;
    node.temperature_degC = temperature_.Take();
    for (std::size_t c = 0; c < 3; ++c) node.accel_g[c] = accel_[c].Take();
    columns_.nodes.push_back(node);
  }

  void FinishRest(const Pending& job) {
    if (job.kind == Pending::Kind::kRestBegin) {
      const double t_s = std::max(gyro_.RestBegin(job.coarse_s), gyro_.first_time_s());
      rest_begin_known_ = gyro_.IntegralAt(t_s, &rest_begin_);
      return;
    }
    if (!rest_begin_known_) return;
    rest_begin_known_ = false;
    IntegralMark end;
    if (!gyro_.IntegralAt(gyro_.RestEnd(job.coarse_s, job.moving_s), &end)) return;
    if (end.t_s - rest_begin_.t_s < kShortestRest_s) return;
    columns_.rests.push_back(MakeRest(rest_begin_, end, job.rest));
  }

  Columns ColumnsSoFar() const;
  void CollectDefects(AnalysisResult* result) const;

  static constexpr double kShortestRest_s = 0.25;

  AnalyzerOptions options_;
  MeasurementInfo info_;
  GyroStream gyro_;
  ReferenceTrack track_;
  TickFit ticks_;
  Columns columns_;
  PendingQueue nodes_, rests_;
  bool any_node_ = false, rest_begin_known_ = false;
  double next_node_s_ = 0.0;
  IntegralMark rest_begin_;
  RunningMean temperature_;
  std::array<RunningMean, 3> accel_;
  DefectLog reported_;
};

// The columns with the rest that is still going on, and all that must not be used in order.
Columns Analyzer::Impl::ColumnsSoFar() const {
  Columns columns = columns_;
  columns.bad.insert(columns.bad.end(), gyro_.bad().begin(), gyro_.bad().end());
  std::sort(columns.bad.begin(), columns.bad.end(),
            [](const BadStretch& a, const BadStretch& b) { return a.begin_s < b.begin_s; });
  if (info_.reference == ReferenceKind::kNone) {
    columns.rests = RestsWithoutReference(info_, columns);
    return columns;
  }
  if (rest_begin_known_ && track_.open_rest() && !columns.nodes.empty()) {
    // The newest reading may already belong to motion.
    const double limit_s = track_.open_rest()->last_at_rest_s - 0.15;
    const auto last = std::find_if(columns.nodes.rbegin(), columns.nodes.rend(),
                                   [&](const Node& node) { return node.at.t_s <= limit_s; });
    if (last != columns.nodes.rend() && last->at.t_s - rest_begin_.t_s >= kShortestRest_s) {
      columns.rests.push_back(MakeRest(rest_begin_, last->at, *track_.open_rest()));
    }
  }
  return columns;
}

void Analyzer::Impl::CollectDefects(AnalysisResult* result) const {
  DefectLog all = reported_;
  for (const DefectLog* log : {&gyro_.defects(), &track_.defects()}) {
    for (const gyrobench::Defect& defect : log->defects()) {
      all.Add(defect.kind, defect.where, defect.first_t_s, defect.count);
    }
  }
  result->defects = all.defects();
}

AnalysisResult Analyzer::Impl::Result() const {
  AnalysisResult result;
  result.info = info_;
  result.samples = gyro_.samples();
  result.reference_samples = track_.readings();
  CollectDefects(&result);
  const std::string source = info_.source.empty() ? "measurement" : info_.source;
  if (gyro_.samples() == 0) {
    throw DataError(
        fmt::format("{}: no gyro sample; expected a measurement with at least one axis", source));
  }
  bool any = false;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!info_.gyro_present[c]) continue;
    any = any || gyro_.valid_samples()[c] > 1;
    if (gyro_.valid_samples()[c] <= 1) {
      result.remarks.push_back(
          fmt::format("gyro {}: no usable sample (of {})", "xyz"[c], gyro_.samples()));
    }
  }
  if (!any) {
    throw DataError(fmt::format(
        "{}: none of the {} gyro samples has a finite time and value; nothing can be estimated",
        source, gyro_.samples()));
  }
  result.duration_s = gyro_.last_time_s() - gyro_.first_time_s();
  result.gyro_rate_hz = 1.0 / gyro_.median_interval_s();
  const Columns columns = ColumnsSoFar();
  Estimation estimation{info_, options_, columns, ticks_, track_.orientation_known(), {}};
  for (std::size_t c = 0; c < 3; ++c) {
    estimation.usable[c] = info_.gyro_present[c] && gyro_.valid_samples()[c] > 1;
  }
  RemarkOnReference(estimation, &result.remarks);
  result.scale = EstimateScale(estimation, &result.remarks);
  result.bias = EstimateBias(estimation, result.scale, &result.remarks);
  return result;
}

Analyzer::Analyzer(const AnalyzerOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Analyzer::~Analyzer() = default;
Analyzer::Analyzer(const Analyzer& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
Analyzer::Analyzer(Analyzer&&) noexcept = default;
Analyzer& Analyzer::operator=(Analyzer&&) noexcept = default;

void Analyzer::OnInfo(const MeasurementInfo& info) { impl_->Start(info); }
void Analyzer::OnGyro(const GyroSample& sample) { impl_->Gyro(sample); }
void Analyzer::OnAngle(const AngleSample& sample) { impl_->Reference(sample); }
void Analyzer::OnOrientation(const OrientationSample& sample) { impl_->Reference(sample); }
void Analyzer::OnTickPair(const TickPair& pair) { impl_->Tick(pair); }
void Analyzer::OnSegment(const SegmentMark& /*mark*/) {}
void Analyzer::OnDefect(const Defect& defect) { impl_->Defect(defect); }
AnalysisResult Analyzer::Result() const { return impl_->Result(); }

}  // namespace gyrobench::calibration
