#include "calibration/signal/packet_stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "calibration/signal/sample_times.h"

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

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Errors of the mended times from `from_s` on, less their median: the mean delay is not known.
std::vector<double> Errors(const std::vector<Sample>& samples, double from_s) {
  PacketStamps packets;
  std::vector<double> errors_s;
  for (const Sample& sample : samples) {
    const double mended_s = packets.TimeOf(sample.stamp_s);
    if (sample.t_s >= from_s) errors_s.push_back(mended_s - sample.t_s);
  }
  const double median_s = Median(errors_s);
  for (double& error : errors_s) error -= median_s;
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
      for (const Sample& sample : samples) packets.TimeOf(sample.stamp_s);
      EXPECT_TRUE(packets.mends());
      EXPECT_NEAR(packets.interval_s() * rate_hz, 1.0, 1e-4);
      EXPECT_NEAR(packets.scatter_s(), packet_s / std::sqrt(12.0), 0.15 * packet_s);
      EXPECT_GT(packets.on_line(), 0.9 * static_cast<double>(samples.size()));
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
    ASSERT_EQ(of_late.TimeOf(last_s), last_s);
    ASSERT_EQ(of_jitter.TimeOf(jittered_s), jittered_s);
    ASSERT_EQ(of_even.TimeOf(t_s), t_s);
  }
  EXPECT_EQ(of_late.on_line() + of_jitter.on_line() + of_even.on_line(), 0);
}

// Errors of the mended times of rows that are known to come evenly, less their mean, from 60 s on.
std::vector<double> ErrorsOfEvenRows(const std::vector<Sample>& samples, double rate_hz) {
  PacketStamps rows({1.0 / rate_hz, 0.0});
  std::vector<double> errors_s;
  double mean_s = 0.0;
  for (const Sample& sample : samples) {
    const double error_s = rows.TimeOf(sample.stamp_s) - sample.t_s;
    if (sample.t_s > 60.0) errors_s.push_back(error_s);
  }
  for (const double error : errors_s) mean_s += error / static_cast<double>(errors_s.size());
  for (double& error : errors_s) error -= mean_s;
  return errors_s;
}

// Rates that are no whole number of packets: the lateness of a row is as random as it can be.
TEST(PacketStamps, RowsThatAreKnownToComeEvenlyArePutOnTheLineOneByOne) {
  for (const double packet_s : {0.001, 0.004, 0.008, 0.016}) {
    for (const double rate_hz : {10.1, 50.3, 101.7}) {
      if (rate_hz * packet_s > 1.0) continue;
      const std::vector<Sample> samples = Sampled(rate_hz, packet_s, 300.0);
      EXPECT_LT(Rms(ErrorsOfEvenRows(samples, rate_hz)), 0.02 * packet_s)
          << rate_hz << ", " << packet_s;
    }
  }
}

// What is lost before anything is usual must not run away.
TEST(PacketStamps, AGapAtTheBeginIsNoEndlessLoss) {
  for (const double lost_s : {0.3, 1.5}) {
    PacketStamps rows({1.0 / 50.3, 2000.0});
    double worst_s = 0.0;
    for (const Sample& sample : Sampled(50.3, 0.004, 200.0)) {
      if (sample.t_s > 3.0 && sample.t_s < 3.0 + lost_s) continue;
      const double error_s = rows.TimeOf(sample.stamp_s) - sample.t_s;
      ASSERT_TRUE(std::isfinite(error_s));
      if (sample.t_s > 150.0) worst_s = std::max(worst_s, std::fabs(error_s));
    }
    EXPECT_LT(std::fabs(static_cast<double>(rows.lost())), 80.0) << lost_s;
    EXPECT_LT(worst_s, 0.025) << lost_s;
  }
}

// 40 ppm from a whole number: a line through less time than their beat would go along with it.
TEST(PacketStamps, ASlowBeatOfTheRowsWithThePacketsIsAveraged) {
  for (const double packet_s : {0.001, 0.004}) {
    std::vector<Sample> samples = Sampled(100.0 / (1.0 + 40e-6), packet_s, 900.0);
    EXPECT_LT(Rms(ErrorsOfEvenRows(samples, 100.0)), 0.05 * packet_s) << packet_s;
  }
}

// As that of resistor and capacitor which warms up: a line through more time would lag behind.
TEST(PacketStamps, AClockThatDriftsIsFollowed) {
  constexpr double kDrift = 600e-6, kTime_s = 250.0, kPacket_s = 0.001;
  Host host(kPacket_s);
  std::vector<Sample> samples;
  for (double i = 0.0; i < 90000.0; ++i) {
    const double t_s = i / 100.3 - kDrift * kTime_s * (1.0 - std::exp(-i / 100.3 / kTime_s)) + 1.0;
    samples.push_back({t_s, host.StampOf(t_s)});
  }
  EXPECT_LT(Rms(ErrorsOfEvenRows(samples, 100.0)), 0.3e-3);
}

