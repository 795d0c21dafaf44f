#include "recording/event_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/lcm.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <random>
#include <thread>

#include "base/error.h"
#include "record_builder.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using testing::HasSubstr;

struct Seen {
  std::int64_t number = 0;
  Utime utime = 0;
  std::string channel;
  std::string data;
  bool operator==(const Seen&) const = default;
};

// Event i of the tests' logs: sizes differ, the payload has bytes of the sync word in it.
Seen Planned(int i) {
  std::string data(static_cast<std::size_t>(i * 37 % 211), static_cast<char>(i));
  if (i % 5 == 0) data += std::string("\xED\xA1\xDA\x01", 4);
  return {i, 1'700'000'000'000'000 + i * 1001, i % 2 == 0 ? "G_GYRO" : "G_ANGLE", data};
}

void WriteLog(const std::filesystem::path& file, int count) {
  EventLogWriter writer(file);
  for (int i = 0; i < count; ++i) {
    const Seen event = Planned(i);
    writer.Write(event.channel, event.utime,
                 reinterpret_cast<const std::uint8_t*>(event.data.data()), event.data.size());
  }
  writer.Close();
}

std::vector<Seen> ReadLog(EventLogReader& reader) {
  std::vector<Seen> seen;
  LogEvent event;
  while (reader.Next(event)) {
    seen.push_back({event.number, event.utime, std::string(event.channel),
                    std::string(event.data.begin(), event.data.end())});
  }
  return seen;
}

TEST(EventLog, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 500);
  EventLogReader reader(folder / "log");
  const std::vector<Seen> seen = ReadLog(reader);
  ASSERT_EQ(seen.size(), 500u);
  for (int i = 0; i < 500; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], Planned(i)) << i;
  EXPECT_TRUE(reader.damage().empty());
  EXPECT_EQ(reader.fraction(), 1.0);
}

// A user's own LCM tools must be able to play our records.
TEST(EventLog, IsReadByLcmsOwnReader) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 50);
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "log").c_str(), "r");
  ASSERT_NE(log, nullptr);
  for (int i = 0; i < 50; ++i) {
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
    ASSERT_NE(event, nullptr) << i;
    // The upper half is the checksum.
    EXPECT_GT(event->eventnum >> 32, 0);
    const Seen seen = {event->eventnum & 0xFFFF'FFFF, event->timestamp, event->channel,
                       std::string(static_cast<const char*>(event->data),
                                   static_cast<std::size_t>(event->datalen))};
    EXPECT_EQ(seen, Planned(i));
    lcm_eventlog_free_event(event);
  }
  EXPECT_EQ(lcm_eventlog_read_next_event(log), nullptr);
  lcm_eventlog_destroy(log);
}

TEST(EventLog, EndsQuietlyAtAnEventThatACrashCutAnywhere) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 3);
  const std::string whole = ReadFile(folder / "log");
  const std::size_t last = whole.size() - 28 - Planned(2).channel.size() - Planned(2).data.size();
  for (std::size_t size = last + 1; size < whole.size(); ++size) {
    WriteFile(folder / "cut", whole.substr(0, size));
    EventLogReader reader(folder / "cut");
    EXPECT_EQ(ReadLog(reader).size(), 2u) << size;
    ASSERT_EQ(reader.damage().size(), 1u) << size;
    EXPECT_EQ(reader.damage()[0].kind, "truncated_log");
    EXPECT_THAT(reader.damage()[0].where, HasSubstr("byte "));
  }
}

TEST(EventLog, SkipsAStretchOfDamageAndNamesItsPlaceLengthAndLoss) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 20);
  std::string bytes = ReadFile(folder / "log");
  std::vector<std::size_t> places;
  {
    EventLogReader reader(folder / "log");
    LogEvent event;
    while (reader.Next(event)) places.push_back(static_cast<std::size_t>(event.byte));
  }
  // Events 7 and 8 become noise without a sync word.
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(places[7]),
            bytes.begin() + static_cast<std::ptrdiff_t>(places[9]), '\x55');
  WriteFile(folder / "damaged", bytes);
  EventLogReader reader(folder / "damaged");
  const std::vector<Seen> seen = ReadLog(reader);
  ASSERT_EQ(seen.size(), 18u);
  EXPECT_EQ(seen[6], Planned(6));
  EXPECT_EQ(seen[7], Planned(9));
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_EQ(reader.damage()[0].kind, "damaged_log");
  EXPECT_EQ(reader.damage()[0].count, 2);
  EXPECT_EQ(reader.damage()[0].where, "byte " + std::to_string(places[7]) + ", " +
                                          std::to_string(places[9] - places[7]) + " bytes");
}

TEST(EventLog, WithoutChecksumsIsReadAsEver) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 50);
  WriteFile(folder / "old", WithoutChecksums(folder / "log"));
  EventLogReader reader(folder / "old");
  const std::vector<Seen> seen = ReadLog(reader);
  ASSERT_EQ(seen.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], Planned(i)) << i;
  EXPECT_TRUE(reader.damage().empty());
}

