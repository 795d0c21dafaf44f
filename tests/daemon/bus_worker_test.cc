#include "daemon/bus_worker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

class BusWorkerTest : public testing::Test {
 protected:
  // Stopping joins the worker's thread, which a participant that holds time must not wait for.
  void StopWorker(BusWorker& worker) {
    me_.reset();
    worker.Stop();
  }

  // Starts it at a task that ends with the promise. It has work before it starts: the test holds
  // time, and would hold a worker that waits.
  static void StartAtWork(BusWorker& worker, std::promise<void>& goes_on) {
    std::promise<void> begun;
    worker.Post([&] {
      begun.set_value();
      goes_on.get_future().wait();
    });
    worker.Start();
    begun.get_future().wait();
  }

  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me_ = clock_->Join("test");
};

TEST_F(BusWorkerTest, PollsEachDeviceAtItsOwnRateInBenchTime) {
  BusWorker worker("a", *clock_);
  std::vector<Utime> fast;
  std::vector<Utime> slow;
  worker.AddPoll([&] {
    fast.push_back(clock_->Now());
    return clock_->Now() + 20'000;
  });
  worker.AddPoll([&] {
    slow.push_back(clock_->Now());
    return clock_->Now() + 500'000;
  });
  worker.Start();
  me_->WaitUntil(kStart + 9'990'000);
  // Counted while this participant holds time: once it lets go, polls run until the stop arrives.
  const std::vector<Utime> fast_seen = fast;
  const std::vector<Utime> slow_seen = slow;
  StopWorker(worker);
  EXPECT_EQ(fast_seen.size(), 500u);
  EXPECT_EQ(slow_seen.size(), 20u);
  EXPECT_EQ(fast_seen.front(), kStart);
  EXPECT_EQ(slow_seen.back(), kStart + 9'500'000);
}

// Of a client that calls for a stop without end while a device is silent.
TEST_F(BusWorkerTest, WhatIsAskedForAgainWhileItWaitsIsDoneOnceAndWhatCameAfterOthersAgain) {
  BusWorker worker("a", *clock_);
  std::promise<void> goes_on;
  StartAtWork(worker, goes_on);
  std::string done;
  for (int i = 0; i < 1000; ++i) {
    worker.PostUrgentOnce("stop outer", [&] { done += "O"; });
    worker.PostUrgentOnce("stop inner", [&] { done += "I"; });
    worker.PostOnce("off", [&] { done += "-"; });
  }
  worker.Post([&] { done += "+"; });
  for (int i = 0; i < 1000; ++i) worker.PostOnce("off", [&] { done += "-"; });
  goes_on.set_value();
  worker.Call(*me_, [&] { done += "."; });
  worker.PostUrgentOnce("stop outer", [&] { done += "O"; });
  worker.Call(*me_, [] {});
  StopWorker(worker);
  EXPECT_EQ(done, "OI-+-.O");
}

// A watchdog asks.
TEST_F(BusWorkerTest, ATaskThatHangsIsSeenFromOutsideAndAWaitIsNone) {
  BusWorker worker("a", *clock_);
  std::promise<void> goes_on;
  StartAtWork(worker, goes_on);
  const double before_s = worker.BusyFor_s();
  const double after_s = worker.BusyFor_s();
  EXPECT_GT(before_s, 0.0);
  EXPECT_GE(after_s, before_s);
  goes_on.set_value();
  worker.Call(*me_, [] {});
  me_->WaitUntil(kStart + 1'000'000);
  EXPECT_EQ(worker.BusyFor_s(), 0.0);
  StopWorker(worker);
}