KnownClock ClockOf(const std::vector<Sample>& samples, double rate_hz) {
  PacketStamps rows({1.0 / rate_hz, 0.0});
  for (const Sample& sample : samples) rows.TimeOf(sample.stamp_s);
  return rows.Clock();
}

// Read once more, the rows are on one line, which errs by less than a packet from end to end, and
// is as late as the stamps are in the mean.
TEST(PacketStamps, ABeatAsLongAsTheRecordingDoesNotMoveTheLineOfItsWhole) {
  for (const double rate_hz : {50.0, 62.5, 100.0}) {
    for (const double packet_s : {0.004, 0.008, 0.016}) {
      if (rate_hz * packet_s > 1.0) continue;
      for (const double length_s : {120.0, 250.0}) {
        const std::vector<Sample> samples = Sampled(rate_hz / (1.0 + 40e-6), packet_s, length_s);
        const KnownClock clock = ClockOf(samples, rate_hz);
        ASSERT_EQ(clock.first_stamp_s, samples.front().stamp_s);
        PacketStamps again(clock);
        double bend_s = 0.0, late_s = 0.0, of_line_s = 0.0;
        std::vector<double> errors_s;
        for (const Sample& sample : samples) {
          const double t_s = again.TimeOf(sample.stamp_s);
          errors_s.push_back(t_s - sample.t_s);
          late_s += sample.stamp_s - sample.t_s;
          of_line_s += errors_s.back();
        }
        const double first_s = errors_s.front(), last_s = errors_s.back();
        const auto count = static_cast<double>(samples.size());
        for (std::size_t i = 0; i < errors_s.size(); ++i) {
          const double line_s =
              first_s + (last_s - first_s) * static_cast<double>(i) / (count - 1.0);
          bend_s = std::max(bend_s, std::fabs(errors_s[i] - line_s));
        }
        SCOPED_TRACE(::testing::Message() << rate_hz << " Hz, " << packet_s << " s, " << length_s);
        EXPECT_LT(bend_s, 1e-6);
        EXPECT_LT(std::fabs(last_s - first_s), packet_s);
        EXPECT_NEAR(of_line_s / count, late_s / count, 0.25 * packet_s);
      }
    }
  }
}

TEST(PacketStamps, AGapInTheRowsLeavesTheLineToTheLongerPart) {
  std::vector<Sample> samples = Sampled(50.0 / (1.0 + 40e-6), 0.004, 300.0);
  std::erase_if(samples, [](const Sample& one) { return one.t_s > 60.0 && one.t_s < 70.0; });
  const KnownClock clock = ClockOf(samples, 50.0);
  EXPECT_GT(clock.first_stamp_s, 70.0 - 1e-9);
  EXPECT_LT(clock.first_stamp_s, 70.1);
}

// As that of resistor and capacitor which warms up.
TEST(PacketStamps, AClockThatDriftsHasNoLineOfItsWhole) {
  constexpr double kDrift = 600e-6, kTime_s = 250.0;
  Host host(0.004);
  std::vector<Sample> samples;
  for (double i = 0.0; i < 30000.0; ++i) {
    const double t_s = i / 100.3 - kDrift * kTime_s * (1.0 - std::exp(-i / 100.3 / kTime_s)) + 1.0;
    samples.push_back({t_s, host.StampOf(t_s)});
  }
  EXPECT_TRUE(std::isnan(ClockOf(samples, 100.0).first_stamp_s));
}

// Errors are those of the last 100 s less the median of the 10 s before the loss, at 100 s.
TEST(PacketStamps, AfterALossTheTimesAreRightAgainSoonAndSayFromWhenTheyWereNot) {
  constexpr double kLoss_s = 100.0;
  for (const double rate_hz : {95.3, 200.0, 1000.0}) {
    for (const double lost_s : {0.022, 0.3, 1.5}) {
      if (lost_s * rate_hz < 0.9 || (rate_hz > 900.0 && lost_s < 0.1)) continue;
      PacketStamps packets;
      std::vector<double> before_s;
      double right_s = kMissing, wrong_since_s = kMissing, worst_s = 0.0;
      for (const Sample& sample : Sampled(rate_hz, 0.016, 130.0)) {
        if (sample.t_s > kLoss_s && sample.t_s < kLoss_s + lost_s) continue;
        const double error_s = packets.TimeOf(sample.stamp_s) - sample.t_s;
        if (sample.t_s > kLoss_s - 10.0 && sample.t_s < kLoss_s) before_s.push_back(error_s);
        if (sample.t_s < kLoss_s + lost_s) continue;
        if (std::isnan(right_s)) right_s = Median(before_s);
        if (std::isfinite(packets.wrong_since_s())) wrong_since_s = packets.wrong_since_s();
        if (sample.t_s > kLoss_s + lost_s + 1.5)
          worst_s = std::max(worst_s, std::fabs(error_s - right_s));
      }
      EXPECT_LT(worst_s, 3e-3) << rate_hz << " Hz, " << lost_s << " s lost";
      EXPECT_LT(wrong_since_s, kLoss_s + 0.05);
      EXPECT_GT(wrong_since_s, kLoss_s - 3.0);
      EXPECT_NEAR(static_cast<double>(packets.lost()), lost_s * rate_hz, 2.0);
    }
  }
}

