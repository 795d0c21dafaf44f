// Live messages to whoever listens. Lossy by nature; the record is elsewhere.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "recording/sender.h"

namespace lcm {
class LCM;
}

namespace gyrobench::daemon {

// Publishes on LCM, and goes on when the network has no multicast route: the run is recorded all
// the same. Publish may be called from any thread. Each message is followed by who sent it.
class LcmPublisher {
 public:
  LcmPublisher(std::string url, std::string channel_prefix);
  ~LcmPublisher();

  // Tries to (re)open the provider when it is not open. True when it is.
  bool Open();
  // `suffix` as in "_GYRO". False when the message could not be sent; health() then says why.
  bool Publish(std::string_view suffix, const std::uint8_t* bytes, std::size_t size);
  // Empty while all is well; otherwise what is wrong and the command that mends it.
  std::string health() const;
  const std::string& prefix() const { return prefix_; }
  // A message has gone out, and the last one has.
  bool goes_out() const;
  recording::Sender sender() const { return sender_; }

 private:
  const std::string url_;
  const std::string prefix_;
  const recording::Sender sender_ = recording::DrawSender();
  mutable std::mutex mutex_;
  std::unique_ptr<lcm::LCM> lcm_;
  // Scratch, so that publishing allocates nothing.
  std::string channel_;
  std::vector<std::uint8_t> packet_;
  bool went_out_ = false;
  std::string health_;
};

}  // namespace gyrobench::daemon
