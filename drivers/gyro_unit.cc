#include "drivers/gyro_unit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/error.h"
#include "config/words.h"

namespace gyrobench::drivers {
namespace {

constexpr double kFitMemory_s = 60.0;
constexpr double kCountersPeriod_s = 5.0;
constexpr int kStaleTries = 3;
constexpr Utime kTickMustMove_us = 10'000;
constexpr std::uint16_t kDeltaOverflow = 0xFFFF;
constexpr double kTickWrap = 4294967296.0;

std::uint16_t IndexOf(double value, const std::vector<double>& choices, const char* key) {
  const auto found = std::find(choices.begin(), choices.end(), value);
  if (found == choices.end()) {
    throw ConfigError(
        fmt::format("gyro.{} = {}: the device map has {}", key, value, fmt::join(choices, ", ")));
  }
  return static_cast<std::uint16_t>(found - choices.begin());
}

std::uint16_t Divider(double rate_hz) {
  const double divider = std::round(1000.0 / rate_hz - 1.0);
  if (!(divider >= 0 && divider <= 255) || std::fabs(1000.0 / (1.0 + divider) - rate_hz) > 1e-3) {
    throw ConfigError(
        fmt::format("gyro.rate_hz = {}: expected 1000 / (1 + d) for a whole d of 0 to 255 "
                    "(1000, 500, 333.333, 250, 200, ...)",
                    rate_hz));
  }
  return static_cast<std::uint16_t>(divider);
}

std::array<std::uint16_t, 4> Settings(const config::GyroConfig& config) {
  const auto filters = static_cast<int>(config.map.filter_delay_s.size());
  if (config.filter < 0 || config.filter >= filters) {
    throw ConfigError(
        fmt::format("gyro.filter = {}: the device map has 0 to {}", config.filter, filters - 1));
  }
  return {IndexOf(config.range_deg_s, config.map.gyro_range_deg_s, "range_deg_s"),
          static_cast<std::uint16_t>(config.filter), Divider(config.rate_hz),
          IndexOf(config.accel_range_g, config.map.accel_range_g, "accel_range_g")};
}

constexpr std::array<const char*, 4> kSettingNames = {"gyro range", "filter", "rate divider",
                                                      "accelerometer range"};

}  // namespace

GyroUnit::GyroUnit(const config::GyroConfig& config, ModbusBus& bus)
    : config_(config),
      map_(config_.map),
      unit_{"gyro", config.unit},
      bus_(bus),
      settings_(Settings(config)),
      fit_(kFitMemory_s) {
  const int words = map_.block_header_words + map_.sample_words * map_.max_samples_per_block;
  if (map_.block_header_words < 8 || map_.sample_words < 8 || map_.max_samples_per_block < 1 ||
      words > static_cast<int>(kMostWords)) {
    throw ConfigError(fmt::format(
        "gyro map {}: {} + {} x {} words a block: expected at least 8 + 8 x 1 and at most {} words",
        map_.model, map_.block_header_words, map_.sample_words, map_.max_samples_per_block,
        kMostWords));
  }
  if (map_.gyro_lsb_per_deg_s.size() != map_.gyro_range_deg_s.size() ||
      map_.accel_lsb_per_g.size() != map_.accel_range_g.size() ||
      map_.filter_bandwidth_hz.size() != map_.filter_delay_s.size() || map_.block_span == 0 ||
      !(map_.tick_rate_hz > 0)) {
    throw ConfigError(
        fmt::format("gyro map {}: each range needs its sensitivity, each filter its bandwidth "
                    "and delay, and tick_rate_hz and block_span be above 0",
                    map_.model));
  }
}

// The device's name is added to `fields`.
void GyroUnit::Fail(const std::string& text, DeviceFailure fields) const {
  fields.device = unit_.name;
  throw DeviceError(
      fmt::format("{} ({}, unit {}): {}", unit_.name, bus_.description(), unit_.unit, text),
      fields);
}

GyroIdentity GyroUnit::Open() {
  if (begun_)
    left_off_ =
        Place{identity_.serial_number, identity_.boot_count, static_cast<std::uint32_t>(wanted_)};
  begun_ = false;
  Identify();
  ApplySettings();
  Begin();
  CountWhatPassed();
  return identity_;
}

// Of a unit that was opened again without having started anew: its numbers went on.
void GyroUnit::CountWhatPassed() {
  if (left_off_ && left_off_->serial_number == identity_.serial_number &&
      left_off_->boot_count == identity_.boot_count) {
    const std::int64_t passed =
        config::WrappedStep32(left_off_->wanted, static_cast<std::uint32_t>(next_));
    missed_meanwhile_ += std::max<std::int64_t>(passed, 0);
  }
  left_off_.reset();
}

void GyroUnit::Identify() {
  std::array<std::uint16_t, 11> words = {};
  bus_.ReadInput(unit_, map_.identity_address, words, "identity");
  CheckIdentity(words);
  identity_.protocol_version = words[1];
  identity_.firmware = fmt::format("{}.{}", words[2] >> 8, words[2] & 0xFF);
  identity_.serial_number = config::FromWords(words[3], words[4]);
  identity_.boot_count = words[5];
  identity_.tick_rate_hz = config::FromWords(words[7], words[8]);
  rate_before_hz_ = words[9];
  identity_.sample_rate_hz = 1000.0 / (1 + settings_[2]);
  identity_.gyro_lsb_per_deg_s = map_.gyro_lsb_per_deg_s[settings_[0]];
  identity_.accel_lsb_per_g = map_.accel_lsb_per_g[settings_[3]];
  identity_.filter_bandwidth_hz = map_.filter_bandwidth_hz[settings_[1]];
  identity_.filter_delay_s = map_.filter_delay_s[settings_[1]];
  capacity_ = words[10];
}

void GyroUnit::CheckIdentity(const std::array<std::uint16_t, 11>& words) const {
  const auto expect = [&](const char* what, int offset, std::uint32_t expected, std::uint32_t found,
                          const char* advice) {
    if (expected == found) return;
    Fail(fmt::format("{} at 0x{:04X}: expected {} (0x{:X}), found {} (0x{:X}). {}", what,
                     map_.identity_address + offset, expected, expected, found, found, advice),
         {.action = what, .address = map_.identity_address + offset});
  };
  expect("identity", 0, map_.magic, words[0],
         "This unit number is not a gyro unit's: check gyro.bus and gyro.unit.");
  expect("protocol version", 1, static_cast<std::uint32_t>(map_.protocol_version), words[1],
         "Load the firmware that belongs to this version of gyrobench.");
  expect("WHO_AM_I of the sensor", 6, static_cast<std::uint32_t>(map_.who_am_i), words[6],
         "Check the sensor's supply and its I2C lines, or the map's who_am_i.");
  expect("ticks per second", 7, static_cast<std::uint32_t>(std::lround(map_.tick_rate_hz)),
         config::FromWords(words[7], words[8]), "Correct tick_rate_hz in the map.");
  if (config_.serial_number) {
    expect("serial number", 3, *config_.serial_number, config::FromWords(words[3], words[4]),
           "Another unit is connected: connect the configured one or correct gyro.serial_number.");
  }
}

void GyroUnit::ApplySettings() {
  std::array<std::uint16_t, 4> found = {};
  bus_.ReadHolding(unit_, map_.settings_address, found, "settings");
  if (found == settings_) return;
  for (std::size_t i = 0; i < settings_.size(); ++i) {
    if (found[i] == settings_[i]) continue;
    bus_.WriteRegister(unit_, static_cast<std::uint16_t>(map_.settings_address + i), settings_[i],
                       kSettingNames[i]);
  }
  bus_.ReadHolding(unit_, map_.settings_address, found, "settings");
  for (std::size_t i = 0; i < settings_.size(); ++i) {
    if (found[i] == settings_[i]) continue;
    Fail(
        fmt::format("{} at 0x{:04X} was set to {} and reads back {}. Check the firmware's version.",
                    kSettingNames[i], map_.settings_address + i, settings_[i], found[i]),
        {.action = kSettingNames[i], .address = map_.settings_address + static_cast<int>(i)});
  }
}

void GyroUnit::Begin() {
  Timing timing;
  const Head head = Request(0, timing);
  identity_.boot_count = head.boot;
  tick_ = tick0_ = head.tick;
  next_ = wanted_ = head.next;
  utime_ = utime0_ = timing.utime_latched;
  boot_utime_ = BootTime();
  // A sample that is being taken now has its tick already, but not its number.
  last_sample_tick_ = tick_ - static_cast<std::int64_t>(map_.tick_rate_hz);
  fit_ = TickFit(kFitMemory_s);
  begun_ = true;
  Advance(head, timing);
  ReadCounters();
}

// Tick and sample number as the unit has them now, and the rate that was in force until now.
std::optional<Utime> GyroUnit::BootTime() const {
  const auto up_s = SecondsSinceBoot(static_cast<double>(tick_) / map_.tick_rate_hz,
                                     kTickWrap / map_.tick_rate_hz, next_, rate_before_hz_);
  return up_s ? std::optional(utime_ - FromSeconds(*up_s)) : std::nullopt;
}

// Sample number wanted_ is the first asked for.
GyroUnit::Head GyroUnit::Request(std::size_t samples, Timing& timing) {
  const auto address = static_cast<std::uint16_t>(map_.block_address + wanted_ % map_.block_span);
  const std::size_t words = static_cast<std::size_t>(map_.block_header_words) +
                            static_cast<std::size_t>(map_.sample_words) * samples;
  timing = bus_.ReadInput(unit_, address, std::span(words_).first(words), "samples");
  return {config::FromWords(words_[0], words_[1]), config::FromWords(words_[2], words_[3]),
          words_[4], words_[5], config::FromWords(words_[6], words_[7])};
}

// A frame of an earlier request can pass all checks of Modbus RTU. It cannot pass these: tick and
// sample number never go back, the tick moves with time, and a block never begins before the sample
// asked for.
bool GyroUnit::IsStale(const Head& head, const Timing& timing) const {
  if (head.boot != identity_.boot_count) return false;
  const auto next = static_cast<std::uint32_t>(next_);
  const auto tick = static_cast<std::uint32_t>(tick_);
  if (config::WrappedStep32(tick, head.tick) < 0 || config::WrappedStep32(next, head.next) < 0)
    return true;
  if (tick == head.tick && timing.utime_latched - utime_ > kTickMustMove_us) return true;
  const auto wanted = static_cast<std::uint32_t>(wanted_);
  const std::uint32_t first = head.next - static_cast<std::uint16_t>(head.next - head.first);
  return head.next != wanted && config::WrappedStep32(wanted, first) < 0;
}

GyroUnit::Head GyroUnit::RequestFresh(Timing& timing) {
  Head head;
  for (int tries = 0; tries < kStaleTries; ++tries) {
    head = Request(static_cast<std::size_t>(map_.max_samples_per_block), timing);
    if (!IsStale(head, timing)) return head;
    bus_.InvalidateReply();
    if (bus_.hurries()) break;
  }
  Fail(
      fmt::format(
          "samples: expected tick and sample number to grow from {} and {} and a block from sample "
          "{} on; found {}, {} and a block from {} (low 16 bits) with the same boot counter {} ({} "
          "tries). Check for a second unit of the same number on the bus; otherwise restart the "
          "unit.",
          tick_, next_, wanted_, head.tick, head.next, head.first, head.boot, kStaleTries),
      {.action = "samples", .address = map_.block_address});
}

void GyroUnit::Advance(const Head& head, const Timing& timing) {
  tick_ += config::WrappedStep32(static_cast<std::uint32_t>(tick_), head.tick);
  next_ += config::WrappedStep32(static_cast<std::uint32_t>(next_), head.next);
  utime_ = timing.utime_latched;
  // After a retry the reply may belong to an earlier try, and its time is not known.
  if (timing.tries > 1 && fit_.count() > 0) return;
  fit_.Add({static_cast<double>(tick_ - tick0_) / map_.tick_rate_hz, ToSeconds(utime_ - utime0_)});
}

Utime GyroUnit::HostTime(std::int64_t tick) const {
  return utime0_ +
         FromSeconds(fit_.HostTime(static_cast<double>(tick - tick0_) / map_.tick_rate_hz));
}

void GyroUnit::Read(GyroBlock& block) {
  block.samples.clear();
  block.missed = 0;
  if (!begun_)
    Fail("is not open, or its last Open failed. Open it (again).", {.action = "samples"});
  Timing timing;
  Head head = RequestFresh(timing);
  if (head.boot != identity_.boot_count) {
    StartAnew(block);
    return;
  }
  Advance(head, timing);
  Take(head, block);
  const std::int64_t newest = next_;
  // What was taken is published, whatever happens to the requests that follow: if the trouble
  // lasts, the next read says so.
  try {
    for (int more = 0; wanted_ < newest && more <= capacity_ && !bus_.hurries(); ++more) {
      head = RequestFresh(timing);
      if (head.boot != identity_.boot_count) break;  // the next read begins anew
      Advance(head, timing);
      Take(head, block);
    }
    if (tick_ >= counters_due_tick_) ReadCounters();
  } catch (const DeviceError&) {
    if (block.samples.empty()) throw;
  }
  Publish(block);
}

void GyroUnit::StartAnew(GyroBlock& block) {
  Open();
  Publish(block);
}

void GyroUnit::Publish(GyroBlock& block) {
  block.missed += std::exchange(missed_meanwhile_, 0);
  block.utime = utime_;
  block.tick = tick_;
  block.boot_count = identity_.boot_count;
  block.boot_utime = boot_utime_;
  block.samples_lost = counters_[0];
  block.sensor_bus_errors = counters_[1];
  block.frames_rejected = counters_[2];
}

// Appends the samples of the reply in words_, of which `head` is the head.
void GyroUnit::Take(const Head& head, GyroBlock& block) {
  if (next_ == wanted_) return;
  std::int64_t number = next_ - static_cast<std::uint16_t>(head.next - head.first);
  block.missed += number - wanted_;
  std::int64_t tick = tick_ - static_cast<std::int64_t>(head.tick - head.first_tick);
  const std::int64_t count = std::min<std::int64_t>(map_.max_samples_per_block, next_ - number);
  for (std::int64_t i = 0; i < count; ++i, ++number) {
    const auto word = static_cast<std::size_t>(map_.block_header_words + i * map_.sample_words);
    // Too far from the one before for its tick to be known: asked for again, as the first of a
    // block.
    if (i > 0 && words_[word] == kDeltaOverflow) break;
    if (i > 0) tick += words_[word];
    if (tick <= last_sample_tick_ || tick > tick_) {
      Fail(fmt::format("samples: sample {} has tick {}, expected above {} (the sample before) and "
                       "at most {} "
                       "(the unit's tick at the read). Check the firmware's version.",
                       number, tick, last_sample_tick_, tick_),
           {.action = "samples", .address = map_.block_address});
    }
    Append(number, tick, word, block);
  }
  wanted_ = number;
}

void GyroUnit::Append(std::int64_t number, std::int64_t tick, std::size_t word, GyroBlock& block) {
  const auto value = [&](std::size_t i) { return static_cast<std::int16_t>(words_[word + i]); };
  GyroRawSample sample;
  sample.counter = number;
  sample.tick = tick;
  // The line moves a little with each pair; time must not go back for that.
  sample.utime = std::max(HostTime(tick), last_sample_utime_ + 1);
  sample.accel_lsb = {value(1), value(2), value(3)};
  sample.temperature_degC = value(4) / map_.temperature_lsb_per_degC + map_.temperature_offset_degC;
  sample.gyro_lsb = {value(5), value(6), value(7)};
  block.samples.push_back(sample);
  last_sample_tick_ = tick;
  last_sample_utime_ = sample.utime;
}

void GyroUnit::ReadCounters() {
  std::array<std::uint16_t, 6> words = {};
  bus_.ReadInput(unit_, map_.counters_address, words, "counters");
  for (std::size_t i = 0; i < counters_.size(); ++i) {
    counters_[i] = config::FromWords(words[2 * i], words[2 * i + 1]);
  }
  counters_due_tick_ = tick_ + static_cast<std::int64_t>(kCountersPeriod_s * map_.tick_rate_hz);
}

namespace {

// A sensor's own clock, which paces its samples, is off by this at most; and some get lost.
constexpr double kRateTolerance = 0.03;
// A unit does not sample from its first moment.
constexpr double kStart_s = 2.0;

}  // namespace

std::optional<double> SecondsSinceBoot(double tick_s, double tick_wrap_s,
                                       std::int64_t samples_since_boot, double sample_rate_hz) {
  if (!(sample_rate_hz > 0.0) || !(tick_wrap_s > 0.0)) return std::nullopt;
  const double sampled_s = static_cast<double>(samples_since_boot) / sample_rate_hz;
  const double wraps = std::max(0.0, std::round((sampled_s - tick_s) / tick_wrap_s));
  const double up_s = tick_s + wraps * tick_wrap_s;
  const double tolerance_s = kStart_s + kRateTolerance * up_s;
  if (std::fabs(sampled_s - up_s) > tolerance_s || tolerance_s > 0.5 * tick_wrap_s)
    return std::nullopt;
  return up_s;
}

}  // namespace gyrobench::drivers
