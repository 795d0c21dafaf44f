#include "drivers/encoder.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "config/words.h"

namespace gyrobench::drivers {
namespace {

// Beyond what the axis can do by this, for play, noise and times that are not exact.
constexpr double kJumpMargin_deg = 5.0;
constexpr double kRateMargin = 2.0;
constexpr int kReadsOfADoubt = 3;
// Longer than a disturbance of the line, shorter than the silence that is a fault.
constexpr Utime kBelievedAfter = 3 * kMicrosecondsPerSecond / 10;

}  // namespace

Encoder::Encoder(const config::AxisConfig& config, ModbusBus& bus)
    : name_(config.name),
      config_(config.encoder),
      max_rate_deg_s_(config.max_rate_deg_s),
      span_deg_(config.max_deg - config.min_deg),
      unit_{"axis." + config.name + " encoder", config.encoder.unit},
      bus_(bus) {
  const config::EncoderMap& map = config_.map;
  if ((map.words != 1 && map.words != 2) || (map.function != 3 && map.function != 4)) {
    throw ConfigError(
        fmt::format("{}: words = {}, function = {}: expected 1 or 2 words and function 3 or 4",
                    unit_.name, map.words, map.function));
  }
  const std::uint64_t most = std::uint64_t{1} << (16 * map.words);
  if (map.range_counts < 2 || map.range_counts > most || !(map.counts_per_turn > 0)) {
    throw ConfigError(fmt::format(
        "{}: range_counts = {}, counts_per_turn = {}: expected a range of 2 to {} (what {} "
        "register(s) hold) and counts per turn above 0",
        unit_.name, map.range_counts, map.counts_per_turn, most, map.words));
  }
}

AngleReading Encoder::Open() {
  known_ = false;
  doubted_.reset();
  return Read();
}

double Encoder::AngleDeg(std::int64_t counts) const {
  return config_.sign * static_cast<double>(counts) * 360.0 / config_.map.counts_per_turn +
         config_.offset_deg;
}

std::int64_t Encoder::NearestToZero(std::uint32_t raw) const {
  const double range_deg =
      static_cast<double>(config_.map.range_counts) * 360.0 / config_.map.counts_per_turn;
  const auto ranges =
      static_cast<std::int64_t>(std::round(AngleDeg(raw) / range_deg)) * config_.sign;
  return raw - ranges * static_cast<std::int64_t>(config_.map.range_counts);
}

Timing Encoder::ReadWords(std::array<std::uint16_t, 2>& words) {
  const config::EncoderMap& map = config_.map;
  const std::span<std::uint16_t> wanted(words.data(), static_cast<std::size_t>(map.words));
  return map.function == 3 ? bus_.ReadHolding(unit_, map.address, wanted, "angle")
                           : bus_.ReadInput(unit_, map.address, wanted, "angle");
}

RawAngle Encoder::ReadRaw() {
  RawAngle raw;
  raw.utime = ReadWords(raw.words).utime_latched;
  return raw;
}

Encoder::Value Encoder::ReadValue() {
  const config::EncoderMap& map = config_.map;
  std::array<std::uint16_t, 2> words = {};
  Value value;
  value.timing = ReadWords(words);
  value.raw = map.words == 1 ? words[0] : config::FromWords(words[0], words[1], map.word_order);
  if (value.raw < map.range_counts) return value;
  throw NoAnswer(
      fmt::format("{} ({}, unit {}): angle at 0x{:04X}: expected 0 to {}, found {}. Check "
                  "range_counts, words and word order of the map ({}).",
                  unit_.name, bus_.description(), unit_.unit, map.address, map.range_counts - 1,
                  value.raw, map.model),
      {.device = unit_.name, .action = "angle", .address = map.address});
}

std::int64_t Encoder::Step(const Value& before, const Value& now) const {
  return config::WrappedStep(before.raw, now.raw, config_.map.range_counts);
}

bool Encoder::CanFollow(const Value& before, const Value& now) const {
  const double step_deg =
      static_cast<double>(Step(before, now)) * 360.0 / config_.map.counts_per_turn;
  const double time_s = ToSeconds(now.timing.utime_latched - before.timing.utime_latched);
  return std::fabs(step_deg) <= kJumpMargin_deg + kRateMargin * max_rate_deg_s_ * time_s;
}

bool Encoder::BelieveAfterAll(const Value& value) {
  const Utime now = value.timing.utime_latched;
  if (!doubted_ || !CanFollow(*doubted_, value)) doubted_since_ = now;
  doubted_ = value;
  return now - doubted_since_ >= kBelievedAfter;
}

AngleReading Encoder::Accept(const Value& value, std::int64_t counts) {
  counts_ = counts;
  last_ = value;
  known_ = true;
  doubted_.reset();
  return {value.timing.utime_latched, value.timing.utime_request, value.timing.utime_reply, counts_,
          AngleDeg(counts_)};
}

void Encoder::Doubt(const Value& value) const {
  const std::int64_t counts = counts_ + Step(last_, value);
  throw NoAnswer(
      fmt::format("{} ({}, unit {}): the angle jumps from {:.3f} to {:.3f} deg within {:.3f} s, "
                  "faster than the axis can turn: not used. Look for lost steps, a slip of the "
                  "coupling, a disturbed line or a failing sensor, and check max_rate_deg_s of the "
                  "axis.",
                  unit_.name, bus_.description(), unit_.unit, AngleDeg(counts_), AngleDeg(counts),
                  ToSeconds(value.timing.utime_latched - last_.timing.utime_latched)),
      {.device = unit_.name, .action = "angle", .address = config_.map.address});
}

AngleReading Encoder::Read() {
  for (int reads = 1;; ++reads) {
    const Value value = ReadValue();
    if (!known_) return Accept(value, NearestToZero(value.raw));
    if (CanFollow(last_, value)) return Accept(value, counts_ + Step(last_, value));
    if (BelieveAfterAll(value)) {
      const double range_deg =
          static_cast<double>(config_.map.range_counts) * 360.0 / config_.map.counts_per_turn;
      return Accept(
          value, range_deg >= span_deg_ ? NearestToZero(value.raw) : counts_ + Step(last_, value));
    }
    if (reads == kReadsOfADoubt || bus_.hurries()) Doubt(value);
  }
}

}  // namespace gyrobench::drivers
