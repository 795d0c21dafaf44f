#include "base/clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <vector>

namespace gyrobench {
namespace {

constexpr Utime kStart = 1'700'000'000'000'000;
constexpr Utime kSecond = kMicrosecondsPerSecond;

TEST(VirtualClock, JumpsToTheWakeUpOfTheOnlyWaiter) {
  const auto clock = MakeVirtualClock(kStart);
  const auto me = clock->Join("me");
  EXPECT_FALSE(me->WaitUntil(kStart + 3600 * kSecond));
  EXPECT_EQ(clock->Now(), kStart + 3600 * kSecond);
}

TEST(VirtualClock, NeverGoesBackWhenAskedForThePast) {
  const auto clock = MakeVirtualClock(kStart);
  const auto me = clock->Join("me");
  EXPECT_FALSE(me->WaitUntil(kStart - kSecond));
  EXPECT_EQ(clock->Now(), kStart);
}

// The order in which threads run is the order of their wake-ups and, at the same moment, of
// joining; whoever the operating system would have preferred.
TEST(VirtualClock, ReleasesInOrderOfTimeAndThenOfJoining) {
  for (int repetition = 0; repetition < 20; ++repetition) {
    const auto clock = MakeVirtualClock(kStart);
    std::vector<std::unique_ptr<Clock::Participant>> participants;
    for (int i = 0; i < 4; ++i) participants.push_back(clock->Join(std::to_string(i)));
    std::mutex mutex;
    std::vector<std::pair<Utime, int>> order;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back(
          [&, i, me = std::move(participants[static_cast<std::size_t>(i)])]() mutable {
            const Utime period = i < 2 ? 10 : 15;
            for (Utime t = kStart + period; t <= kStart + 60; t += period) {
              me->WaitUntil(t);
              const std::lock_guard lock(mutex);
              order.emplace_back(clock->Now() - kStart, i);
            }
            me.reset();
          });
    }
    for (std::thread& thread : threads) thread.join();
    ASSERT_EQ(order.size(), 2u * 6 + 2u * 4);
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  }
}

TEST(VirtualClock, StandsStillWhileAResidentRuns) {
  const auto clock = MakeVirtualClock(kStart);
  const auto running = clock->Join("running");
  auto waiter = clock->Join("waiter");
  std::atomic<bool> woke = false;
  std::thread thread([&, me = std::move(waiter)]() mutable {
    me->WaitUntil(kStart + kSecond);
    woke = true;
    me.reset();
  });
  for (int i = 0; i < 1000; ++i) std::this_thread::yield();
  EXPECT_EQ(clock->Now(), kStart);
  EXPECT_FALSE(woke);
  running->WaitUntil(kStart + 2 * kSecond);
  thread.join();
  EXPECT_TRUE(woke);
}

// A device's thread waits in place of the driver's thread, which sits in a blocking call.
TEST(VirtualClock, AGuestWaitsInPlaceOfTheResidentThatIsBlockedForIt) {
  const auto clock = MakeVirtualClock(kStart);
  const auto driver = clock->Join("driver");
  const auto device = clock->Join("device", Clock::Role::kGuest);
  std::thread server([&] { device->WaitUntil(kStart + 5000); });
  server.join();  // the resident's "Modbus call"
  EXPECT_EQ(clock->Now(), kStart + 5000);
}

// The driver's blocking call has timed out in real time while the device still waits: both go on.
TEST(VirtualClock, AResidentThatGaveUpOnItsGuestStopsNobody) {
  const auto clock = MakeVirtualClock(kStart);
  const auto driver = clock->Join("driver");
  const auto device = clock->Join("device", Clock::Role::kGuest);
  clock->SetPace(0.0);
  std::atomic<bool> answered = false;
  std::thread server([&] {
    device->WaitUntil(kStart + 5000);
    answered = true;
  });
  for (int i = 0; i < 1000; ++i) std::this_thread::yield();
  std::thread operator_thread([&] { clock->SetPace(VirtualClock::kUnpaced); });
  driver->WaitUntil(kStart + 100'000);
  server.join();
  operator_thread.join();
  EXPECT_TRUE(answered);
  EXPECT_EQ(clock->Now(), kStart + 100'000);
  EXPECT_FALSE(driver->WaitUntil(kStart + 200'000));
}

TEST(VirtualClock, ANotifyEndsTheWaitAtThePresentTime) {
  const auto clock = MakeVirtualClock(kStart);
  auto sleeper = clock->Join("sleeper");
  const auto notifier = clock->Join("notifier");
  Clock::Participant* sleeper_view = sleeper.get();
  bool notified = false;
  Utime woke_at = 0;
  std::thread thread([&, me = std::move(sleeper)]() mutable {
    notified = me->WaitUntil(kStart + 1000 * kSecond);
    woke_at = clock->Now();
    me->WaitUntil(kStart + 2000 * kSecond);
    me.reset();
  });
  notifier->WaitUntil(kStart + 7 * kSecond);
  sleeper_view->Notify();
  notifier->WaitUntil(kStart + 3000 * kSecond);
  thread.join();
  EXPECT_TRUE(notified);
  EXPECT_EQ(woke_at, kStart + 7 * kSecond);
}

TEST(VirtualClock, ANotifyBeforeTheWaitIsNotLost) {
  const auto clock = MakeVirtualClock(kStart);
  const auto me = clock->Join("me");
  me->Notify();
  EXPECT_TRUE(me->WaitUntil(kStart + kSecond));
  EXPECT_EQ(clock->Now(), kStart);
  EXPECT_FALSE(me->WaitUntil(kStart + kSecond));
}

TEST(VirtualClock, AtPaceZeroOnlyANotifyEndsAWait) {
  const auto clock = MakeVirtualClock(kStart);
  auto waiter = clock->Join("waiter");
  clock->SetPace(0.0);
  Clock::Participant* view = waiter.get();
  bool notified = false;
  std::thread thread([&, me = std::move(waiter)]() mutable {
    notified = me->WaitUntil(kStart + 1);
    me.reset();
  });
  for (int i = 0; i < 1000; ++i) std::this_thread::yield();
  EXPECT_EQ(clock->Now(), kStart);
  view->Notify();
  thread.join();
  EXPECT_TRUE(notified);
  EXPECT_EQ(clock->Now(), kStart);
}

// Nobody is to wake up: time must not run away to the end of the epoch.
TEST(VirtualClock, ForeverIsNoMomentToJumpTo) {
  const auto clock = MakeVirtualClock(kStart);
  auto waiter = clock->Join("waiter");
  Clock::Participant* view = waiter.get();
  std::thread thread([&, me = std::move(waiter)]() mutable {
    EXPECT_TRUE(me->WaitUntil(kForever));
    me.reset();
  });
  for (int i = 0; i < 1000; ++i) std::this_thread::yield();
  EXPECT_EQ(clock->Now(), kStart);
  view->Notify();
  thread.join();
}

TEST(VirtualClock, LettingGoOfThePaceReleasesWhoeverWaits) {
  const auto clock = MakeVirtualClock(kStart);
  auto waiter = clock->Join("waiter");
  clock->SetPace(0.0);
  std::thread thread([&, me = std::move(waiter)]() mutable {
    me->WaitUntil(kStart + 86400 * kSecond);
    me.reset();
  });
  clock->SetPace(VirtualClock::kUnpaced);
  thread.join();
  EXPECT_EQ(clock->Now(), kStart + 86400 * kSecond);
}

// Paced at a million, an hour takes milliseconds, and never less than its real share.
TEST(VirtualClock, PacedTimeTakesItsShareOfRealTime) {
  const auto clock = MakeVirtualClock(kStart);
  const auto me = clock->Join("me");
  clock->SetPace(1e6);
  const auto begin = std::chrono::steady_clock::now();
  me->WaitUntil(kStart + 3600 * kSecond);
  const std::chrono::duration<double> real = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(real.count(), 3600 / 1e6 * 0.999);
  EXPECT_EQ(clock->Now(), kStart + 3600 * kSecond);
}

TEST(SystemClock, IsMonotonicAndWaits) {
  const auto clock = MakeSystemClock();
  const auto me = clock->Join("me");
  const Utime before = clock->Now();
  EXPECT_FALSE(me->WaitUntil(before + 2000));
  EXPECT_GE(clock->Now(), before + 2000);
  me->Notify();
  EXPECT_TRUE(me->WaitUntil(clock->Now() + 3600 * kSecond));
}

}  // namespace
}  // namespace gyrobench
