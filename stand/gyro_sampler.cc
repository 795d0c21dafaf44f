#include "stand/gyro_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrobench::stand {
namespace {

std::int16_t Quantise(double lsb) {
  constexpr double kLow = std::numeric_limits<std::int16_t>::min();
  constexpr double kHigh = std::numeric_limits<std::int16_t>::max();
  return static_cast<std::int16_t>(std::floor(std::clamp(lsb, kLow, kHigh) + 0.5));
}

std::size_t Index(int setting) { return static_cast<std::size_t>(setting); }

}  // namespace

GyroSampler::GyroSampler(const config::Scenario& specimen, const config::GyroUnitMap& map,
                         std::uint64_t seed, const Geometry& geometry, const Faults& faults)
    : specimen_(specimen),
      map_(map),
      faults_(faults),
      step_s_(1e-3 / (1.0 + specimen.gyro.sample_clock_rel)),
      period_s_(step_s_),
      geometry_(geometry),
      thermal_(specimen.thermal, specimen.room),
      model_(specimen.gyro),
      noise_(specimen.gyro, seed),
      accelerometer_(specimen.accelerometer, seed),
      thermometer_(seed, Source::kThermometer),
      jitter_(seed, Source::kTickJitter),
      loss_(seed, Source::kLostSample),
      clock_(specimen.unit, map.tick_rate_hz),
      has_extra_lag_(specimen.gyro.extra_lag_s > 0.0),
      boot_count_(specimen.unit.boot_count) {
  clock_.Advance(0.0, thermal_.package_degC());
  Configure();
  next_s_ = period_s_;
}

void GyroSampler::Configure() {
  const config::GyroScenario& gyro = specimen_.gyro;
  period_s_ = step_s_ * (1 + settings_.divider);
  lsb_per_deg_s_ = map_.gyro_lsb_per_deg_s[Index(settings_.range)];
  lsb_per_g_ = map_.accel_lsb_per_g[Index(settings_.accel_range)];
  filter_.Configure(map_.filter_bandwidth_hz[Index(settings_.filter)],
                    map_.filter_delay_s[Index(settings_.filter)] * (1.0 + gyro.filter_delay_rel),
                    step_s_);
  if (has_extra_lag_) extra_lag_.ConfigureLag(gyro.extra_lag_s, step_s_);
  rest_steps_ = 1 + settings_.divider;
  rest_fraction_ = filter_.Fraction(rest_steps_);
}

void GyroSampler::Set(double t_s, const GyroSettings& settings) {
  settings_ = settings;
  Configure();
  held_ = 0;
  next_s_ = t_s + period_s_;
}

void GyroSampler::Reboot(double t_s) {
  const double up_s = t_s + specimen_.unit.boot_time_s;
  ++boot_count_;
  settings_ = GyroSettings{};
  Configure();
  clock_.Restart(up_s);
  next_number_ = held_ = samples_lost_ = 0;
  next_s_ = up_s + period_s_;
}

void GyroSampler::CatchUp(double t_s, const std::array<AxisMechanics, 3>& axes) {
  // A sample is in the ring when its time stamp has been taken.
  const double ready_s = t_s - specimen_.unit.tick_jitter_s;
  for (; next_s_ <= ready_s; next_s_ += period_s_) Take(axes);
}

void GyroSampler::Take(const std::array<AxisMechanics, 3>& axes) {
  Follow(next_s_ - filter_.pure_delay_s(), axes);
  thermal_.SetHotter(faults_.Acting("gyro", Faults::Kind::kOverheating, next_s_).value_or(0.0));
  thermal_.Advance(next_s_);
  clock_.Advance(next_s_, thermal_.package_degC());
  std::array<std::int16_t, 7> words = Convert(axes);
  const double p_lost = specimen_.unit.lost_sample_probability;
  if (p_lost > 0.0 && loss_.Uniform() < p_lost) {
    ++samples_lost_;
    return;
  }
  Spoil(words);
  Store(words);
}

// What the unit's own faults make of a sample.
void GyroSampler::Spoil(std::array<std::int16_t, 7>& words) const {
  const auto acting = [this](Faults::Kind kind) { return faults_.Acting("gyro", kind, next_s_); };
  const auto jump_deg_s = acting(Faults::Kind::kJump);
  const auto sign = acting(Faults::Kind::kSaturation);
  const double end = sign && *sign < 0 ? std::numeric_limits<std::int16_t>::min()
                                       : std::numeric_limits<std::int16_t>::max();
  for (std::size_t i = 4; i < words.size(); ++i) {
    if (jump_deg_s) words[i] = Quantise(words[i] + *jump_deg_s * lsb_per_deg_s_);
    if (sign) words[i] = Quantise(end);
  }
  if (held_ > 0 && acting(Faults::Kind::kFrozen)) words = sample(next_number_ - 1).words;
}

