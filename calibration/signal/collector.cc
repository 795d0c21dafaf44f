#include "calibration/signal/collector.h"

#include <algorithm>
#include <cmath>

#include "calibration/signal/beside_gyro.h"
#include "calibration/signal/gyro_stream.h"
#include "calibration/signal/node_readings.h"
#include "calibration/signal/pending_queue.h"
#include "calibration/signal/reference_track.h"
#include "calibration/signal/rest_finder.h"
#include "calibration/signal/sample_times.h"
#include "calibration/signal/shared_sequence.h"
#include "calibration/signal/turns_by_gyro.h"

namespace gyrobench::calibration {
namespace {

std::array<bool, 3> Known(const std::array<double, 3>& values) {
  return {std::isfinite(values[0]), std::isfinite(values[1]), std::isfinite(values[2])};
}

}  // namespace

class Collector::Impl {
 public:
  SampleTimes times;
  explicit Impl(double node_interval_s) : node_interval_s_(node_interval_s) {}

  void Start(const MeasurementInfo& info) {
    info_ = info;
    gyro_.Start(info);
    track_.Start(info);
    beside_.Start(info.covariates.size());
  }

  void Gyro(const GyroSample& sample) {
    gyro_.Add(sample);
    beside_.Add(sample);
    if (!gyro_.started()) return;
    if (info_.reference == ReferenceKind::kNone) {
      if (gyro_.last_time_s() >= next_node_s_ || done_.empty()) AddNode(gyro_.last_time_s());
    }
    if (!nodes_.empty() || !rests_.empty()) Work();
  }

  void LeaveOut(double begin_s, double end_s) {
    columns_.bad.push_back(BadStretch{begin_s, end_s, {true, true, true}});
  }

  // As the stamp before shows.
  void LeaveOutWhatIsOff(double delay_s, double end_s) {
    const double since_s = times.wrong_since_s() - delay_s;
    if (std::isfinite(since_s)) LeaveOut(since_s, end_s);
  }

  void Covariates(double t_s, std::span<const double> values) {
    beside_.AddCovariates(t_s, values);
  }

  template <typename Sample>
  void Reference(const Sample& sample) {
    track_.Add(sample);
    if (track_.lost_since_s()) {
      LeaveOut(*track_.lost_since_s(), track_.time_s());
      readings_.Clear();
    }
    if (!track_.updated()) return;
    if (const auto since_s = track_.turns_since_s()) {
      nodes_.MarkStale(*since_s, track_.newest_axis());
      readings_.ForgetFrom(*since_s);
    }
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
    const bool same_time = !nodes_.empty() && nodes_.back().node.at.t_s == track_.time_s();
    (same_time ? nodes_.back().readings : readings_)
        .AddOwn(track_.newest_axis(), track_.table_now_deg()[track_.newest_axis()]);
    if (same_time) {
      // Another axis at the same time, as in a row of a table: it may just have begun to move.
      SetReference(&nodes_.back().node);
      nodes_.back().read[track_.newest_axis()] = true;
      nodes_.back().readings.Replace(ReadingOf(nodes_.back().node));
      nodes_.back().moves = !track_.all_rest();
    } else {
      NextReading();
    }
    Work();
  }

  void Tick(const TickPair& pair) {
    if (std::isfinite(pair.tick_s) && std::isfinite(pair.host_s)) ticks_.Add(pair);
  }
  void Defect(const gyrobench::Defect& defect) {
    reported_.Add(defect.kind, defect.where, defect.first_t_s, defect.count);
  }

  void BeginPowerOn() {
    info_.power_on.clear();
    ticks_.BeginAnew();
  }

  Recording Take() const;

 private:
  // The axis that turns fastest says when: its angle is the one that must not be carried forward.
  void NextReading() {
    const double t_s = track_.time_s();
    const bool same_time = !readings_.empty() && readings_.newest_s() == t_s;
    if (!same_time && !track_.leading()) return;
    Node now;
    now.at.t_s = t_s;
    SetReference(&now);
    if (same_time) {
      readings_.Replace(ReadingOf(now));
    } else {
      readings_.Add(ReadingOf(now));
    }
    if ((t_s >= next_node_s_ || !any_node_) && track_.leading()) AddNode(t_s);
  }

  static NodeReadings::Reading ReadingOf(const Node& node) {
    return {node.at.t_s,    node.rotation_deg, node.earth_deg,
            node.table_deg, node.world_x,      node.world_z};
  }

