#include "tests/firmware/emulation/reading.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "tests/firmware/emulation/emulated_unit.h"
#include "tests/firmware/emulation/unit_master.h"

namespace gyrobench::firmware {
namespace {

constexpr int kMostSamples = 14, kHead = 8, kSampleWords = 8;
constexpr double kTickRate_hz = 250000.0;
constexpr double kStart_s = 0.3;

// A number of 30 bits in two values, and what depends on it in the others.
VirtualMpu6050::Words WordsOf(std::int64_t number) {
  const auto low = static_cast<std::int16_t>(number & 0x7FFF);
  return {low,   static_cast<std::int16_t>(number >> 15), static_cast<std::int16_t>(-low),
          1234,  static_cast<std::int16_t>(low ^ 0x5555), static_cast<std::int16_t>(-low - 1),
          -32768};
}

std::uint32_t Long(const std::vector<std::uint16_t>& words, std::size_t at) {
  return static_cast<std::uint32_t>(words[at]) << 16 | words[at + 1];
}

class Reader {
 public:
  Reader(const std::filesystem::path& image, const Reading& reading)
      : reading_(reading),
        sensor_(
            [this](double t_s, const VirtualMpu6050::Settings&) {
              ready_s_.push_back(t_s);
              return WordsOf(static_cast<std::int64_t>(ready_s_.size()) - 1);
            },
            reading.sensor_clock_rel),
        unit_(image, sensor_, reading.resonator_rel),
        master_(unit_, reading.baud),
        random_(reading.seed) {}

  ReadingCounts Run() {
    Begin();
    const std::vector<double> resets = Moments(reading_.resets), stuck = Moments(reading_.stuck);
    std::size_t reset = 0, held = 0;
    const double begin_s = unit_.now_s();
    while (unit_.now_s() < begin_s + reading_.duration_s) {
      const double since_s = unit_.now_s() - begin_s;
      if (reset < resets.size() && since_s > resets[reset]) {
        ++reset;
        unit_.Reset();
      }
      if (held < stuck.size() && since_s > stuck[held]) {
        ++held;
        unit_.HoldSda(5);
        gap_allowed_ = true;
      }
      Poll();
      unit_.RunUntil(unit_.now_s() + reading_.poll_s);
    }
    Finish();
    return counts_;
  }

 private:
  std::vector<double> Moments(int count) {
    std::vector<double> out;
    for (int i = 0; i < count; ++i)
      out.push_back((i + std::uniform_real_distribution(0.2, 0.8)(random_)) * reading_.duration_s /
                    count);
    return out;
  }

  // The line's rate and the settings.
  void Begin() {
    unit_.RunUntil(kStart_s);
    if (reading_.baud != 115200) {
      UnitMaster before(unit_);
      const std::vector<std::uint16_t> line = {21, static_cast<std::uint16_t>(reading_.baud / 100),
                                               0, 0, 0x4742};
      if (!before.WriteMany(0x0110, line)) throw std::runtime_error("the line was not set");
      // 9 bytes of the EEPROM.
      unit_.RunUntil(unit_.now_s() + 0.05);
    }
    Configure();
  }

  void Configure() {
    const std::vector<std::uint16_t> settings = {0, static_cast<std::uint16_t>(reading_.filter),
                                                 static_cast<std::uint16_t>(reading_.divider), 0};
    for (int tries = 0; tries < 20; ++tries) {
      if (master_.WriteMany(0x0100, settings)) {
        unit_.RunUntil(unit_.now_s() + 0.05);
        const auto reply = master_.Read(4, 0x4000, kHead);
        if (!reply) continue;
        wanted_ = Long(reply->words, 2);
        boot_ = reply->words[4];
        last_.reset();
        return;
      }
      unit_.RunUntil(unit_.now_s() + 0.02);
    }
    throw std::runtime_error("the unit does not answer");
  }

  Damage Draw() {
    if (std::uniform_real_distribution(0.0, 1.0)(random_) >= reading_.damaged) return Damage::kNone;
    constexpr std::array kAll = {Damage::kRequestFlipped, Damage::kRequestCut,
                                 Damage::kRequestParted, Damage::kReplyFlipped, Damage::kReplyLost};
    return kAll[std::uniform_int_distribution<std::size_t>(0, kAll.size() - 1)(random_)];
  }