TEST_F(BusWorkerTest, ATaskRunsAtOnceAndItsResultComesBack) {
  BusWorker worker("a", *clock_);
  worker.AddPoll([&] { return clock_->Now() + 1'000'000; });
  worker.Start();
  me_->WaitUntil(kStart + 300'000);
  const auto thread = worker.Call(*me_, [&] { return std::this_thread::get_id(); });
  EXPECT_NE(thread, std::this_thread::get_id());
  EXPECT_EQ(clock_->Now(), kStart + 300'000);
  StopWorker(worker);
}

TEST_F(BusWorkerTest, WhatIsUrgentRunsBeforeWhatWasPostedBeforeIt) {
  BusWorker worker("a", *clock_);
  std::vector<std::string> order;
  worker.Post([&] { order.push_back("first"); });
  worker.Post([&] { order.push_back("second"); });
  EXPECT_FALSE(worker.hurries());
  worker.PostUrgent([&] { order.push_back(worker.hurries() ? "stop, and one waits" : "stop"); });
  worker.PostUrgent([&] { order.push_back(worker.hurries() ? "stop, and one waits" : "stop"); });
  EXPECT_TRUE(worker.hurries());
  worker.Start();
  me_->WaitUntil(kStart + 1'000);
  EXPECT_EQ(order, (std::vector<std::string>{"stop, and one waits", "stop", "first", "second"}));
  EXPECT_FALSE(worker.hurries());
  StopWorker(worker);
}

TEST_F(BusWorkerTest, ExceptionsOfATaskReachTheCaller) {
  BusWorker worker("a", *clock_);
  worker.Start();
  EXPECT_THROW(worker.Call(*me_, []() -> int { throw std::runtime_error("no"); }),
               std::runtime_error);
  StopWorker(worker);
}

// The caller is woken for other reasons too, an abort say; it must still wait for its task.
TEST_F(BusWorkerTest, AStrayNotifyDoesNotEndACall) {
  BusWorker worker("a", *clock_);
  Clock::Participant* caller = me_.get();
  worker.Start();
  // As drivers wait: a Notify that came before is no end of the wait.
  const auto rest = [&](Utime until) {
    while (clock_->Now() < until) worker.participant().WaitUntil(until);
  };
  const bool finished = worker.Call(*me_, [&] {
    caller->Notify();
    rest(kStart + 50'000);
    caller->Notify();
    rest(kStart + 100'000);
    return true;
  });
  EXPECT_TRUE(finished);
  EXPECT_EQ(clock_->Now(), kStart + 100'000);
  StopWorker(worker);
}

TEST_F(BusWorkerTest, AStoppedWorkerHoldsNoTime) {
  BusWorker worker("a", *clock_);
  worker.AddPoll([&] { return clock_->Now() + 10'000; });
  worker.Start();
  me_->WaitUntil(kStart + 100'000);
  StopWorker(worker);
  worker.Stop();
  me_ = clock_->Join("test");
  EXPECT_FALSE(me_->WaitUntil(kStart + 3'600'000'000));
}

// A virtual bench whose time is to stand still between runs asks for no time while it is held.
TEST_F(BusWorkerTest, AHeldWorkerDoesTasksButPollsNothingUntilItIsResumed) {
  BusWorker worker("a", *clock_);
  std::vector<Utime> polled;
  worker.AddPoll([&] {
    polled.push_back(clock_->Now());
    return clock_->Now() + 300'000;
  });
  worker.Start();
  me_->WaitUntil(kStart + 1'000'000);
  worker.Hold(*me_);
  me_->WaitUntil(kStart + 5'000'000);
  EXPECT_EQ(worker.Call(*me_, [&] { return polled.size(); }), 4u);
  worker.Resume();
  me_->WaitUntil(kStart + 5'100'000);
  const std::vector<Utime> seen = polled;
  StopWorker(worker);
  ASSERT_EQ(seen.size(), 5u);
  EXPECT_EQ(seen.back(), kStart + 5'000'000);
}

TEST_F(BusWorkerTest, TimeStandsStillWhileAHeldWorkerIsTheOnlyOneThere) {
  BusWorker worker("a", *clock_);
  worker.AddPoll([&] { return clock_->Now() + 10'000; });
  worker.Start();
  worker.Hold(*me_);
  me_.reset();
  std::atomic<bool> ran = false;
  // A task is done meanwhile, and takes no time.
  worker.Post([&] { ran = true; });
  worker.Stop();
  EXPECT_TRUE(ran);
  EXPECT_EQ(clock_->Now(), kStart);
}

TEST_F(BusWorkerTest, StopRunsWhatWasPosted) {
  std::atomic<int> ran = 0;
  {
    BusWorker worker("a", *clock_);
    worker.Start();
    for (int i = 0; i < 10; ++i) worker.Post([&] { ++ran; });
    StopWorker(worker);
  }
  EXPECT_EQ(ran, 10);
}

// Who holds virtual time, as one who asks for a run does, can wait for such a thread.
TEST_F(BusWorkerTest, AFinishedWorkerNeedsNoMoreTimeToStop) {
  for (int i = 0; i < 200; ++i) {
    BusWorker worker("a", *clock_);
    int ran = 0;
    worker.Start();
    worker.Post([&] { ++ran; });
    worker.Finish(*me_);
    worker.Stop();
    EXPECT_EQ(ran, 1);
  }
}

}  // namespace
}  // namespace gyrobench::daemon
