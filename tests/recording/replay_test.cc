#include "recording/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "base/error.h"
#include "gyrobench/angle_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "record_builder.h"
#include "recording/event_log.h"
#include "recording/message_decoder.h"
#include "recording/run_directory.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

KeepingSink ReplayOf(const std::filesystem::path& path) {
  KeepingSink sink;
  Replay(path, sink);
  return sink;
}

TEST(ReplayRun, GivesTheRunsOwnSamplesOnItsOwnTime) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  const KeepingSink sink = ReplayOf(folder / "run");
  EXPECT_EQ(sink.infos, 1);
  EXPECT_EQ(sink.info.sensor, "GB-0017");
  ASSERT_EQ(sink.gyro.size(), 1000u) << "those before the run and of another run are left out";
  EXPECT_EQ(sink.gyro[0].t_s, 2'011 * 1e-6);
  EXPECT_EQ(sink.gyro[1].t_s, 7'012 * 1e-6);
  EXPECT_THAT(sink.gyro[1].xi, ElementsAre(-193 * 97, -189 * 97 + 1, -185 * 97 + 2));
  EXPECT_EQ(sink.gyro[1].accel_g[0], (-193 * 51 + 13) / 16384.0);
  EXPECT_EQ(sink.gyro[0].temperature_degC, static_cast<double>(21.37f));
  ASSERT_EQ(sink.angles.size(), 200u);
  EXPECT_EQ(sink.angles[1].axis, 2);
  EXPECT_EQ(sink.angles[1].t_s, 21'650 * 1e-6);
  EXPECT_EQ(sink.angles[1].angle_deg, 123.456789012);
  ASSERT_EQ(sink.ticks.size(), 100u);
  EXPECT_EQ(sink.ticks[0].tick_s, (100'000 + 9 * 1250 + 303) / 250'000.0);
  ASSERT_EQ(sink.segments.size(), 2u);
  EXPECT_EQ(sink.segments[0].name, "turn 39");
  EXPECT_EQ(sink.segments[0].begin_s, 0.0);
  EXPECT_EQ(sink.segments[0].end_s, 2.0);
  EXPECT_TRUE(sink.defects.empty());
}

TEST(ReplayRun, TimesCountFromThePowerOnWhereTheRecordSaysWhenThatWas) {
  const TemporaryFolder folder;
  RecordPlan plan;
  BuildRecord(folder / "before", plan);
  plan.power_on_utime = plan.start - 100 * kMicrosecondsPerSecond;
  BuildRecord(folder / "run", plan);
  const KeepingSink before = ReplayOf(folder / "before"), sink = ReplayOf(folder / "run");
  EXPECT_EQ(sink.info.power_on_utime, plan.power_on_utime);
  ASSERT_EQ(sink.gyro.size(), before.gyro.size());
  EXPECT_NEAR(sink.gyro[0].t_s, 100.0 + before.gyro[0].t_s, 1e-9);
  EXPECT_NEAR(sink.angles[1].t_s, 100.0 + before.angles[1].t_s, 1e-9);
  EXPECT_NEAR(sink.ticks[0].host_s, 100.0 + before.ticks[0].host_s, 1e-9);
  EXPECT_NEAR(sink.segments[0].begin_s, 100.0, 1e-9);
}

TEST(ReplayRun, APowerOnAfterTheRunBeganIsADamagedRunJson) {
  const TemporaryFolder folder;
  RecordPlan plan;
  plan.power_on_utime = plan.start + 1;
  BuildRecord(folder / "run", plan);
  const KeepingSink sink = ReplayOf(folder / "run");
  EXPECT_EQ(sink.Count("damaged_run_json"), 1);
  ASSERT_FALSE(sink.defects.empty());
  EXPECT_THAT(sink.defects[0].where,
              testing::AllOf(HasSubstr("measurement.power_on_utime = 1795000000123458"),
                             HasSubstr("at most 1795000000123457 (start_utime of the run)")));
}

TEST(ReplayRun, ARecordIsFoundByItsFolderItsJsonOrItsLog) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  for (const char* name : {"", kRunJsonName, kEventLogName}) {
    EXPECT_EQ(ReplayOf(folder / "run" / name).gyro.size(), 1000u) << name;
  }
  std::filesystem::rename(folder / "run/events.lcmlog", folder / "run/elsewhere.00");
  EXPECT_EQ(ReplayOf(folder / "run/elsewhere.00").gyro.size(), 1000u)
      << "a log is told by its bytes";
}

// A crash between the making of the folder and of run.json must not cost the samples.
TEST(ReplayRun, WithoutRunJsonTheMessagesSayWhatTheyCan) {
  const TemporaryFolder folder;
  RecordPlan plan;
  plan.with_run_json = false;
  BuildRecord(folder / "log-only", plan);
  BuildRecord(folder / "bad-json", plan);
  WriteFile(folder / "bad-json/run.json", "{\"run_id\": \"x\", \"start_u");
  for (const char* name : {"log-only", "bad-json"}) {
    const KeepingSink sink = ReplayOf(folder / name);
    EXPECT_EQ(sink.info.source, plan.run_id) << "the run whose start the log holds";
    EXPECT_EQ(sink.info.gyro_units_per_deg_s, 131.0);
    EXPECT_EQ(sink.info.stand_axis_present, (std::array<bool, 3>{true, false, true}));
    ASSERT_EQ(sink.gyro.size(), 1000u);
    EXPECT_EQ(sink.gyro[0].t_s, 2'011 * 1e-6);
    EXPECT_EQ(sink.Count("damaged_run_json"), std::string(name) == "bad-json" ? 1 : 0);
  }
}

// tests/compatibility/record-1 was made by the last version that knew no checksums.
TEST(ReplayRun, ARecordOfBeforeThereWereChecksumsIsReadWhole) {
  const KeepingSink sink =
      ReplayOf(std::filesystem::path(GYROBENCH_SOURCE_DIR) / "tests/compatibility/record-1");
  EXPECT_EQ(sink.gyro.size(), 387u);
  EXPECT_EQ(sink.segments.size(), 3u);
  EXPECT_TRUE(sink.defects.empty());
}

TEST(ReplayRun, DamagedMessagesAreCountedByPlaceAndTheOthersRead) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  // As of another logger: with checksums the reader of the log would not hand them out.
  std::string log = WithoutChecksums(folder / "run/events.lcmlog");
  // The count of the 50th block of samples becomes negative, then huge.
  EventLogReader reader(folder / "run/events.lcmlog");
  LogEvent event;
  std::vector<std::int64_t> places;
  std::size_t data_offset = 0;
  while (reader.Next(event)) {
    if (event.channel.ends_with("_GYRO")) places.push_back(event.byte);
    data_offset = 28 + event.channel.size() + (event.channel.ends_with("_RUN") ? 1 : 0);
  }
  const std::size_t count_offset =
      8 + 8 + 4 + RecordPlan{}.run_id.size() + 1 + 8 + 8 + 8 + 4 + 8 + 8 + 8;
  for (const std::size_t block : {50u, 60u}) {
    const auto at = static_cast<std::size_t>(places[block]) + data_offset + count_offset;
    log[at] = block == 50 ? '\xff' : '\x7f';
  }
  WriteFile(folder / "run/events.lcmlog", log);
  const KeepingSink sink = ReplayOf(folder / "run");
  EXPECT_EQ(sink.gyro.size(), 980u);
  EXPECT_EQ(sink.Count("damaged_message"), 2);
  EXPECT_EQ(sink.Where("damaged_message"),
            "byte " + std::to_string(places[50]) + ", channel BENCH_7_GYRO");
  EXPECT_EQ(sink.Count("samples_lost"), 20) << "the sample numbers tell what is gone";
}

// Whatever happens to a record's bytes, each kind of sample stays in order of time and nothing
// crashes.
TEST(ReplayRun, ThousandsOfRandomMutationsNeverCrashNorBreakTheOrder) {
  const TemporaryFolder folder;
  RecordPlan plan;
  plan.blocks = 12;
  BuildRecord(folder / "run", plan);
  const std::string whole = WithoutChecksums(folder / "run/events.lcmlog");
  std::mt19937 random(99);
  std::size_t read = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = whole;
    for (int i = static_cast<int>(random() % 4); i >= 0; --i) {
      const std::size_t at = random() % bytes.size();
      switch (random() % 3) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes[at] = random() % 2 == 0 ? '\x7f' : '\xff';
          break;
        default:
          bytes.erase(at, random() % 64 + 1);
          break;
      }
    }
    WriteFile(folder / "run/events.lcmlog", bytes);
    const KeepingSink sink = ReplayOf(folder / "run");
    read += sink.gyro.size();
    for (std::size_t i = 1; i < sink.gyro.size(); ++i) {
      ASSERT_GT(sink.gyro[i].t_s, sink.gyro[i - 1].t_s) << "round " << round;
    }
  }
  EXPECT_GT(read, 3000u * 90u) << "most samples survive";
}