  void AddNode(double t_s) {
    // On a grid, so that jitter of the readings does not thin the nodes.
    if (!any_node_ || t_s - next_node_s_ > node_interval_s_) next_node_s_ = t_s;
    next_node_s_ += node_interval_s_ * 0.999;
    any_node_ = true;
    Pending job;
    job.node.at.t_s = t_s;
    if (info_.reference != ReferenceKind::kNone) SetReference(&job.node);
    job.read[track_.newest_axis()] = true;
    job.readings = readings_;
    job.moves = !track_.all_rest();
    readings_.Clear();
    job.ready_s = t_s + kNear_s.back();
    Queue(&nodes_, job);
  }

  void SetReference(Node* node) const {
    node->rotation_deg = track_.rotation_now_deg();
    node->earth_deg = track_.earth_deg();
    node->table_deg = track_.table_now_deg();
    const Matrix3 world = track_.world_now();
    node->world_x = world[0];
    node->world_z = world[2];
  }

  void Queue(PendingQueue* queue, const Pending& job) {
    if (!queue->push(job)) reported_.Add("reference_without_gyro", "", job.ready_s);
  }

  // Samples may come ahead of the reference: a node waits for all readings of its time, and for
  // those that say whether another axis had begun to turn.
  bool ReferenceComplete(double t_s) const {
    return info_.reference != ReferenceKind::kStandAngles || track_.SettledAt(t_s);
  }

  void Work() {
    const double now_s = gyro_.settled_time_s();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Pending& job = nodes_[i];
      if (!job.averaged && gyro_.started() && job.ready_s <= now_s &&
          (info_.reference != ReferenceKind::kStandAngles || track_.time_s() > job.node.at.t_s))
        Average(&job);
    }
    while (!nodes_.empty() && gyro_.started() && nodes_.front().ready_s <= now_s &&
           gyro_.ring().MeansSettledAt(nodes_.front().node.at.t_s) &&
           ReferenceComplete(nodes_.front().node.at.t_s)) {
      if (!nodes_.front().stale) FinishNode(nodes_.front());
      nodes_.pop();
    }
    while (!rests_.empty() && gyro_.started() && rests_.front().ready_s <= now_s) {
      FinishRest(rests_.front());
      rests_.pop();
    }
  }

  // Means of what was sampled since the node before: whether it is used is known later.
  void Average(Pending* job) {
    job->averaged = true;
    const BesideGyro::Means means = beside_.TakeUpTo(job->node.at.t_s, &job->covariates);
    job->node.temperature_degC = means.temperature_degC;
    job->node.vibration_g2 = means.vibration_g2;
    job->node.accel_g = means.accel_g;
  }

  void FinishNode(const Pending& job) {
    Node node = job.node;
    if (!gyro_.IntegralAt(node.at.t_s, &node.at)) {
      if (node.at.t_s >= gyro_.first_time_s()) reported_.Add("reference_late", "", node.at.t_s);
      return;
    }
    if (!done_.empty() && node.at.t_s <= done_.back().at.t_s) return;
    node.mean = job.readings.Mean();
    node.samples = gyro_.SumUpTo(node.at.t_s);
    node.between = gyro_.ring().BetweenUpTo(node.at.t_s);
    node.as_means = gyro_.ring().AsMeansAt(node.at.t_s);
    node.as_means_later = gyro_.ring().AsMeansHalfAfter(node.at.t_s);
    // At rest an interval without a sample of its own has next to no noise: any column would count.
    if (!job.moves && !done_.empty() && node.samples.t_s <= done_.back().samples.t_s) return;
    HalfIntegral(&node);
    WayIntegrals(&node);
    node.mean.passed_for_rest = !job.moves;
    within_.clear();
    if (!job.readings.AverageOutput(gyro_, &node.mean, &within_) || !job.moves ||
        !job.readings.AverageNear(gyro_, &node.z_near)) {
      NearIntegrals(&node);
      if (job.moves) node.mean.output_known = false;
    }
    if (!job.moves || !node.mean.output_known) within_.clear();
    node.within_begin = static_cast<std::uint32_t>(done_within_.size());
    node.within_count = static_cast<std::uint32_t>(within_.size());
    for (const ReadingWithin& reading : within_) done_within_.push_back(reading);
    for (const double value : job.covariates) columns_.covariates.push_back(value);
    done_.push_back(node);
  }

  void NearIntegrals(Node* node) const {
    IntegralMark mark;
    for (std::size_t i = 0; i < kNear_s.size(); ++i) {
      if (!gyro_.IntegralAt(node->at.t_s + kNear_s[i], &mark)) continue;
      for (std::size_t c = 0; c < 3; ++c) node->z_near[i][c] = mark.z[c] - node->at.z[c];
    }
  }

