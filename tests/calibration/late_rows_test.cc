// Rows that come evenly and are stamped when a computer gets to them, against those that are taken
// when it gets to them.
#include "calibration/signal/late_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLength_s = 240.0, kRest_s = 4.0, kAcceleration_deg_s2 = 60.0;

struct Motion {
  double angle_deg, rate_deg_s;
};

// There and back for ever, 24 s each way: rest, ramp, a steady turn, ramp.
Motion MotionAt(double t_s, double speed_deg_s) {
  constexpr double kWay_s = 24.0;
  const double way = std::floor(t_s / kWay_s), in_s = t_s - way * kWay_s;
  const double ramp_s = speed_deg_s / kAcceleration_deg_s2;
  const double moved_s = std::clamp(in_s - kRest_s, 0.0, kWay_s - kRest_s);
  const double rising_s = std::min(moved_s, ramp_s);
  const double falling_s = std::clamp(moved_s - (kWay_s - kRest_s - ramp_s), 0.0, ramp_s);
  const double rate_deg_s = kAcceleration_deg_s2 * (rising_s - falling_s);
  const double angle_deg = 0.5 * kAcceleration_deg_s2 * rising_s * rising_s +
                           speed_deg_s * (moved_s - rising_s) -
                           0.5 * kAcceleration_deg_s2 * falling_s * falling_s;
  const bool back = std::fmod(way, 2.0) == 1.0;
  const double whole_deg = speed_deg_s * (kWay_s - kRest_s - ramp_s);
  return {back ? whole_deg - angle_deg : angle_deg, back ? -rate_deg_s : rate_deg_s};
}

struct Row {
  double t_s, stamp_s;
};

// A row is sampled evenly, and comes at the end of its packet.
std::vector<Row> RowsOfAnAdapter(double rate_hz, double packet_s) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> later(1e-4, 3e-4);
  std::vector<Row> rows;
  double last_s = 0.0;
  for (double i = 0.0; i < kLength_s * rate_hz; ++i) {
    const double t_s = i / rate_hz * (1.0 + 40e-6);
    const double packet_end_s = std::ceil(t_s / packet_s) * packet_s;
    last_s = std::max(packet_end_s + later(random), last_s + 4e-5);
    rows.push_back({t_s, last_s});
  }
  return rows;
}

// Each is sampled when the computer gets to it, which is as uneven.
std::vector<Row> RowsOfAPoll(double rate_hz, double packet_s) {
  std::vector<Row> rows = RowsOfAnAdapter(rate_hz, packet_s);
  for (Row& row : rows) row.t_s = row.stamp_s;
  return rows;
}

LateRows Watch(
    const std::vector<Row>& rows, double speed_deg_s, double noise_deg, double step_deg,
    const std::function<bool(std::size_t)>& has_angle = [](std::size_t) { return true; }) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, noise_deg);
  LateRows out;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double angle_deg = MotionAt(rows[i].t_s, speed_deg_s).angle_deg + noise(random);
    if (step_deg > 0.0) angle_deg = step_deg * std::round(angle_deg / step_deg);
    if (has_angle(i)) out.Take(2, rows[i].stamp_s, angle_deg);
  }
  return out;
}

TEST(LateRows, AreToldFromThoseThatArePolledAsUnevenly) {
  for (const double packet_s : {0.001, 0.004, 0.016}) {
    for (const double rate_hz : {50.0, 61.7, 100.0, 200.0}) {
      for (const double speed_deg_s : {10.0, 40.0}) {
        if (rate_hz * packet_s > 0.9) continue;  // several at once, or one that hardly moves
        const LateRows late =
            Watch(RowsOfAnAdapter(rate_hz, packet_s), speed_deg_s, 0.002, 360.0 / 131072.0);
        const LateRows polled =
            Watch(RowsOfAPoll(rate_hz, packet_s), speed_deg_s, 0.002, 360.0 / 131072.0);
        const double four = 4.0 * std::max(late.share_std_error(), polled.share_std_error()) + 0.02;
        EXPECT_NEAR(late.share(), 0.0, four) << rate_hz << " Hz, " << packet_s << " s";
        EXPECT_NEAR(polled.share(), 1.0, four) << rate_hz << " Hz, " << packet_s << " s";
        EXPECT_FALSE(late.of_their_stamps());
        EXPECT_FALSE(polled.only_stamps());
        if (packet_s * speed_deg_s < 0.1) continue;  // next to the noise
        EXPECT_LT(late.share_std_error() + polled.share_std_error(), 0.1);
        EXPECT_TRUE(polled.of_their_stamps()) << rate_hz << " Hz, " << packet_s << " s";
        EXPECT_TRUE(late.only_stamps()) << rate_hz << " Hz, " << packet_s << " s";
      }
    }
  }
  EXPECT_TRUE(Watch(RowsOfAnAdapter(100.0, 0.004), 40.0, 0.002, 0.0).only_stamps());
}