TEST(Replay, WhatIsNeitherRecordNorTableIsAnErrorThatSaysWhatWasExpected) {
  const TemporaryFolder folder;
  EXPECT_THAT(MessageOf<DataError>([&] { ReplayOf(folder / "none"); }),
              HasSubstr("expected a record"));
  EXPECT_THAT(MessageOf<DataError>([&] { ReplayOf(folder.path()); }), HasSubstr("events.lcmlog"));
  WriteFile(folder / "noise.bin", "\x01\x02 noise");
  EXPECT_THAT(MessageOf<DataError>([&] { ReplayOf(folder / "noise.bin"); }),
              HasSubstr("no measurement table"));
  std::filesystem::create_directory(folder / "empty");
  WriteFile(folder / "empty/events.lcmlog", "");
  EXPECT_THAT(MessageOf<DataError>([&] { ReplayOf(folder / "empty"); }),
              HasSubstr("no readable message"));
}

TEST(Replay, ProgressGrowsToOne) {
  const TemporaryFolder folder;
  RecordPlan plan;
  plan.blocks = 2000;
  BuildRecord(folder / "run", plan);
  KeepingSink sink;
  std::vector<double> fractions;
  Replay(folder / "run", sink, [&](double fraction) { fractions.push_back(fraction); });
  EXPECT_GT(fractions.size(), 4u);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

class Decoder : public testing::Test {
 protected:
  static constexpr Utime kStart = 1'000'000'000;

  Decoder() {
    info_.gyro_present = {false, false, true};
    info_.stand_axis_present = {false, false, true};
  }
  gyro_t Block(Utime utime, std::int64_t first_counter, int n) const {
    gyro_t message;
    message.utime = utime;
    message.run_id = "run";
    message.seq = 1;
    message.tick_rate_hz = 1000.0;
    message.unit_tick = 5;
    message.boot_count = 1;
    message.missed = 0;
    message.accel_lsb_per_g = 1.0;
    message.n = n;
    message.first_counter = first_counter;
    const auto size = static_cast<std::size_t>(n);
    for (int i = 0; i < n; ++i) message.sample_utime.push_back(utime - 10 * (n - i));
    message.gyro_lsb.assign(3, std::vector<std::int16_t>(size, 7));
    message.accel_lsb.assign(3, std::vector<std::int16_t>(size, 1));
    message.temperature_degC.assign(size, 20.0f);
    return message;
  }

  MeasurementInfo info_;
  KeepingSink sink_;
};

TEST_F(Decoder, AxesThatAreNotAnnouncedStayMissingOrAreReported) {
  MessageDecoder decoder(info_, kStart, sink_);
  decoder.Gyro(Block(kStart + 1000, 0, 1));
  ASSERT_EQ(sink_.gyro.size(), 1u);
  EXPECT_TRUE(std::isnan(sink_.gyro[0].xi[0]));
  EXPECT_EQ(sink_.gyro[0].xi[2], 7.0);
  angle_t angle = {};
  angle.utime = kStart + 5;
  angle.run_id = "run";
  for (const int axis : {0, 2, 3, -1}) {
    angle.axis = static_cast<std::int8_t>(axis);
    decoder.Angle(angle);
  }
  EXPECT_EQ(sink_.angles.size(), 1u);
  EXPECT_EQ(sink_.Count("unannounced_axis"), 3);
}

TEST_F(Decoder, LostSamplesAreCountedOnceWhetherTheUnitOrTheNumbersTell) {
  MessageDecoder decoder(info_, kStart, sink_);
  gyro_t first = Block(kStart + 1000, 100, 5);
  first.missed = 77;  // before the run
  decoder.Gyro(first);
  EXPECT_EQ(sink_.Count("samples_lost"), 0);
  gyro_t told = Block(kStart + 2000, 108, 5);  // 105..107 are gone
  told.missed = 3;
  decoder.Gyro(told);
  EXPECT_EQ(sink_.Count("samples_lost"), 3);
  decoder.Gyro(Block(kStart + 3000, 120, 5));  // 113..119 are gone and nobody said so
  EXPECT_EQ(sink_.Count("samples_lost"), 10);
  gyro_t empty = Block(kStart + 4000, 0, 0);
  empty.missed = 2;
  decoder.Gyro(empty);
  decoder.Gyro(Block(kStart + 5000, 127, 5));
  EXPECT_EQ(sink_.Count("samples_lost"), 12);
  EXPECT_EQ(sink_.ticks.size(), 5u) << "a message without samples still pairs the clocks";
}

TEST_F(Decoder, ARestartOfTheUnitIsADefectAndNoLossOfSamples) {
  MessageDecoder decoder(info_, kStart, sink_);
  decoder.Gyro(Block(kStart + 1000, 100'000, 5));
  gyro_t restarted = Block(kStart + 2000, 0, 5);
  restarted.boot_count = 2;
  decoder.Gyro(restarted);
  EXPECT_EQ(sink_.Count("unit_restarted"), 1);
  EXPECT_EQ(sink_.Count("samples_lost"), 0);
  EXPECT_EQ(sink_.gyro.size(), 10u);
}

// A device was silent, and the axes were stopped and turned back: none of it is to be fitted.
TEST_F(Decoder, WhatWasSampledWhileTheRunWasSuspendedIsLeftOutAndReportedOnce) {
  MessageDecoder decoder(info_, kStart, sink_);
  run_t run = {};
  run.run_id = "run";
  angle_t angle = {};
  angle.run_id = "run";
  angle.axis = 2;
  const auto sample = [&](Utime utime, std::int64_t first) {
    decoder.Gyro(Block(utime, first, 5));
    angle.utime = utime;
    decoder.Angle(angle);
  };
  sample(kStart + 1000, 0);
  run.event = run_t::SUSPEND;
  run.utime = kStart + 1500;
  decoder.Run(run);
  sample(kStart + 2000, 5);
  sample(kStart + 3000, 10);
  EXPECT_EQ(sink_.gyro.size(), 5u);
  EXPECT_EQ(sink_.angles.size(), 1u);
  run.event = run_t::CONTINUE;
  run.utime = kStart + 3500;
  decoder.Run(run);
  sample(kStart + 4000, 15);
  EXPECT_EQ(sink_.gyro.size(), 10u);
  EXPECT_EQ(sink_.angles.size(), 2u);
  EXPECT_EQ(sink_.Count("suspended"), 1);
  EXPECT_EQ(sink_.Count("samples_lost"), 0);
}

// Another daemon, maybe after another power-on, counts samples and starts of the unit anew.
TEST_F(Decoder, ARunThatIsTakenUpIsOneMeasurementWithAGapThatIsReported) {
  MessageDecoder decoder(info_, kStart, sink_);
  run_t run = {};
  run.run_id = "run";
  const auto tell = [&](std::int8_t event, Utime utime) {
    run.event = event;
    run.utime = utime;
    decoder.Run(run);
  };
  decoder.Gyro(Block(kStart + 1000, 5000, 5));
  tell(run_t::TAKEN_UP, kStart + 1000);
  decoder.Gyro(Block(kStart + 90'000'000, 20, 5));
  EXPECT_EQ(sink_.gyro.size(), 5u);
  tell(run_t::CONTINUE, kStart + 90'001'000);
  decoder.Gyro(Block(kStart + 90'002'000, 25, 5));
  EXPECT_EQ(sink_.gyro.size(), 10u);
  EXPECT_EQ(sink_.Count("taken_up"), 1);
  EXPECT_EQ(sink_.Count("samples_lost"), 0);
  EXPECT_EQ(sink_.Count("unit_restarted"), 0);
  tell(run_t::OTHER_POWER_ON, kStart + 90'003'000);
  EXPECT_EQ(sink_.Count("unit_restarted"), 1);
}

TEST_F(Decoder, SamplesOutOfOrderAreLeftOutAndReported) {
  MessageDecoder decoder(info_, kStart, sink_);
  decoder.Gyro(Block(kStart + 1000, 0, 3));
  decoder.Gyro(Block(kStart + 1000, 3, 3));
  EXPECT_EQ(sink_.gyro.size(), 3u);
  EXPECT_EQ(sink_.Count("repeated_time"), 1);
  EXPECT_EQ(sink_.Count("time_backwards"), 2);
}

TEST_F(Decoder, SamplesTakenBeforeTheRunAreLeftOut) {
  MessageDecoder decoder(info_, kStart, sink_);
  decoder.Gyro(Block(kStart + 25, 0, 5));  // at -25, -15, -5, +5, +15
  ASSERT_EQ(sink_.gyro.size(), 2u);
  EXPECT_EQ(sink_.gyro[0].t_s, 5 * 1e-6);
}

TEST_F(Decoder, AMessageWhoseArraysDoNotFitItsCountIsReported) {
  MessageDecoder decoder(info_, kStart, sink_);
  gyro_t message = Block(kStart + 1000, 0, 5);
  message.gyro_lsb[1].pop_back();
  decoder.Gyro(message);
  message.n = -1;
  decoder.Gyro(message);
  EXPECT_EQ(sink_.Count("damaged_message"), 2);
  EXPECT_TRUE(sink_.gyro.empty());
}

// A time that was too late by one bit made all that followed come too early, and be dropped.
TEST(ReplayRun, OneFlippedBitInATimeCostsNoMoreThanItsMessage) {
  const TemporaryFolder folder;
  const std::filesystem::path record = folder / "record";
  RecordPlan plan;
  BuildRecord(record, plan);
  const KeepingSink whole = ReplayOf(record);
  const std::string log = WithoutChecksums(record / kEventLogName);
  // All times of the record begin with the same four bytes, most significant first.
  std::string begin;
  for (const int shift : {56, 48, 40, 32}) begin += static_cast<char>(plan.start >> shift & 0xFF);
  std::size_t times = 0;
  for (std::size_t at = log.find(begin, log.size() / 3); at < 2 * log.size() / 3;
       at = log.find(begin, at + 8)) {
    if (++times % 7 != 0) continue;  // some of them
    for (int bit = 20; bit < 40; bit += 3) {
      std::string flipped = log;
      flipped[at + 7 - static_cast<std::size_t>(bit / 8)] ^= static_cast<char>(1 << (bit % 8));
      std::ofstream(record / kEventLogName, std::ios::binary) << flipped;
      const KeepingSink sink = ReplayOf(record);
      EXPECT_GE(sink.gyro.size() + 20, whole.gyro.size()) << "byte " << at << ", bit " << bit;
      EXPECT_GE(sink.angles.size() + 2, whole.angles.size()) << "byte " << at << ", bit " << bit;
    }
  }
  EXPECT_GT(times, 100U);
}

}  // namespace
}  // namespace gyrobench::recording