  void HalfIntegral(Node* node) const {
    IntegralMark mark;
    node->half_s = node->at.t_s;
    if (done_.empty()) {
      node->z_half = node->at.z;
      return;
    }
    const IntegralMark& last = done_.back().at;
    node->half_s = 0.5 * (last.t_s + node->at.t_s);
    if (gyro_.IntegralAt(0.5 * (last.t_s + node->at.t_s), &mark)) {
      node->z_half = mark.z;
      return;
    }
    for (std::size_t c = 0; c < 3; ++c) node->z_half[c] = 0.5 * (last.z[c] + node->at.z[c]);
  }

  void WayIntegrals(Node* node) const {
    node->z_way.fill(node->at.z);
    if (done_.empty()) return;
    const IntegralMark& last = done_.back().at;
    const double step_s = (node->at.t_s - last.t_s) / static_cast<double>(kWaySteps);
    IntegralMark mark;
    for (std::size_t i = 0; i + 1 < kWaySteps; ++i) {
      const double after_s = static_cast<double>(i + 1) * step_s;
      if (gyro_.IntegralAt(last.t_s + after_s, &mark)) {
        node->z_way[i] = mark.z;
        continue;
      }
      const double part = after_s / (node->at.t_s - last.t_s);
      for (std::size_t c = 0; c < 3; ++c)
        node->z_way[i][c] = last.z[c] + part * (node->at.z[c] - last.z[c]);
    }
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
    finished_rests_.push_back(job.rest.Between(rest_begin_, end));
  }

  // The rest that began at rest_begin_, as far as its readings go. The reference may be ahead: the
  // rest that it is in then is a later one.
  const OpenRest* RestSoFar() const {
    if (!rest_begin_known_) return nullptr;
    if (!rests_.empty()) {
      const Pending& next = rests_.front();
      return next.kind == Pending::Kind::kRestEnd ? &next.rest : nullptr;
    }
    return track_.open_rest() ? &*track_.open_rest() : nullptr;
  }

  Columns ColumnsSoFar() const;
  DefectLog Defects() const;

  double node_interval_s_;
  MeasurementInfo info_;
  GyroStream gyro_;
  ReferenceTrack track_;
  TickFit ticks_;
  SharedSequence<Node> done_;
  SharedSequence<ReadingWithin> done_within_;
  std::vector<ReadingWithin> within_;  // of the newest node; emptied for each
  SharedSequence<Rest> finished_rests_;
  Columns columns_;  // without the nodes and rests
  PendingQueue nodes_, rests_;
  NodeReadings readings_;  // since the last node
  bool any_node_ = false, rest_begin_known_ = false;
  double next_node_s_ = 0.0;
  IntegralMark rest_begin_;
  BesideGyro beside_;
  DefectLog reported_;
};

// The columns with the rest that is still going on, and all that must not be used in order.
Columns Collector::Impl::ColumnsSoFar() const {
  Columns columns = columns_;
  columns.nodes = done_.ToVector();
  columns.within = done_within_.ToVector();
  columns.rests = finished_rests_.ToVector();
  const std::vector<BadStretch> bad = gyro_.bad();
  columns.bad.insert(columns.bad.end(), bad.begin(), bad.end());
  std::sort(columns.bad.begin(), columns.bad.end(),
            [](const BadStretch& a, const BadStretch& b) { return a.begin_s < b.begin_s; });
  if (info_.reference == ReferenceKind::kNone) {
    columns.rests = RestsWithoutReference(info_, columns);
    return columns;
  }
  if (const OpenRest* rest = RestSoFar(); rest != nullptr && !columns.nodes.empty()) {
    // The newest reading may already belong to motion.
    const double limit_s = rest->last_at_rest_s - 0.15;
    const auto last = std::find_if(columns.nodes.rbegin(), columns.nodes.rend(),
                                   [&](const Node& node) { return node.at.t_s <= limit_s; });
    if (last != columns.nodes.rend()) columns.rests.push_back(rest->Between(rest_begin_, last->at));
  }
  PartSlowTurns(&columns);
  return columns;
}

DefectLog Collector::Impl::Defects() const {
  DefectLog all = reported_;
  const std::vector<gyrobench::Defect> gyro = gyro_.defects();
  for (const std::vector<gyrobench::Defect>* found : {&gyro, &track_.defects().defects()}) {
    for (const gyrobench::Defect& defect : *found) {
      all.Add(defect.kind, defect.where, defect.first_t_s, defect.count);
    }
  }
  return all;
}

