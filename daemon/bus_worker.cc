#include "daemon/bus_worker.h"

#include <algorithm>

namespace gyrobench::daemon {

BusWorker::BusWorker(std::string name, Clock& clock)
    : name_(std::move(name)), clock_(clock), participant_(clock.Join("bus " + name_)) {}

BusWorker::~BusWorker() { Stop(); }

void BusWorker::AddPoll(Poll poll) { polls_.push_back({std::move(poll), clock_.Now()}); }

void BusWorker::Start() {
  thread_ = std::thread([this] {
    Loop();
    // From here on nobody waits as this participant, and it must not hold virtual time.
    const std::lock_guard lock(mutex_);
    participant_.reset();
  });
}

void BusWorker::Stop() {
  stopping_ = true;
  if (!thread_.joinable()) return;
  Wake();
  thread_.join();
}

void BusWorker::Post(std::function<void()> task) { PostOnce({}, std::move(task)); }

void BusWorker::PostUrgent(std::function<void()> task) { PostUrgentOnce({}, std::move(task)); }

bool BusWorker::Waits(const std::deque<Task>& tasks, const std::string& key) {
  for (auto task = tasks.rbegin(); task != tasks.rend() && !task->key.empty(); ++task) {
    if (task->key == key) return true;
  }
  return false;
}

void BusWorker::PostOnce(std::string key, std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    if (Waits(tasks_, key)) return;
    tasks_.push_back({std::move(key), std::move(task)});
  }
  Wake();
}

void BusWorker::PostUrgentOnce(std::string key, std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    if (Waits(urgent_, key)) return;
    urgent_.push_back({std::move(key), std::move(task)});
    ++urgent_waiting_;
  }
  Wake();
}

void BusWorker::Resume() {
  if (held_.exchange(false)) Wake();
}

void BusWorker::Wake() {
  const std::lock_guard lock(mutex_);
  if (participant_) participant_->Notify();
}

std::function<void()> BusWorker::Take(bool any) {
  const std::lock_guard lock(mutex_);
  auto& next = urgent_.empty() && any ? tasks_ : urgent_;
  if (next.empty()) return {};
  std::function<void()> task = std::move(next.front().run);
  next.pop_front();
  if (&next == &urgent_) --urgent_waiting_;
  return task;
}

void BusWorker::RunTasks() {
  while (const auto task = Take(true)) {
    const BusyTime::While busy(busy_);
    task();
  }
}

void BusWorker::LetUrgentPass() {
  while (const auto task = Take(false)) {
    busy_.Next();
    task();
  }
  busy_.Next();
}

void BusWorker::Loop() {
  for (;;) {
    RunTasks();
    if (stopping_) break;
    const auto next =
        std::min_element(polls_.begin(), polls_.end(),
                         [](const Scheduled& a, const Scheduled& b) { return a.due < b.due; });
    const Utime due = held_ || next == polls_.end() ? kForever : next->due;
    if (due > clock_.Now()) {
      participant_->WaitUntil(due);
      continue;
    }
    const BusyTime::While busy(busy_);
    next->due = next->poll();
  }
  RunTasks();  // what was posted just before
}

}  // namespace gyrobench::daemon
