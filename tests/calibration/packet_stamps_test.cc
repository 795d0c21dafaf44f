#include "calibration/signal/packet_stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace gyrobench::calibration {
namespace {

struct Sample {
  double t_s, stamp_s;
};

// A host that gets what an adapter has every `packet_s`, and reads it a row after the other.
class Host {
 public:
  explicit Host(double packet_s) : packet_s_(packet_s) {}

  double StampOf(double t_s) {
    constexpr double kRow_s = 5e-5;
    const double packet_s = (std::floor(t_s / packet_s_) + 1.0) * packet_s_;
    return last_s_ = std::max({packet_s, busy_until_s, last_s_ + kRow_s});
  }
  double busy_until_s = 0.0;

 private:
  double packet_s_, last_s_ = -1.0;
};

std::vector<Sample> Sampled(double rate_hz, double packet_s, double length_s) {
  std::vector<Sample> samples;
  Host host(packet_s);
  for (double i = 0.0; i / rate_hz < length_s; ++i)
    samples.push_back({i / rate_hz, host.StampOf(i / rate_hz)});
  return samples;
}

// Errors of the mended times from `from_s` on, less their median: the mean delay is not known.
std::vector<double> Errors(const std::vector<Sample>& samples, double from_s) {
  PacketStamps packets;
  std::vector<double> errors_s;
  for (const Sample& sample : samples) {
    const double mended_s = packets.Mend(sample.stamp_s);
    if (sample.t_s >= from_s) errors_s.push_back(mended_s - sample.t_s);
  }
  std::vector<double> sorted = errors_s;
  std::ranges::sort(sorted);
  for (double& error : errors_s) error -= sorted[sorted.size() / 2];
  return errors_s;
}

double Rms(const std::vector<double>& errors) {
  double sum = 0.0;
  for (const double error : errors) sum += error * error;
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

double Largest(const std::vector<double>& errors) {
  double largest = 0.0;
  for (const double error : errors) largest = std::max(largest, std::fabs(error));
  return largest;
}

TEST(PacketStamps, AnEvenClockIsFoundBehindPackets) {
  for (const double packet_s : {0.016, 0.008}) {
    for (const double rate_hz : {95.3, 200.0, 333.0, 1000.0}) {
      if (rate_hz * packet_s < 1.2) continue;  // one by one
      const std::vector<Sample> samples = Sampled(rate_hz, packet_s, 300.0);
      EXPECT_LT(Rms(Errors(samples, 20.0)), 1.5e-4) << rate_hz << " Hz, " << packet_s << " s";
      PacketStamps packets;
      for (const Sample& sample : samples) packets.Mend(sample.stamp_s);
      EXPECT_TRUE(packets.in_packets());
      EXPECT_NEAR(packets.interval_s() * rate_hz, 1.0, 1e-4);
      EXPECT_NEAR(packets.scatter_s(), packet_s / std::sqrt(12.0), 0.15 * packet_s);
      EXPECT_GT(packets.mended(), 0.9 * static_cast<double>(samples.size()));
    }
  }
}

TEST(PacketStamps, StampsThatComeOneByOneStayAsTheyAre) {
  constexpr double kInterval_s = 0.005;
  std::mt19937_64 random(2);
  std::exponential_distribution<double> late(1.0 / (0.3 * kInterval_s));
  std::uniform_real_distribution<double> jitter(-0.3 * kInterval_s, 0.3 * kInterval_s);
  PacketStamps of_late, of_jitter, of_even;
  double last_s = 0.0;
  for (int i = 1; i < 20000; ++i) {
    const double t_s = kInterval_s * i;
    last_s = std::max(last_s + 1e-6, t_s + std::min(late(random), 0.45 * kInterval_s));
    const double jittered_s = t_s + jitter(random);
    ASSERT_EQ(of_late.Mend(last_s), last_s);
    ASSERT_EQ(of_jitter.Mend(jittered_s), jittered_s);
    ASSERT_EQ(of_even.Mend(t_s), t_s);
  }
  EXPECT_EQ(of_late.mended() + of_jitter.mended() + of_even.mended(), 0);
}

TEST(PacketStamps, AfterALostSampleTheTimesAreRightAgainSoon) {
  constexpr double kRate_hz = 100.0;
  std::vector<Sample> samples = Sampled(kRate_hz, 0.016, 200.0);
  samples.erase(samples.begin() + 10000, samples.begin() + 10002);
  const std::vector<double> errors_s = Errors(samples, 90.0);
  // The last 90 s: the loss is at 100 s.
  EXPECT_LT(Largest({errors_s.end() - 9000, errors_s.end()}), 0.25 / kRate_hz);
  EXPECT_LT(Largest({errors_s.begin(), errors_s.begin() + 990}), 1e-3);
}

TEST(PacketStamps, APauseOfTheHostDoesNoHarm) {
  Host host(0.016);
  std::vector<Sample> samples;
  for (int i = 0; i < 20000; ++i) {
    const double t_s = 0.01 * i;
    if (i % 2000 == 1999) host.busy_until_s = t_s + 0.35;
    samples.push_back({t_s, host.StampOf(t_s)});
  }
  EXPECT_LT(Largest(Errors(samples, 30.0)), 1.5e-3);
}

TEST(PacketStamps, TimesNeverGoBackAndWhatIsNoNumberIsGivenBack) {
  PacketStamps packets;
  EXPECT_TRUE(std::isnan(packets.Mend(std::numeric_limits<double>::quiet_NaN())));
  double last_s = -1.0;
  for (const Sample& sample : Sampled(200.0, 0.016, 60.0)) {
    // Those of one packet with one stamp.
    const double stamp_s = std::floor(sample.stamp_s / 1e-3) * 1e-3;
    const double mended_s = packets.Mend(stamp_s);
    ASSERT_TRUE(sample.t_s < 2.0 || mended_s > last_s) << sample.t_s;
    last_s = mended_s;
  }
  EXPECT_TRUE(packets.in_packets());
  // After a long pause the clock begins anew, as it does when the stamps go back.
  EXPECT_EQ(packets.Mend(100.0), 100.0);
  EXPECT_EQ(packets.Mend(50.0), 50.0);
}

}  // namespace
}  // namespace gyrobench::calibration
