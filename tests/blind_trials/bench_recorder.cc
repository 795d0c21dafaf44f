#include "tests/blind_trials/bench_recorder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "stand/bench_physics.h"
#include "stand/random.h"

namespace gyrobench::blind_trials {
namespace {

constexpr Utime kStart = 1'700'000'000'000'000;
constexpr stand::GyroSettings kSettings = {.range = 0, .filter = 0, .divider = 9, .accel_range = 0};
constexpr double kSamplePeriod_s = 0.01;
constexpr int kReadingsPerTickPair = 10;

Utime At(double t_s) { return kStart + FromSeconds(t_s); }

// A laboratory supply: wanders within some 0.1 V of 5 V over half a minute and longer.
class Supply {
 public:
  explicit Supply(std::uint64_t seed) : random_(seed) {}
  double Next(double dt_s) {
    for (std::size_t i = 0; i < kTau_s.size(); ++i) {
      const double decay = std::exp(-dt_s / kTau_s[i]);
      state_[i] = decay * state_[i] + kSigma_v * std::sqrt(1.0 - decay * decay) * normal_(random_);
    }
    return 5.0 + state_[0] + state_[1];
  }

 private:
  static constexpr std::array<double, 2> kTau_s = {30.0, 200.0};
  static constexpr double kSigma_v = 0.07;
  stand::SplitMix64 random_;
  boost::random::normal_distribution<double> normal_;
  std::array<double, 2> state_ = {};
};

}  // namespace

class BenchRecorder::Impl {
 public:
  Impl(const config::StandConfig& stand, const config::Scenario& specimen, std::uint64_t seed,
       const RecorderOptions& options, MeasurementSink& sink)
      : stand_(stand),
        options_(options),
        sink_(sink),
        physics_(stand, specimen, seed, kStart),
        supply_(stand::Mix(seed ^ 0x5057'5259ULL)),
        rounding_(seed, stand::Source::kGarbage) {
    physics_.WithGyro(kStart, [](auto& gyro, double t_s) { gyro.Set(t_s, kSettings); });
    for (const config::AxisConfig& axis : stand.axes) {
      axes_[stand::AxisIndex(axis.name)] = &axis;
    }
    sink_.OnInfo(Info());
  }

  void Add(const Turn& turn) { turns_.push_back(turn); }
  void Add(const SegmentMark& segment) { segments_.push_back(segment); }
  void SetFan(bool blows) { physics_.SetFan(At(now_s_), blows); }

  void RunTo(double end_s) {
    const auto last = static_cast<std::int64_t>(std::floor(end_s * options_.reference_rate_hz));
    for (; next_reading_ <= last; ++next_reading_) {
      const std::int64_t k = next_reading_;
      const double t_s = static_cast<double>(k) / options_.reference_rate_hz;
      now_s_ = t_s;
      StartTurns(t_s);
      TakeSamples(t_s);
      for (std::size_t axis = 0; axis < 3; ++axis) ReadAngle(axis, t_s);
      if (k % kReadingsPerTickPair == 0) sink_.OnTickPair({t_s, t_s});
      while (next_segment_ < segments_.size() && segments_[next_segment_].end_s <= t_s)
        sink_.OnSegment(segments_[next_segment_++]);
    }
  }

 private:
  MeasurementInfo Info() const {
    MeasurementInfo info;
    info.source = options_.source;
    info.gyro_present = options_.channels;
    info.accel_present = {true, true, true};
    info.temperature_present = true;
    info.gyro_units_per_deg_s = stand_.gyro.map.gyro_lsb_per_deg_s[0];
    info.reference = ReferenceKind::kStandAngles;
    info.stand_axis_present = {true, true, true};
    info.geometry = options_.geometry;
    if (options_.latitude_known) info.site_latitude_deg = stand_.site.latitude_deg;
    info.site_heading_deg = stand_.site.heading_deg;
    info.gear_ratio = axes_[2]->gear_ratio;
    info.stop_accuracy_deg = axes_[2]->shaft_accuracy_deg / axes_[2]->gear_ratio;
    info.power_on = options_.source;
    if (options_.supply) info.covariates = {"supply_v"};
    return info;
  }

  void StartTurns(double until_s) {
    for (; next_turn_ < turns_.size() && turns_[next_turn_].start_s <= until_s; ++next_turn_) {
      const Turn& turn = turns_[next_turn_];
      const config::AxisConfig& axis = *axes_[turn.axis];
      TakeSamples(turn.start_s);
      const double rpm_per_deg_s = axis.gear_ratio / 6.0;
      const double ramp_ms = 1e6 / (turn.acceleration_deg_s2 * rpm_per_deg_s);
      const double pulses = turn.target_deg / 360.0 * axis.gear_ratio *
                            static_cast<double>(axis.drive.map.pulses_per_turn);
      physics_.MoveTo(turn.axis, At(turn.start_s),
                      {.target = std::llround(pulses),
                       .rpm = turn.rate_deg_s * rpm_per_deg_s,
                       .ramp_up_ms = ramp_ms,
                       .ramp_down_ms = ramp_ms});
    }
  }

  // The unit's ring holds more than what comes between two readings.
  void TakeSamples(double until_s) {
    physics_.WithGyro(At(until_s), [this](stand::GyroSampler& gyro, double) {
      for (; next_sample_ < gyro.next_number(); ++next_sample_)
        pending_[pending_count_++] = gyro.sample(next_sample_);
      die_degC_ = gyro.thermal().die_degC();
    });
    for (std::size_t i = 0; i < pending_count_; ++i) Send(pending_[i]);
    pending_count_ = 0;
  }

  void Send(const stand::RawSample& raw) {
    const config::GyroUnitMap& map = stand_.gyro.map;
    const double true_s = raw.tick / map.tick_rate_hz;
    GyroSample sample;
    // Whole microseconds, as records have them.
    sample.t_s = std::round(true_s * (1.0 + options_.gyro_clock_rel) * 1e6) * 1e-6;
    for (std::size_t i = 0; i < 3; ++i) {
      sample.accel_g[i] = raw.words[i] / map.accel_lsb_per_g[0];
      if (options_.channels[i]) sample.xi[i] = raw.words[4 + i];
    }
    sample.temperature_degC =
        raw.words[3] / map.temperature_lsb_per_degC + map.temperature_offset_degC;
    if (options_.supply || options_.extra_z_deg_s) AddExtras(true_s, sample);
    sink_.OnGyro(sample);
  }

  void AddExtras(double true_s, GyroSample& sample) {
    SampleTruth truth;
    truth.t_s = true_s;
    truth.die_degC = die_degC_;
    if (options_.supply) {
      truth.supply_v = supply_.Next(kSamplePeriod_s);
      sink_.OnCovariates(sample.t_s, std::span(&truth.supply_v, 1));
    }
    if (!options_.extra_z_deg_s) return;
    SetMotion(true_s, truth);
    const double lsb = options_.extra_z_deg_s(truth) * stand_.gyro.map.gyro_lsb_per_deg_s[0];
    // The counts are whole already: rounded at random, or less than half of one would be lost.
    sample.xi[2] = std::floor(sample.xi[2] + lsb + rounding_.Uniform());
  }

  // Geometry of the stand: R_WS = Rz(outer) Rx(middle) Rz(inner).
  void SetMotion(double true_s, SampleTruth& truth) {
    constexpr double kRad = std::numbers::pi / 180.0;
    const stand::AxisTruth outer = physics_.Truth(0, At(true_s));
    const stand::AxisTruth middle = physics_.Truth(1, At(true_s));
    const stand::AxisTruth inner = physics_.Truth(2, At(true_s));
    const double m = middle.table_deg * kRad, i = inner.table_deg * kRad;
    truth.g = {std::sin(m) * std::sin(i), std::sin(m) * std::cos(i), std::cos(m)};
    truth.rate_z_deg_s = inner.rate_deg_s + outer.rate_deg_s * std::cos(m);
  }

  void ReadAngle(std::size_t axis, double t_s) {
    const config::EncoderConfig& encoder = axes_[axis]->encoder;
    const auto range = static_cast<std::int64_t>(encoder.map.range_counts);
    const std::int64_t raw = physics_.EncoderCounts(axis, At(t_s));
    // The nearest to the reading before; the first is the nearest to zero.
    const std::int64_t step = (raw - counts_[axis]) % range;
    counts_[axis] += step > range / 2 ? step - range : step < -range / 2 ? step + range : step;
    const double angle_deg =
        encoder.sign * static_cast<double>(counts_[axis]) * 360.0 / encoder.map.counts_per_turn +
        encoder.offset_deg;
    sink_.OnAngle({t_s, static_cast<int>(axis), angle_deg});
  }

  const config::StandConfig& stand_;
  const RecorderOptions& options_;
  MeasurementSink& sink_;
  stand::Physics physics_;
  Supply supply_;
  stand::RandomStream rounding_;
  std::array<const config::AxisConfig*, 3> axes_ = {};
  std::array<std::int64_t, 3> counts_ = {};
  std::array<stand::RawSample, stand::GyroSampler::kCapacity> pending_;
  std::size_t pending_count_ = 0;
  std::uint32_t next_sample_ = 0;
  std::vector<Turn> turns_;
  std::vector<SegmentMark> segments_;
  std::size_t next_turn_ = 0, next_segment_ = 0;
  std::int64_t next_reading_ = 0;
  double now_s_ = 0.0;
  double die_degC_ = 25.0;
};

BenchRecorder::BenchRecorder(const config::StandConfig& stand, const config::Scenario& specimen,
                             std::uint64_t noise_seed, const RecorderOptions& options,
                             MeasurementSink& sink)
    : impl_(std::make_unique<Impl>(stand, specimen, noise_seed, options, sink)) {}
BenchRecorder::~BenchRecorder() = default;
void BenchRecorder::Add(const Turn& turn) { impl_->Add(turn); }
void BenchRecorder::Add(const SegmentMark& segment) { impl_->Add(segment); }
void BenchRecorder::SetFan(bool blows) { impl_->SetFan(blows); }
void BenchRecorder::RunTo(double t_s) { impl_->RunTo(t_s); }

void Record(const config::StandConfig& stand, config::Scenario specimen, const Sequence& sequence,
            std::uint64_t noise_seed, const RecorderOptions& options, MeasurementSink& sink) {
  specimen.room.fans = sequence.fans;
  BenchRecorder recorder(stand, specimen, noise_seed, options, sink);
  for (const Turn& turn : sequence.turns) recorder.Add(turn);
  for (const SegmentMark& segment : sequence.segments) recorder.Add(segment);
  recorder.RunTo(sequence.duration_s);
}

}  // namespace gyrobench::blind_trials