void GyroSampler::Store(const std::array<std::int16_t, 7>& words) {
  const double stamp_s = next_s_ + specimen_.unit.tick_jitter_s * jitter_.Uniform();
  ring_[next_number_ % kCapacity] = {.tick = clock_.TickAt(stamp_s), .words = words};
  ++next_number_;
  held_ = std::min<std::uint32_t>(held_ + 1, kCapacity);
}

void GyroSampler::FilterStep(const Triple& rate_deg_s) {
  if (!has_extra_lag_) {
    filter_.Step(rate_deg_s);
    return;
  }
  extra_lag_.Step(rate_deg_s);
  filter_.Step(extra_lag_.value());
}

// The truth up to `truth_s` through the filter.
void GyroSampler::Follow(double truth_s, const std::array<AxisMechanics, 3>& axes) {
  const int steps = static_cast<int>(std::lround((truth_s - truth_s_) / step_s_));
  if (angles_known_ && steps < 1) return;
  const bool rests =
      std::ranges::all_of(axes, [this](const auto& axis) { return axis.RestsFrom(truth_s_); });
  if (!angles_known_ || !rests) {
    FollowMotion((truth_s - truth_s_) / std::max(steps, 1), steps, axes);
  } else if (has_extra_lag_) {
    for (int i = 0; i < steps; ++i) FilterStep(rest_rate_deg_s_);
  } else {
    filter_.Step(rest_rate_deg_s_, steps == rest_steps_ ? rest_fraction_ : filter_.Fraction(steps));
  }
  truth_s_ = truth_s;
}

void GyroSampler::FollowMotion(double step_s, int steps, const std::array<AxisMechanics, 3>& axes) {
  if (!angles_known_) {
    for (std::size_t i = 0; i < 3; ++i) angles_deg_[i] = axes[i].TableAngle(truth_s_);
    geometry_.SetAngles(angles_deg_);
    rest_rate_deg_s_ = geometry_.EarthRate();
    angles_known_ = true;
  }
  std::array<bool, 3> rests;
  for (std::size_t i = 0; i < 3; ++i) rests[i] = axes[i].RestsFrom(truth_s_);
  for (int k = 1; k <= steps; ++k) {
    const double t_s = truth_s_ + k * step_s;
    Triple rate = {};
    Triple middle = angles_deg_;
    for (std::size_t i = 0; i < 3; ++i) {
      if (rests[i]) continue;
      const double angle = axes[i].TableAngle(t_s);
      rate[i] = (angle - angles_deg_[i]) / step_s;
      middle[i] = 0.5 * (angle + angles_deg_[i]);
      angles_deg_[i] = angle;
    }
    geometry_.SetAngles(middle);
    Triple felt = geometry_.Rate(rate);
    // The Earth's rate turns too slowly in S for a sample to show it: the last one's will do.
    for (std::size_t i = 0; i < 3; ++i) felt[i] += rest_rate_deg_s_[i];
    FilterStep(felt);
  }
  geometry_.SetAngles(angles_deg_);
  gravity_g_ = geometry_.Gravity();
  rest_rate_deg_s_ = geometry_.EarthRate();
}

std::array<std::int16_t, 7> GyroSampler::Convert(const std::array<AxisMechanics, 3>& axes) {
  GyroInput input{.rate_deg_s = filter_.value(),
                  .g = gravity_g_,
                  .t_s = next_s_,
                  .die_degC = thermal_.die_degC(),
                  .die_rate_degC_s = thermal_.die_rate_degC_s()};
  for (const AxisMechanics& axis : axes) input.vibration_g2 += axis.Vibration(truth_s_);
  const Triple rate = model_.Output(input);
  const Triple noise = noise_.Next(period_s_);
  const Triple force = accelerometer_.Output(gravity_g_, thermal_.die_degC(), period_s_);
  const double degC =
      thermal_.Reading_degC() + specimen_.thermal.thermometer_noise_degC * thermometer_.Normal();

  std::array<std::int16_t, 7> words;
  for (std::size_t i = 0; i < 3; ++i) {
    words[i] = Quantise(force[i] * lsb_per_g_);
    words[4 + i] = Quantise((rate[i] + noise[i]) * lsb_per_deg_s_);
  }
  words[3] = Quantise((degC - map_.temperature_offset_degC) * map_.temperature_lsb_per_degC);
  return words;
}

}  // namespace gyrobench::stand
