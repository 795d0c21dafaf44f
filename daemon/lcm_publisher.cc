#include "daemon/lcm_publisher.h"

#include <fmt/format.h>

#include <lcm/lcm-cpp.hpp>
#include <utility>

namespace gyrobench::daemon {
namespace {

// "239.255.76.67" of "udpm://239.255.76.67:7667?ttl=0".
std::string Group(const std::string& url) {
  const std::size_t begin = url.find("//");
  if (begin == std::string::npos) return url;
  return url.substr(begin + 2, url.find_first_of(":?", begin + 2) - begin - 2);
}

std::string NoRoute(const std::string& url, std::string_view what) {
  return fmt::format(
      "LCM: {} at {}: most likely this machine has no multicast route. Live messages are lost "
      "until there is one; runs are recorded all the same. Mend it with: ip route add {}/32 dev lo",
      what, url, Group(url));
}

}  // namespace

LcmPublisher::LcmPublisher(std::string url, std::string channel_prefix)
    : url_(std::move(url)), prefix_(std::move(channel_prefix)) {
  Open();
}

LcmPublisher::~LcmPublisher() = default;

bool LcmPublisher::Open() {
  const std::lock_guard lock(mutex_);
  if (lcm_) return true;
  auto candidate = std::make_unique<lcm::LCM>(url_);
  if (!candidate->good()) {
    health_ = NoRoute(url_, "cannot open");
    return false;
  }
  lcm_ = std::move(candidate);
  health_.clear();
  return true;
}

bool LcmPublisher::Publish(std::string_view suffix, const std::uint8_t* bytes, std::size_t size) {
  const std::lock_guard lock(mutex_);
  if (!lcm_) return false;
  channel_.assign(prefix_).append(suffix);
  const recording::SenderBytes sender = recording::BytesOf(sender_);
  packet_.assign(bytes, bytes + size);
  packet_.insert(packet_.end(), sender.begin(), sender.end());
  went_out_ = lcm_->publish(channel_, packet_.data(), static_cast<unsigned>(packet_.size())) == 0;
  if (!went_out_) {
    if (health_.empty()) health_ = NoRoute(url_, "cannot publish");
    return false;
  }
  if (!health_.empty()) health_.clear();
  return true;
}

bool LcmPublisher::goes_out() const {
  const std::lock_guard lock(mutex_);
  return went_out_;
}

std::string LcmPublisher::health() const {
  const std::lock_guard lock(mutex_);
  return health_;
}

}  // namespace gyrobench::daemon
