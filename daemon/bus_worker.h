// The thread of one bus: polls its devices and does what others ask of them.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "daemon/busy_time.h"

namespace gyrobench::daemon {

// One thread a bus, as Modbus wants it: devices on one line cannot be asked side by side.
// Everything that touches a device of the bus runs here, so that no device needs a lock.
class BusWorker {
 public:
  // Joins the clock now; the thread starts with Start.
  BusWorker(std::string name, Clock& clock);
  ~BusWorker();
  BusWorker(const BusWorker&) = delete;
  BusWorker& operator=(const BusWorker&) = delete;

  // For the drivers of this bus: whom they wait as.
  Clock::Participant& participant() { return *participant_; }
  const std::string& name() const { return name_; }

  // A poll does its work and returns when it is due again. It must not throw. Before Start.
  using Poll = std::function<Utime()>;
  void AddPoll(Poll poll);
  void Start();
  // Ends the thread after what it is doing. Idempotent. Waits for it in real time: where the
  // caller holds virtual time, Finish comes before.
  void Stop();
  // Waits, as `caller`, until all that was posted is done and the thread needs no more time; what
  // is posted later is never done.
  void Finish(Clock::Participant& caller) {
    Call(caller, [this] { stopping_ = true; });
  }

  // From now on nothing is polled until Resume; tasks are still done. Waits, as `caller`, for the
  // end of what the bus's thread is doing.
  void Hold(Clock::Participant& caller) {
    Call(caller, [this] { held_ = true; });
  }
  // Polls again: at once what has become due meanwhile. From any thread.
  void Resume();

  // Runs `task` in the bus's thread, before any poll that is due. `task` must not throw.
  void Post(std::function<void()> task);
  // The same, before all that was posted otherwise; what the thread is doing is to hurry.
  void PostUrgent(std::function<void()> task);
  // The same, but nothing where a task of this key waits already and no other kind of task behind it:
  // what is asked for again and again takes no room, however long the bus is busy.
  void PostOnce(std::string key, std::function<void()> task);
  void PostUrgentOnce(std::string key, std::function<void()> task);
  // Whether an urgent task waits for what the thread is doing. From any thread.
  bool hurries() const { return urgent_waiting_ > 0; }
  // Within a task: what is urgent is done now, before the task goes on.
  void LetUrgentPass();

  // For how long, in real time, its thread has been at one poll or task; 0 while it waits for the
  // next. From any thread.
  double BusyFor_s() const { return busy_.For_s(); }

  // Runs `function` in the bus's thread, waits for it as `caller`, and hands on its result or
  // exception.
  template <typename Function>
  auto Call(Clock::Participant& caller, Function function) -> decltype(function()) {
    return CallBy(&BusWorker::Post, caller, std::move(function));
  }
  // The same as an urgent task.
  template <typename Function>
  auto CallUrgent(Clock::Participant& caller, Function function) -> decltype(function()) {
    return CallBy(&BusWorker::PostUrgent, caller, std::move(function));
  }

 private:
  template <typename Function>
  auto CallBy(void (BusWorker::*post)(std::function<void()>), Clock::Participant& caller,
              Function function) -> decltype(function()) {
    using Result = decltype(function());
    struct Outcome {
      std::mutex mutex;  // held while notifying, so that the caller is still there
      std::conditional_t<std::is_void_v<Result>, bool, Result> value{};
      std::exception_ptr error;
      bool done = false;
    };
    auto outcome = std::make_shared<Outcome>();
    (this->*post)([outcome, &caller, function = std::move(function)]() mutable {
      try {
        if constexpr (std::is_void_v<Result>) {
          function();
        } else {
          outcome->value = function();
        }
      } catch (...) {  // handed on to the caller below
        outcome->error = std::current_exception();
      }
      const std::lock_guard lock(outcome->mutex);
      outcome->done = true;
      caller.Notify();
    });
    const auto done = [&outcome] {
      const std::lock_guard lock(outcome->mutex);
      return outcome->done;
    };
    do {
      caller.WaitUntil(kForever);
    } while (!done());
    if (outcome->error) std::rethrow_exception(outcome->error);
    if constexpr (!std::is_void_v<Result>) return std::move(outcome->value);
  }

  struct Task {
    std::string key;  // empty: none like it
    std::function<void()> run;
  };
  static bool Waits(const std::deque<Task>& tasks, const std::string& key);
  struct Scheduled {
    Poll poll;
    Utime due = 0;
  };
  void Loop();
  // The first that is urgent, else the first of the others if `any`. Empty where there is none.
  std::function<void()> Take(bool any);
  void RunTasks();
  void Wake();

  const std::string name_;
  Clock& clock_;
  std::unique_ptr<Clock::Participant> participant_;
  std::vector<Scheduled> polls_;
  std::mutex mutex_;
  std::deque<Task> tasks_;
  std::deque<Task> urgent_;
  std::atomic<int> urgent_waiting_ = 0;
  BusyTime busy_;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> held_ = false;
  std::thread thread_;
};

}  // namespace gyrobench::daemon
