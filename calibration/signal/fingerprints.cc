#include "calibration/signal/fingerprints.h"

#include <algorithm>
#include <bit>
#include <iterator>

namespace gyrobench::calibration {
namespace {

// Odd numbers without a pattern.
constexpr std::uint64_t kBase = 0x9e3779b97f4a7c15, kMix = 0xbf58476d1ce4e5b9;

constexpr std::uint64_t Mixed(std::uint64_t value) {
  value = (value ^ (value >> 30)) * kMix;
  return value ^ (value >> 27);
}

constexpr std::uint64_t PowerOfBase(std::size_t exponent) {
  std::uint64_t power = 1;
  for (std::size_t i = 0; i < exponent; ++i) power *= kBase;
  return power;
}

std::uint64_t NumberOf(const Vector3& output) {
  std::uint64_t number = 0;
  for (const double value : output) number = Mixed(number + std::bit_cast<std::uint64_t>(value));
  return number;
}

}  // namespace

// A polynomial of the samples' numbers, that goes on from sample to sample (Karp and Rabin 1987).
void Fingerprints::Add(const Vector3& output) {
  constexpr std::uint64_t kOldest = PowerOfBase(kSamples);
  constexpr std::size_t kLeastChanges = kSamples / 2;
  const std::size_t place = count_ % kSamples;
  const std::uint64_t number = NumberOf(output);
  const bool changed = count_ > 0 && number != samples_[(count_ - 1) % kSamples];
  hash_ = hash_ * kBase + number - samples_[place] * kOldest;
  changes_ += static_cast<std::size_t>(changed) - static_cast<std::size_t>(changed_[place]);
  samples_[place] = number;
  changed_[place] = changed;
  ++count_;
  if (count_ >= kSamples && changes_ >= kLeastChanges && Mixed(hash_) % kOneOf == 0)
    passages_.push_back(hash_);
}

std::size_t SharedPassages(std::vector<std::uint64_t> one, std::vector<std::uint64_t> other) {
  std::vector<std::uint64_t> shared;
  std::ranges::sort(one);
  std::ranges::sort(other);
  std::ranges::set_intersection(one, other, std::back_inserter(shared));
  return shared.size();
}

}  // namespace gyrobench::calibration
