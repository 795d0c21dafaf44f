// By what two recordings of the same samples are known, wherever each begins.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/geometry.h"

namespace gyrobench::calibration {

// Keeps a number of some passages of a gyro's output, of kSamples samples each, chosen by what they
// hold alone: whoever meets the same samples chooses the same ones. About one passage in kOneOf is
// kept, and none of an output that hardly changes, as of a sensor that is off.
class Fingerprints {
 public:
  static constexpr std::size_t kSamples = 32, kOneOf = 128;

  // The next sample, as it came.
  void Add(const Vector3& output);
  const std::vector<std::uint64_t>& passages() const { return passages_; }

 private:
  std::array<std::uint64_t, kSamples> samples_ = {};
  std::array<bool, kSamples> changed_ = {};
  std::uint64_t hash_ = 0;  // of these, oldest first
  std::size_t count_ = 0, changes_ = 0;
  std::vector<std::uint64_t> passages_;
};

// How many passages are in both; a noisy sensor makes none twice.
std::size_t SharedPassages(std::vector<std::uint64_t> one, std::vector<std::uint64_t> other);

}  // namespace gyrobench::calibration