Recording Collector::Impl::Take() const {
  Recording out;
  out.info = info_;
  out.columns = ColumnsSoFar();
  out.ticks = ticks_;
  out.samples = gyro_.samples();
  out.passages = gyro_.fingerprints().passages();
  out.reference_samples = track_.readings();
  out.valid_samples = gyro_.valid_samples();
  out.first_time_s = gyro_.started() ? gyro_.first_time_s() : 0.0;
  out.last_time_s = gyro_.started() ? gyro_.last_time_s() : 0.0;
  out.median_interval_s = gyro_.median_interval_s();
  out.orientation_known = track_.orientation_known();
  for (std::size_t a = 0; a < 3; ++a) {
    out.rounding[a] = gyro_.rounding(a);
    out.reference_step_deg[a] = track_.step_deg(a);
    if (track_.silent(a)) out.info.stand_axis_present[a] = false;
  }
  DefectLog defects = Defects();
  AddTurnsByGyro(info_, track_.read_range_deg(), &out.columns, &defects);
  out.defects = defects.defects();
  return out;
}

Collector::Collector(double node_interval_s, const EvenRows& even)
    : impl_(std::make_unique<Impl>(node_interval_s)), even_(even) {}
Collector::~Collector() = default;
Collector::Collector(const Collector& other)
    : impl_(std::make_unique<Impl>(*other.impl_)),
      even_(other.even_),
      gyro_delay_s_(other.gyro_delay_s_),
      reference_delay_s_(other.reference_delay_s_) {}
Collector::Collector(Collector&&) noexcept = default;
Collector& Collector::operator=(Collector&&) noexcept = default;

// The one place at which stamps are mended and the declared delays are taken off: from here on the
// time of a value is the time that it is of, and no longer that of its stamp.
void Collector::OnInfo(const MeasurementInfo& info) {
  gyro_delay_s_ = info.gyro_delay_s;
  reference_delay_s_ = info.reference_delay_s;
  impl_->times = SampleTimes(even_);
  impl_->Start(info);
}
void Collector::OnGyro(const GyroSample& sample) {
  GyroSample undelayed = sample;
  undelayed.t_s = impl_->times.OfGyro(sample.t_s, Known(sample.xi)) - gyro_delay_s_;
  impl_->LeaveOutWhatIsOff(gyro_delay_s_, undelayed.t_s);
  impl_->Gyro(undelayed);
}
void Collector::OnCovariates(double t_s, std::span<const double> values) {
  impl_->Covariates(impl_->times.OfCovariates(t_s), values);
}
void Collector::OnAngle(const AngleSample& sample) {
  AngleSample undelayed = sample;
  undelayed.t_s = impl_->times.OfReference(static_cast<std::size_t>(sample.axis), sample.t_s,
                                           sample.angle_deg) -
                  reference_delay_s_;
  impl_->LeaveOutWhatIsOff(reference_delay_s_, undelayed.t_s);
  impl_->Reference(undelayed);
}
void Collector::OnOrientation(const OrientationSample& sample) {
  OrientationSample undelayed = sample;
  undelayed.t_s = impl_->times.OfReference(0, sample.t_s, kMissing) - reference_delay_s_;
  impl_->LeaveOutWhatIsOff(reference_delay_s_, undelayed.t_s);
  impl_->Reference(undelayed);
}
void Collector::OnTickPair(const TickPair& pair) { impl_->Tick(pair); }
void Collector::OnSegment(const SegmentMark& /*mark*/) {}
// A unit that restarted in the middle may have switched the sensor off as well: what is measured
// then shares no zero-rate offset with what lies before and after, and its tick counts anew.
void Collector::OnDefect(const Defect& defect) {
  if (defect.kind == kUnitRestarted) {
    impl_->times.BeginAnew(even_);
    impl_->BeginPowerOn();
  }
  impl_->Defect(defect);
}
Recording Collector::Take() const {
  Recording out = impl_->Take();
  out.stamps = impl_->times.GyroSteps();
  out.rows = impl_->times.Rows();
  out.drift_correction = impl_->times.drift_correction();
  const PacketStamps& packets = impl_->times.gyro_packets();
  out.packed_samples = even_.gyro_is_polled ? 0 : packets.on_line();
  out.packed_interval_s = packets.interval_s();
  out.packed_scatter_s = packets.scatter_s();
  return out;
}

}  // namespace gyrobench::calibration
