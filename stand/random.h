// Random numbers of the virtual stand. Every source of noise has a stream of its own, so that what
// one source draws depends on the seed alone and not on what else is simulated or who asks when.
#pragma once

#include <boost/random/normal_distribution.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace gyrobench::stand {

// SplitMix64 (Steele, Lea, Flood 2014): a counter put through a mixing function.
constexpr std::uint64_t Mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

class SplitMix64 {
 public:
  using result_type = std::uint64_t;
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
  result_type operator()() { return Mix(state_ += 0x9e3779b97f4a7c15ULL); }

 private:
  std::uint64_t state_;
};

// The sources. A new source goes at the end: the others then keep their numbers.
enum class Source : std::uint64_t {
  kSpecimen,
  kGyroWhite,
  kGyroBiasWalk,
  kGyroFlicker,
  kGyroTail,
  kAccelerometer,
  kThermometer,
  kTickJitter,
  kLostSample,
  kEncoder,
  kGarbage,
  kFault,
};

constexpr std::uint64_t SourceSeed(std::uint64_t seed, Source source, std::uint64_t index = 0) {
  return Mix(Mix(seed + 0x9e3779b97f4a7c15ULL) ^
             Mix((static_cast<std::uint64_t>(source) << 32U) + index + 1));
}

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, Source source, std::uint64_t index = 0)
      : engine_(SourceSeed(seed, source, index)) {}
  double Normal() { return normal_(engine_); }
  double Uniform() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }  // [0, 1)
  std::uint64_t Bits() { return engine_(); }

 private:
  SplitMix64 engine_;
  boost::random::normal_distribution<double> normal_;
};

// The normal number that belongs to `index`, in any order of asking (Box and Muller).
inline double NormalAt(std::uint64_t source_seed, std::uint64_t index) {
  SplitMix64 engine(source_seed ^ Mix(index + 1));
  const double u = (static_cast<double>(engine() >> 11U) + 0.5) * 0x1p-53;
  const double v = static_cast<double>(engine() >> 11U) * 0x1p-53;
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

}  // namespace gyrobench::stand