  void Poll() {
    for (int more = 0; more < 8; ++more) {
      ++counts_.requests;
      const auto reply = master_.Read(4, 0x4000 + static_cast<int>(wanted_ % 0x4000),
                                      kHead + kSampleWords * kMostSamples, Draw());
      if (!reply) {
        ++counts_.unanswered;
        if (++silent_ > 20) throw std::runtime_error("the unit does not answer any more");
        continue;
      }
      silent_ = 0;
      if (reply->words[4] != boot_) {
        ++counts_.restarts_seen;
        NoteCounters();
        unit_.RunUntil(unit_.now_s() + kStart_s);
        Configure();
        return;
      }
      Take(reply->words);
      ticks_.push_back({Long(reply->words, 0), master_.request_complete_s()});
      if (Long(reply->words, 2) == wanted_) return;
    }
  }

  void Take(const std::vector<std::uint16_t>& words) {
    const std::uint32_t next = Long(words, 2);
    std::uint32_t number = next - static_cast<std::uint16_t>(next - words[5]);
    std::uint32_t tick = Long(words, 6);
    for (int i = 0; i < kMostSamples && number != next; ++i, ++number) {
      const std::size_t at = kHead + static_cast<std::size_t>(i) * kSampleWords;
      tick += words[at];
      Judge({words.begin() + static_cast<std::ptrdiff_t>(at) + 1,
             words.begin() + static_cast<std::ptrdiff_t>(at) + kSampleWords},
            tick);
    }
    wanted_ = number;
  }

  void Judge(const std::vector<std::uint16_t>& values, std::uint32_t tick) {
    ++counts_.taken;
    const std::int64_t made = static_cast<std::int64_t>(values[1]) << 15 | values[0];
    const VirtualMpu6050::Words expected = WordsOf(made);
    bool same = made < static_cast<std::int64_t>(ready_s_.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      same = same && static_cast<std::int16_t>(values[i]) == expected[i];
    if (!same) {
      ++counts_.wrong;
      return;
    }
    const int every = reading_.filter == 0 ? 1 + reading_.divider : 1;
    if (last_) {
      const std::int64_t step = made - last_->made;
      if (step <= 0) ++counts_.repeated;
      if (step > every && !gap_allowed_) counts_.missing += step / every - 1;
      if (step > every) gap_allowed_ = false;
      const double passed_s = ready_s_[static_cast<std::size_t>(made)] -
                              ready_s_[static_cast<std::size_t>(last_->made)];
      const double ticks = passed_s * kTickRate_hz * (1.0 + reading_.resonator_rel);
      if (std::fabs(static_cast<double>(tick - last_->tick) - ticks) > 5.0) ++counts_.late;
    }
    last_ = {made, tick};
  }

  void NoteCounters() {
    const auto reply = master_.Read(4, 0x0010, 6);
    if (!reply) return;
    counts_.told_lost += Long(reply->words, 0);
    counts_.sensor_errors += Long(reply->words, 2);
    counts_.frames_rejected += Long(reply->words, 4);
  }

  void Finish() {
    NoteCounters();
    counts_.stack_left = unit_.StackLeft();
    if (ticks_.size() < 2 || reading_.resets > 0) return;
    const double ticks = static_cast<double>(ticks_.back().tick - ticks_.front().tick);
    const double passed_s = ticks_.back().at_s - ticks_.front().at_s;
    counts_.tick_rate_rel = ticks / (passed_s * kTickRate_hz) - 1.0;
  }

  struct Sample {
    std::int64_t made = 0;
    std::uint32_t tick = 0;
  };
  struct TickAt {
    std::uint32_t tick = 0;
    double at_s = 0.0;
  };

  const Reading reading_;
  std::vector<double> ready_s_;
  VirtualMpu6050 sensor_;
  EmulatedUnit unit_;
  UnitMaster master_;
  std::mt19937_64 random_;
  ReadingCounts counts_;
  std::uint32_t wanted_ = 0;
  std::uint16_t boot_ = 0;
  std::optional<Sample> last_;
  std::vector<TickAt> ticks_;
  bool gap_allowed_ = false;
  int silent_ = 0;
};

}  // namespace

ReadingCounts ReadFor(const std::filesystem::path& image, const Reading& reading) {
  return Reader(image, reading).Run();
}

}  // namespace gyrobench::firmware
