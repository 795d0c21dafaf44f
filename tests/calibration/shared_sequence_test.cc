#include "calibration/signal/shared_sequence.h"

#include <gtest/gtest.h>

#include <numeric>

namespace gyrobench::testing {
namespace {

using Sequence = calibration::SharedSequence<int>;

// Several chunks and a part of one.
constexpr int kMany = 5000;

Sequence Counted(int end) {
  Sequence sequence;
  for (int i = 0; i < end; ++i) sequence.push_back(i);
  return sequence;
}

std::vector<int> Range(int end) {
  std::vector<int> range(static_cast<std::size_t>(end));
  std::iota(range.begin(), range.end(), 0);
  return range;
}

TEST(SharedSequence, IsWhatAVectorWouldBe) {
  for (const int end : {0, 1, 1023, 1024, 1025, 2048, kMany}) {
    const Sequence sequence = Counted(end);
    EXPECT_EQ(sequence.ToVector(), Range(end));
    EXPECT_EQ(sequence.size(), static_cast<std::size_t>(end));
    EXPECT_EQ(sequence.empty(), end == 0);
    if (end > 0) {
      EXPECT_EQ(sequence.back(), end - 1);
    }
  }
}

TEST(SharedSequence, DoesNotChangeWithItsCopies) {
  Sequence original = Counted(kMany);
  Sequence copy = original;
  for (int i = 0; i < kMany; ++i) original.push_back(-1);
  EXPECT_EQ(copy.ToVector(), Range(kMany));
  copy.push_back(kMany);
  EXPECT_EQ(copy.ToVector(), Range(kMany + 1));
  EXPECT_EQ(original.back(), -1);
  EXPECT_EQ(original.size(), 2u * kMany);
}

// Of what is copied: counted where it happens.
struct Counting {
  static inline int copies = 0;
  Counting() = default;
  Counting(const Counting&) { ++copies; }
  Counting& operator=(const Counting&) = default;
};

TEST(SharedSequence, CopiesNoMoreThanOneChunkHoweverLongItIs) {
  for (const int length : {2000, 20'000, 200'000}) {
    calibration::SharedSequence<Counting> sequence;
    for (int i = 0; i < length; ++i) sequence.push_back({});
    Counting::copies = 0;
    const calibration::SharedSequence<Counting> copy = sequence;
    EXPECT_LE(Counting::copies, 1024);
    EXPECT_EQ(copy.size(), sequence.size());
  }
}

}  // namespace
}  // namespace gyrobench::testing
