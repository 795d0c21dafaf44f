#include "drivers/encoder.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "drivers/words.h"

namespace gyrobench::drivers {

Encoder::Encoder(const config::AxisConfig& config, ModbusBus& bus)
    : name_(config.name),
      config_(config.encoder),
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

void Encoder::Open() {
  known_ = false;
  Read();
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

AngleReading Encoder::Read() {
  const config::EncoderMap& map = config_.map;
  std::array<std::uint16_t, 2> words = {};
  const std::span<std::uint16_t> wanted(words.data(), static_cast<std::size_t>(map.words));
  const Timing timing = map.function == 3 ? bus_.ReadHolding(unit_, map.address, wanted, "angle")
                                          : bus_.ReadInput(unit_, map.address, wanted, "angle");
  const std::uint32_t raw =
      map.words == 1 ? words[0] : FromWords(words[0], words[1], map.word_order);
  if (raw >= map.range_counts) {
    throw DeviceError(
        fmt::format(
            "{} ({}, unit {}): angle at 0x{:04X}: expected 0 to {}, found {}. Check range_counts, "
            "words and word order of the map ({}).",
            unit_.name, bus_.description(), unit_.unit, map.address, map.range_counts - 1, raw,
            map.model),
        {.device = unit_.name, .action = "angle", .address = map.address});
  }
  counts_ = known_ ? counts_ + WrappedStep(raw_, raw, map.range_counts) : NearestToZero(raw);
  raw_ = raw;
  known_ = true;
  return {timing.utime_latched, timing.utime_request, timing.utime_reply, counts_,
          AngleDeg(counts_)};
}

}  // namespace gyrobench::drivers