// A loop that sleeps for an interval: what it does meanwhile adds up, and stamps are rounded. From
// one row to the next rounding is most of it.
TEST(LateRows, OfAClockThatWandersAreAsUnevenAsTheirStamps) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> more(0.0, 2e-4);
  std::vector<Row> rows;
  for (double t_s = 0.0; t_s < kLength_s; t_s += 0.01 + std::fabs(more(random)))
    rows.push_back({t_s, std::round(t_s * 1e3) * 1e-3});
  const LateRows wanders = Watch(rows, 40.0, 0.002, 0.0);
  EXPECT_LT(wanders.share(), 0.25);
  EXPECT_TRUE(wanders.of_their_stamps());
  EXPECT_FALSE(wanders.only_stamps());
}

// Where noise of the angle hides what the stamps would make, nothing is said.
TEST(LateRows, AreNotSeenThroughNoiseOrWithoutATurn) {
  const std::vector<Row> rows = RowsOfAnAdapter(100.0, 0.001);
  EXPECT_FALSE(Watch(rows, 2.0, 0.05, 0.0).only_stamps());
  LateRows at_rest;
  for (const Row& row : rows) at_rest.Take(2, row.stamp_s, 12.0);
  EXPECT_FALSE(at_rest.only_stamps());
  EXPECT_TRUE(std::isnan(at_rest.share()));
}

TEST(LateRows, AreNoneWhereStampsAreEven) {
  std::vector<Row> rows;
  for (double i = 0.0; i < 100.0 * kLength_s; ++i) rows.push_back({i / 100.0, i / 100.0});
  EXPECT_FALSE(Watch(rows, 40.0, 0.002, 0.0).only_stamps());
}

// A reading that is missing makes true times uneven: as much by each as the lateness of a hundred.
TEST(LateRows, AreSeenAlsoWhereReadingsAreMissing) {
  std::mt19937_64 random(9);
  std::bernoulli_distribution missing(0.01);
  const LateRows late = Watch(RowsOfAnAdapter(100.0, 0.002), 40.0, 0.002, 0.0,
                              [&](std::size_t) { return !missing(random); });
  EXPECT_TRUE(late.only_stamps()) << late.share();
  std::vector<Row> even;
  for (double i = 0.0; i < 100.0 * kLength_s; ++i) even.push_back({i / 100.0, i / 100.0});
  EXPECT_FALSE(
      Watch(even, 40.0, 0.002, 0.0, [&](std::size_t) { return !missing(random); }).only_stamps());
}

// RMS of how far the gyro turned beyond the reference from node to node, but for a delay between
// them, which nobody knows [deg].
constexpr double kOwnRate_hz = 25.3;
struct Misfit {
  double deg;
  Recording recording;
};
Misfit Collect(const std::vector<Row>& rows, bool own_rows, const EvenRows& even) {
  constexpr double kSpeed_deg_s = 40.0;
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  info.gyro_units_per_deg_s = 1.0;
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  Collector collector(Collector::kNode_s, even);
  collector.OnInfo(info);
  double own_s = 0.0;
  const std::vector<Row> own = RowsOfAnAdapter(kOwnRate_hz, 0.008);
  std::size_t next = 0;
  for (const Row& row : rows) {
    const Motion motion = MotionAt(row.t_s, kSpeed_deg_s);
    for (; own_rows && next < own.size() && own[next].stamp_s < row.t_s; ++next) {
      own_s = own[next].stamp_s;
      collector.OnAngle({own_s, 2, MotionAt(own[next].t_s, kSpeed_deg_s).angle_deg});
    }
    GyroSample sample;
    sample.t_s = own_rows ? row.t_s : row.stamp_s;
    sample.xi = {kMissing, kMissing, motion.rate_deg_s};
    collector.OnGyro(sample);
    if (!own_rows) collector.OnAngle({row.stamp_s, 2, motion.angle_deg});
  }
  Misfit out{0.0, collector.Take()};
  constexpr double kSettled_s = 40.0;
  const std::vector<Node>& nodes = out.recording.columns.nodes;
  double count = 0.0, square = 0.0, with_delay = 0.0, delay_square = 0.0;
  for (std::size_t k = 2; k < nodes.size(); ++k) {
    if (nodes[k].at.t_s < kSettled_s) continue;
    const auto beyond_deg = [&](std::size_t i) {
      return nodes[i].at.z[2] - nodes[i].rotation_deg[2];
    };
    const double step_deg = beyond_deg(k) - beyond_deg(k - 1);
    const double faster_deg = nodes[k].rotation_deg[2] - 2.0 * nodes[k - 1].rotation_deg[2] +
                              nodes[k - 2].rotation_deg[2];
    count += 1.0;
    square += step_deg * step_deg;
    with_delay += step_deg * faster_deg;
    delay_square += faster_deg * faster_deg;
  }
  out.deg = std::sqrt((square - with_delay * with_delay / delay_square) / count);
  return out;
}