TEST(PacketStamps, AGapOfAnEvenClockIsNoPacket) {
  for (const double rate_hz : {50.0, 100.0, 400.0, 2000.0}) {
    for (const double gap_s : {0.3, 0.7, 1.5, 1.9}) {
      for (const double at_s : {0.5, 5.0}) {
        PacketStamps packets;
        for (double i = 0.0; i < 20.0 * rate_hz; ++i) {
          const double t_s = i / rate_hz + (i > at_s * rate_hz ? gap_s : 0.0);
          ASSERT_EQ(packets.TimeOf(t_s), t_s) << rate_hz << " Hz, gap of " << gap_s << " s";
        }
      }
    }
  }
}

TEST(PacketStamps, RowsOfOneAxisEachAreNoPackets) {
  PacketStamps packets;
  for (int i = 0; i < 3000; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double t_s = 0.01 * i + 1e-4 * axis;
      ASSERT_EQ(packets.TimeOf(t_s, true), t_s);
    }
  }
}

TEST(PacketStamps, AFasterClockAfterASlowOneIsNoPacket) {
  PacketStamps packets;
  double t_s = 0.0;
  for (int i = 0; i < 6000; ++i) {
    t_s += i < 1000 ? 0.01 : 0.001;
    ASSERT_EQ(packets.TimeOf(t_s), t_s);
  }
}

// Samples that come one by one after packets keep their stamps again, and no time goes back.
TEST(PacketStamps, EndWithThePackets) {
  constexpr double kRate_hz = 500.0;
  SampleTimes times;
  constexpr std::array<bool, 3> kAll = {true, true, true};
  double last_s = -1.0, at_end_s = 0.0;
  for (const Sample& sample : Sampled(kRate_hz, 0.016, 60.0)) {
    const bool packed = sample.t_s < 30.0;
    at_end_s = packed ? sample.stamp_s : std::max(at_end_s, sample.t_s + 0.02);
    const double mended_s = times.OfGyro(at_end_s, kAll);
    ASSERT_GT(mended_s, last_s) << sample.t_s;
    ASSERT_TRUE(sample.t_s < 35.0 || mended_s == at_end_s) << sample.t_s;
    last_s = mended_s;
  }
  EXPECT_GT(times.gyro_packets().on_line(), 0.9 * 30.0 * kRate_hz);
  EXPECT_GT(times.gyro_packets().scatter_s(), 0.0);
  EXPECT_NEAR(times.gyro_packets().interval_s() * kRate_hz, 1.0, 1e-3);
}

// The host is a little later now and then, so that the rows of a packet have two milliseconds.
TEST(PacketStamps, OfWholeMillisecondsArePutOnTheLineAsWell) {
  std::mt19937_64 random(5);
  std::exponential_distribution<double> later(1.0 / 1e-4);
  std::vector<Sample> samples = Sampled(333.0, 0.016, 600.0);
  double later_s = 0.0, packet_s = 0.0, last_s = 0.0;
  for (Sample& sample : samples) {
    if (sample.stamp_s > packet_s + 0.008) {
      packet_s = sample.stamp_s;
      later_s = later(random) - 3e-4;
    }
    const double printed_s = std::floor((sample.stamp_s + later_s) * 1e3) * 1e-3;
    sample.stamp_s = last_s = std::max(printed_s, last_s + 1e-6);
  }
  EXPECT_LT(Largest(Errors(samples, 30.0)), 1e-3);
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
  EXPECT_TRUE(std::isnan(packets.TimeOf(std::numeric_limits<double>::quiet_NaN())));
  double last_s = -1.0;
  for (const Sample& sample : Sampled(200.0, 0.016, 60.0)) {
    // Those of one packet with one stamp.
    const double stamp_s = std::floor(sample.stamp_s / 1e-3) * 1e-3;
    const double mended_s = packets.TimeOf(stamp_s);
    ASSERT_TRUE(sample.t_s < 2.0 || mended_s > last_s) << sample.t_s;
    last_s = mended_s;
  }
  EXPECT_TRUE(packets.mends());
  // After a long pause the clock begins anew, as it does when the stamps go back.
  EXPECT_EQ(packets.TimeOf(100.0), 100.0);
  EXPECT_EQ(packets.TimeOf(50.0), 50.0);
}

}  // namespace
}  // namespace gyrobench::calibration
