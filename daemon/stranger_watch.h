// Whether somebody else publishes where this daemon does: a second daemon on one LCM address and
// prefix, or a log that is played back there. Who listens would take the one for the other.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "recording/sender.h"

namespace lcm {
struct ReceiveBuffer;
}

namespace gyrobench::daemon {

// Listens, in a thread of its own, to the status channel, on which every daemon speaks once a
// second. It hears no other channel: who sends on one of those alone is named by who listens there.
class StrangerWatch {
 public:
  struct Context {
    std::string url;
    std::string channel;  // GYROBENCH_STATUS
    recording::Sender own;
    // Whether messages go out. Not before is listened: without a route LCM would try for seconds.
    std::function<bool()> goes_out;
    // Told once of each stranger, in the thread.
    std::function<void(const std::string& text)> on_stranger;
  };
  // Of these at most.
  static constexpr std::size_t kMost = 16;

  explicit StrangerWatch(Context context);
  ~StrangerWatch();
  StrangerWatch(const StrangerWatch&) = delete;
  StrangerWatch& operator=(const StrangerWatch&) = delete;

 private:
  void Listen();
  void Hear(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  const Context context_;
  std::set<std::optional<recording::Sender>> told_;  // of the thread
  const int end_;                                    // readable once it is to end
  std::thread thread_;
};

}  // namespace gyrobench::daemon