// What a checksum is for: no bit of a record can change unseen.
TEST(EventLog, AFlippedBitAnywhereIsNamedWithItsPlaceAndCostsItsEventOnly) {
  const TemporaryFolder folder;
  constexpr int kEvents = 12;
  WriteLog(folder / "log", kEvents);
  const std::string whole = ReadFile(folder / "log");
  std::vector<std::size_t> places;
  {
    EventLogReader reader(folder / "log");
    LogEvent event;
    while (reader.Next(event)) places.push_back(static_cast<std::size_t>(event.byte));
  }
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string bytes = whole;
    bytes[bit / 8] ^= static_cast<char>(1 << (bit % 8));
    WriteFile(folder / "flipped", bytes);
    EventLogReader reader(folder / "flipped");
    const std::vector<Seen> seen = ReadLog(reader);
    const auto hit = std::upper_bound(places.begin(), places.end(), bit / 8) - places.begin() - 1;
    std::vector<Seen> expected;
    for (int i = 0; i < kEvents; ++i) {
      if (i != hit) expected.push_back(Planned(i));
    }
    ASSERT_EQ(seen, expected) << "bit " << bit;
    ASSERT_EQ(reader.damage().size(), 1u) << "bit " << bit;
    const LogDamage& damage = reader.damage()[0];
    EXPECT_THAT(
        damage.where,
        testing::StartsWith("byte " + std::to_string(places[static_cast<std::size_t>(hit)]) + ", "))
        << bit;
    EXPECT_EQ(damage.after, hit == 0 ? 0 : Planned(static_cast<int>(hit) - 1).utime) << bit;
  }
}

// A power cut: what was synced is there; of what came later, any page may have stayed unwritten,
// which reads as zeros, and the file may end anywhere.
TEST(EventLog, AfterAPowerCutNothingThatWasSyncedIsMissingAndNothingIsInvented) {
  const TemporaryFolder folder;
  constexpr int kEvents = 400;
  constexpr std::size_t kPage = 4096;
  WriteLog(folder / "log", kEvents);
  const std::string whole = ReadFile(folder / "log");
  std::mt19937 random(20261125);
  for (int round = 0; round < 500; ++round) {
    const std::size_t synced = random() % whole.size();
    std::string left = whole.substr(0, synced + random() % (whole.size() - synced + 1));
    for (std::size_t page = synced / kPage; page * kPage < left.size(); ++page) {
      const std::size_t begin = std::max(synced, page * kPage);
      const std::size_t end = std::min(left.size(), (page + 1) * kPage);
      if (begin < end && random() % 2 == 0) left.replace(begin, end - begin, end - begin, '\0');
    }
    WriteFile(folder / "cut", left);
    EventLogReader reader(folder / "cut");
    const std::vector<Seen> seen = ReadLog(reader);
    for (const Seen& event : seen) {
      ASSERT_EQ(event, Planned(static_cast<int>(event.number))) << round;
    }
    WriteFile(folder / "safe", whole.substr(0, synced));
    EventLogReader safe(folder / "safe");
    const std::vector<Seen> before = ReadLog(safe);
    ASSERT_GE(seen.size(), before.size()) << round;
    EXPECT_TRUE(std::equal(before.begin(), before.end(), seen.begin())) << round;
    EXPECT_TRUE(left == whole.substr(0, left.size()) || !reader.damage().empty()) << round;
  }
}

// A length that grew would otherwise swallow the events after it.
TEST(EventLog, ADamagedLengthCostsOneEventOnly) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 20);
  const std::string whole = ReadFile(folder / "log");
  EventLogReader places(folder / "log");
  LogEvent event;
  for (int i = 0; i <= 4; ++i) ASSERT_TRUE(places.Next(event));
  for (int bit = 0; bit < 32; ++bit) {
    std::string bytes = whole;
    bytes[static_cast<std::size_t>(event.byte) + 24 + static_cast<std::size_t>(bit / 8)] ^=
        static_cast<char>(1 << (bit % 8));
    WriteFile(folder / "damaged", bytes);
    EventLogReader reader(folder / "damaged");
    const std::vector<Seen> seen = ReadLog(reader);
    EXPECT_GE(seen.size(), 19u) << bit;
    EXPECT_EQ(seen.back(), Planned(19)) << bit;
    EXPECT_FALSE(reader.damage().empty()) << bit;
  }
}

TEST(EventLog, AnEventTakenOutWithoutATraceIsNoticedByItsNumber) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 3);
  EventLogReader first(folder / "log");
  LogEvent event;
  ASSERT_TRUE(first.Next(event));
  ASSERT_TRUE(first.Next(event));
  const auto begin = static_cast<std::size_t>(event.byte);
  ASSERT_TRUE(first.Next(event));
  std::string bytes = ReadFile(folder / "log");
  bytes.erase(begin, static_cast<std::size_t>(event.byte) - begin);
  WriteFile(folder / "short", bytes);
  EventLogReader reader(folder / "short");
  EXPECT_EQ(ReadLog(reader).size(), 2u);
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_EQ(reader.damage()[0].kind, "missing_events");
}

