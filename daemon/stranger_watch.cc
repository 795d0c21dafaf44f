#include "daemon/stranger_watch.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "gyrobench/status_t.hpp"

namespace gyrobench::daemon {
namespace {

constexpr int kTryAgain_ms = 1000;

// What a network carries; a file is written, not listened to.
bool IsShared(const std::string& url) { return url.starts_with("udpm"); }

std::string DescribeStranger(const std::optional<recording::Sender>& sender,
                             const std::optional<status_t>& status) {
  std::string text = sender
                         ? "instance " + recording::Name(*sender)
                         : "without an instance, as an older daemon or a log that is played back";
  if (status) text += fmt::format(", stand '{}', version {}", status->stand, status->version);
  return text;
}

}  // namespace

StrangerWatch::StrangerWatch(Context context)
    : context_(std::move(context)), end_(eventfd(0, EFD_CLOEXEC)) {
  if (IsShared(context_.url) && end_ >= 0) thread_ = std::thread([this] { Listen(); });
}

StrangerWatch::~StrangerWatch() {
  if (thread_.joinable()) {
    eventfd_write(end_, 1);
    thread_.join();
  }
  if (end_ >= 0) close(end_);
}

void StrangerWatch::Listen() {
  std::unique_ptr<lcm::LCM> lcm;
  for (;;) {
    if (!lcm && context_.goes_out()) {
      lcm = std::make_unique<lcm::LCM>(context_.url);
      if (lcm->good()) {
        lcm->subscribe(context_.channel, &StrangerWatch::Hear, this);
      } else {
        lcm.reset();
      }
    }
    std::array<pollfd, 2> waits = {{{end_, POLLIN, 0}, {lcm ? lcm->getFileno() : -1, POLLIN, 0}}};
    poll(waits.data(), waits.size(), lcm ? -1 : kTryAgain_ms);
    if (waits[0].revents != 0) return;
    if (waits[1].revents != 0) lcm->handleTimeout(0);
  }
}

void StrangerWatch::Hear(const lcm::ReceiveBuffer* buffer, const std::string& /*channel*/) {
  const recording::MessageBytes bytes(static_cast<const std::uint8_t*>(buffer->data),
                                      buffer->data_size);
  const std::optional<recording::Sender> sender = recording::SenderOf(bytes);
  if (sender == context_.own || told_.size() >= kMost || !told_.insert(sender).second) return;
  std::optional<status_t> status(std::in_place);
  if (!recording::DecodeSound(bytes, *status)) status.reset();
  context_.on_stranger(fmt::format(
      "another sender publishes on {} at {}: {}. Whoever listens there hears both; gyrobench watch "
      "and run tell them apart, other programs may not. Give one of the two another url or "
      "channel_prefix in the table [lcm] of its stand file",
      context_.channel, context_.url, DescribeStranger(sender, status)));
}

}  // namespace gyrobench::daemon
