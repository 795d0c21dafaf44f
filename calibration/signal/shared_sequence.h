// A sequence that only grows, and whose copies cost next to nothing.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace gyrobench::calibration {

// Copies share every full chunk, which never changes again: a copy takes the time and the memory of
// one chunk, however long the sequence is, and may be read in another thread while the original
// grows.
template <typename T>
class SharedSequence {
 public:
  bool empty() const { return full_.empty() && last_.empty(); }
  std::size_t size() const { return full_.size() * kChunk + last_.size(); }
  const T& back() const { return last_.empty() ? full_.back()->back() : last_.back(); }

  void push_back(const T& value) {
    if (last_.capacity() < kChunk) last_.reserve(kChunk);
    last_.push_back(value);
    if (last_.size() < kChunk) return;
    full_.push_back(std::make_shared<const std::vector<T>>(std::move(last_)));
    last_ = {};
  }

  std::vector<T> ToVector() const {
    std::vector<T> out;
    out.reserve(size());
    for (const auto& chunk : full_) out.insert(out.end(), chunk->begin(), chunk->end());
    out.insert(out.end(), last_.begin(), last_.end());
    return out;
  }

 private:
  static constexpr std::size_t kChunk = 1024;
  std::vector<std::shared_ptr<const std::vector<T>>> full_;
  std::vector<T> last_;
};

}  // namespace gyrobench::calibration