// Any mutation: no crash, and every event that is handed out whole and untouched is one that was
// written.
TEST(EventLog, ThousandsOfRandomMutationsNeverCrashAndLoseLittle) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 40);
  const std::string whole = ReadFile(folder / "log");
  std::mt19937 random(20261121);
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = whole;
    const auto place = [&] { return random() % bytes.size(); };
    const std::size_t at = place();
    switch (random() % 4) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, random() % 50 + 1);
        break;
      case 2:
        bytes.insert(at, std::string(random() % 50 + 1, static_cast<char>(random())));
        break;
      default:
        bytes.insert(at, whole.substr(place() % whole.size(), random() % 300));
        break;
    }
    WriteFile(folder / "mutant", bytes);
    EventLogReader reader(folder / "mutant");
    const std::vector<Seen> seen = ReadLog(reader);
    EXPECT_GE(seen.size(), 36u) << "round " << round;
  }
}

TEST(EventLog, NoiseHoldsNoEvents) {
  const TemporaryFolder folder;
  std::mt19937 random(7);
  std::string noise(3'000'000, '\0');
  for (char& c : noise) c = static_cast<char>(random());
  WriteFile(folder / "noise", noise);
  EventLogReader reader(folder / "noise");
  EXPECT_TRUE(ReadLog(reader).empty());
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_EQ(reader.damage()[0].where, "byte 0, 3000000 bytes");
}

TEST(EventLog, AnEmptyLogIsNoDamage) {
  const TemporaryFolder folder;
  WriteFile(folder / "empty", "");
  EventLogReader reader(folder / "empty");
  EXPECT_TRUE(ReadLog(reader).empty());
  EXPECT_TRUE(reader.damage().empty());
}

TEST(EventLog, FromManyThreadsEveryEventArrivesOnce) {
  const TemporaryFolder folder;
  EventLogWriter writer(folder / "log");
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&writer, thread] {
      for (int i = 0; i < 500; ++i) {
        const std::string data = std::to_string(thread * 1000 + i);
        writer.Write("G_RUN", i, reinterpret_cast<const std::uint8_t*>(data.data()), data.size());
        if (i % 100 == 0) writer.Sync();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  writer.Close();
  EventLogReader reader(folder / "log");
  std::vector<std::string> found;
  for (const Seen& seen : ReadLog(reader)) found.push_back(seen.data);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found.size(), 2000u);
  EXPECT_EQ(std::unique(found.begin(), found.end()), found.end());
  EXPECT_TRUE(reader.damage().empty());
}

// A full disk, made by a limit on the size of files.
TEST(EventLog, AFullDiskIsAnErrorThatNamesFileReasonAndWhatWasKept) {
  const TemporaryFolder folder;
  rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  EventLogWriter writer(folder / "log");
  const std::vector<std::uint8_t> data(1000, 1);
  for (int i = 0; i < 10; ++i) writer.Write("G_GYRO", i, data.data(), data.size());
  writer.Sync();
  rlimit small = before;
  small.rlim_cur = 16'000;
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string message = MessageOf<DataError>([&] {
    for (int i = 10; i < 100; ++i) {
      writer.Write("G_GYRO", i, data.data(), data.size());
      writer.Sync();
    }
  });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(message, HasSubstr((folder / "log").string()));
  EXPECT_THAT(message, HasSubstr("File too large"));
  EXPECT_THAT(message, HasSubstr("the first 15 of them are safe"));
  // It stays failed, and what was kept can be read.
  EXPECT_EQ(MessageOf<DataError>([&] { writer.Write("G_GYRO", 0, data.data(), 1); }), message);
  EventLogReader reader(folder / "log");
  EXPECT_EQ(ReadLog(reader).size(), 15u);
}

TEST(EventLog, IsNeverWrittenOverAndNotWrittenAfterClose) {
  const TemporaryFolder folder;
  WriteLog(folder / "log", 1);
  EXPECT_THAT(MessageOf<DataError>([&] { EventLogWriter writer(folder / "log"); }),
              HasSubstr("exists already"));
  EXPECT_THAT(MessageOf<DataError>([&] { EventLogWriter writer(folder / "none/log"); }),
              HasSubstr("No such file or directory"));
  EventLogWriter writer(folder / "other");
  writer.Close();
  EXPECT_THAT(MessageOf<DataError>([&] { writer.Write("A", 0, nullptr, 0); }), HasSubstr("closed"));
}

TEST(EventLog, RefusesAChannelThatReadersWouldTakeForDamage) {
  const TemporaryFolder folder;
  EventLogWriter writer(folder / "log");
  EXPECT_THROW(writer.Write("", 0, nullptr, 0), DataError);
  EXPECT_THROW(writer.Write(std::string(64, 'A'), 0, nullptr, 0), DataError);
  EXPECT_THROW(writer.Write("A\nB", 0, nullptr, 0), DataError);
  writer.Write(std::string(63, 'A'), 0, nullptr, 0);
  EXPECT_EQ(writer.events(), 1);
}

}  // namespace
}  // namespace gyrobench::recording