TEST(LateRows, AreCollectedAtTheTimesThatTheyAreOf) {
  constexpr double kRate_hz = 101.7;
  const std::vector<Row> rows = RowsOfAnAdapter(kRate_hz, 0.004);
  for (const bool own_rows : {false, true}) {
    const Misfit by_stamps = Collect(rows, own_rows, {});
    const EvenRows even = RowsThatComeEvenly({&by_stamps.recording.rows, 1}).front();
    EXPECT_EQ(std::isfinite(even.gyro.interval_s), !own_rows);
    EXPECT_EQ(std::isfinite(even.reference[2].interval_s), own_rows);
    EXPECT_TRUE(std::isnan(even.reference[0].interval_s));
    const Misfit by_clock = Collect(rows, own_rows, even);
    EXPECT_LT(by_clock.deg, 0.2 * by_stamps.deg) << "own rows: " << own_rows;
    EXPECT_TRUE(IsAsEvenAs(by_clock.recording.rows, by_stamps.recording.rows));
    EXPECT_FALSE(IsAsEvenAs(by_stamps.recording.rows, by_clock.recording.rows));
    const RowTiming& found = by_clock.recording.rows;
    const KnownClock& clock = own_rows ? found.clocks.reference[2] : found.clocks.gyro;
    EXPECT_NEAR(clock.interval_s * (own_rows ? kOwnRate_hz : kRate_hz), 1.0, 1e-4);
    EXPECT_EQ(found.lost, 0);
  }
}

// Its clock is not even, whatever others say of theirs.
TEST(LateRows, DoNotSpeakForARecordingOfAPoll) {
  const Misfit late = Collect(RowsOfAnAdapter(101.7, 0.004), false, {});
  const Misfit polled = Collect(RowsOfAPoll(101.7, 0.004), false, {});
  const std::vector<RowTiming> both = {late.recording.rows, polled.recording.rows,
                                       late.recording.rows};
  const std::vector<EvenRows> even = RowsThatComeEvenly(both);
  EXPECT_TRUE(even[0].any());
  EXPECT_FALSE(even[1].any());
}

TEST(LateRows, OfAPollAreCollectedAtTheirStamps) {
  const Misfit polled = Collect(RowsOfAPoll(100.0, 0.004), false, {});
  EXPECT_FALSE(RowsThatComeEvenly({&polled.recording.rows, 1}).front().any());
}

// A loop that is late and then catches up asks twice within a quarter of its interval, as a packet
// would bring two rows.
TEST(LateRows, OfALoopThatCatchesUpAreNoPackets) {
  std::mt19937_64 random(6);
  std::exponential_distribution<double> later(1.0 / 0.0045);
  std::vector<Row> rows;
  double last_s = 0.0;
  for (double i = 0.0; i < kLength_s * 100.0; ++i) {
    last_s = std::max(0.01 * i + later(random), last_s + 6e-4);
    rows.push_back({last_s, last_s});
  }
  const Misfit as_packets = Collect(rows, false, {});
  ASSERT_GT(as_packets.recording.packed_samples, 1000);
  const EvenRows even = RowsThatComeEvenly({&as_packets.recording.rows, 1}).front();
  EXPECT_TRUE(even.gyro_is_polled);
  const Misfit by_stamps = Collect(rows, false, even);
  EXPECT_LT(by_stamps.deg, 0.01 * as_packets.deg);
  EXPECT_TRUE(IsAsEvenAs(by_stamps.recording.rows, as_packets.recording.rows));
  EXPECT_EQ(by_stamps.recording.packed_samples, 0);
}

// Of a clock that is nearly a whole number of packets a single recording shows too few jumps.
TEST(LateRows, OfSeveralRecordingsTellTogether) {
  std::vector<RowTiming> timings(5);
  for (std::size_t i = 0; i < timings.size(); ++i) {
    const double t0_s = 100.0 * static_cast<double>(i);
    for (const Row& row : RowsOfAnAdapter(62.5, 0.004)) {
      if (row.t_s < 120.0)
        timings[i].shared.Take(2, t0_s + row.stamp_s, MotionAt(row.t_s, 10.0).angle_deg);
    }
    timings[i].clocks.gyro.interval_s = 0.016;
  }
  for (const EvenRows& even : RowsThatComeEvenly(timings)) EXPECT_EQ(even.gyro.interval_s, 0.016);
  EXPECT_TRUE(std::isnan(RowsThatComeEvenly(timings).front().reference[2].interval_s));
}

}  // namespace
}  // namespace gyrobench::calibration
