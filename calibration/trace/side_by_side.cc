#include "calibration/trace/side_by_side.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cmath>
#include <exception>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include "base/geometry.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/channel_search.h"

namespace gyrobench::calibration {
namespace {

std::size_t Cores() { return std::max(std::thread::hardware_concurrency(), 1U); }

// One channel on its way through the pool: the first task adds the searches, the last search to end
// finishes.
class ChannelWork {
 public:
  ChannelWork(boost::asio::thread_pool& pool, std::unique_ptr<ChannelTracer> tracer,
              const Sampling& sampling)
      : pool_(pool), tracer_(std::move(tracer)) {
    Post([this, sampling] {
      tracer_->MendBetweenSamples(sampling);
      for (std::function<void()>& search : tracer_->Searches()) Post(std::move(search));
    });
  }

  std::future<TracedChannel> result() { return traced_.get_future(); }

 private:
  void Post(std::function<void()> task) {
    ++open_;
    boost::asio::post(pool_, [this, task = std::move(task)] {
      try {
        task();
      } catch (...) {
        const std::lock_guard lock(failing_);
        if (!failure_) failure_ = std::current_exception();
      }
      if (--open_ == 0) Finish();
    });
  }
  void Finish() {
    try {
      if (failure_) std::rethrow_exception(failure_);
      TracedChannel traced = tracer_->Finish();
      tracer_.reset();  // columns that the others have a use for
      traced_.set_value(std::move(traced));
    } catch (...) {
      traced_.set_exception(std::current_exception());
    }
  }

  boost::asio::thread_pool& pool_;
  std::unique_ptr<ChannelTracer> tracer_;
  std::promise<TracedChannel> traced_;
  std::atomic<int> open_ = 0;  // tasks that have not ended
  std::mutex failing_;
  std::exception_ptr failure_;  // the first
};

double Turned_deg(const ChannelRequest& request) {
  double sum_deg = 0.0;
  for (const StateHistory& history : request.histories) {
    for (const Vector3& rotation_deg : history.rotation_deg) {
      const double turned_deg = std::fabs(rotation_deg[request.channel]);
      if (std::isfinite(turned_deg)) sum_deg += turned_deg;
    }
  }
  return sum_deg;
}

// Who turned most first: there is most to find in its data, and a long search that begins last is
// waited for by all other cores.
std::vector<std::size_t> LongestFirst(std::span<const ChannelRequest* const> requests) {
  std::vector<double> turned_deg;
  for (const ChannelRequest* request : requests) turned_deg.push_back(Turned_deg(*request));
  std::vector<std::size_t> order(requests.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return turned_deg[a] > turned_deg[b]; });
  return order;
}

}  // namespace

void OnAllCores(std::size_t count, const std::function<void(std::size_t)>& one) {
  std::vector<std::exception_ptr> failures(count);
  boost::asio::thread_pool pool(std::clamp(count, std::size_t{1}, Cores()));
  for (std::size_t k = 0; k < count; ++k) {
    boost::asio::post(pool, [&, k] {
      try {
        one(k);
      } catch (...) {
        failures[k] = std::current_exception();
      }
    });
  }
  pool.join();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

namespace {

// The channels of a sensor are sampled alike: as the channel says whose data tell best, and of
// moments where none tells.
Sampling SamplingOf(std::span<const ChannelRequest* const> requests,
                    const std::vector<std::unique_ptr<ChannelTracer>>& tracers) {
  if (!requests.empty() && requests.front()->sampling) return *requests.front()->sampling;
  std::vector<std::optional<SamplingSeen>> seen(tracers.size());
  OnAllCores(tracers.size(), [&](std::size_t k) { seen[k] = tracers[k]->LookAtSamples(); });
  SamplingSeen best;
  for (const std::optional<SamplingSeen>& one : seen) {
    if (!one || !one->clear) continue;
    if (!best.clear || one->std_error < best.std_error) best = *one;
  }
  return best.sampling;
}

}  // namespace

std::vector<TracedChannel> TraceSideBySide(std::span<const ChannelRequest* const> requests,
                                           const std::function<void()>& one_done) {
  std::vector<std::unique_ptr<ChannelTracer>> tracers(requests.size());
  OnAllCores(requests.size(),
             [&](std::size_t k) { tracers[k] = std::make_unique<ChannelTracer>(*requests[k]); });
  const Sampling sampling = SamplingOf(requests, tracers);
  std::list<ChannelWork> work;
  std::vector<std::future<TracedChannel>> results(requests.size());
  boost::asio::thread_pool pool(Cores());
  for (const std::size_t k : LongestFirst(requests))
    results[k] = work.emplace_back(pool, std::move(tracers[k]), sampling).result();
  std::vector<TracedChannel> out;
  try {
    for (std::future<TracedChannel>& result : results) {
      out.push_back(result.get());
      if (one_done) one_done();
    }
  } catch (...) {
    pool.join();  // what is under way looks at requests that the caller owns
    throw;
  }
  pool.join();
  return out;
}

}  // namespace gyrobench::calibration
