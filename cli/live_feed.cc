#include "cli/live_feed.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <set>
#include <utility>

#include "base/error.h"
#include "recording/message_decoder.h"

namespace gyrobench::cli {
namespace {

// Default is 30, which a burst of one block of samples a device overruns while a terminal is slow.
constexpr int kQueueMessages = 20000;
// At the highest rates measured, less loses messages.
constexpr const char* kReceiveBuffer = "recv_buf_size=2097152";

// Without a multicast route LCM blocks for seconds and then says little: ask the kernel first.
void CheckRoute(const std::string& url) {
  const std::size_t begin = url.find("://");
  const std::size_t end = url.find_first_of(":?", begin + 3);
  if (url.rfind("udpm", 0) != 0 || begin == std::string::npos) return;
  const std::string group = url.substr(begin + 3, end - begin - 3);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  if (inet_pton(AF_INET, group.c_str(), &address.sin_addr) != 1) return;
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return;
  sockaddr generic{};
  std::memcpy(&generic, &address, sizeof(generic));
  const bool routed = connect(probe, &generic, sizeof(address)) == 0;
  const int error = errno;
  close(probe);
  if (routed) return;
  throw Error(fmt::format(
      "no live data: no route to the LCM group {} ({}); mend it with: sudo ip route add "
      "{}/32 dev lo",
      group, std::strerror(error), group));
}

std::string WithReceiveBuffer(const std::string& url) {
  if (url.rfind("udpm", 0) != 0 || url.find("recv_buf_size") != std::string::npos) return url;
  return url + (url.find('?') == std::string::npos ? "?" : "&") + kReceiveBuffer;
}

std::string UrlToJoin(const std::string& url) {
  CheckRoute(url);
  return WithReceiveBuffer(url);
}

}  // namespace

class LiveFeed::Impl {
 public:
  Impl(const std::string& url, std::string prefix, Senders::Ask ask, Handler handler)
      : lcm_(UrlToJoin(url)),
        prefix_(std::move(prefix) + "_"),
        senders_(std::move(ask)),
        handler_(std::move(handler)) {
    if (!lcm_.good()) {
      throw Error(
          fmt::format("no live data: LCM cannot be joined at {}; expected a URL such as "
                      "udpm://239.255.76.67:7667?ttl=0",
                      url));
    }
    lcm::Subscription* subscription = lcm_.subscribe(prefix_ + ".*", &Impl::OnMessage, this);
    subscription->setQueueCapacity(kQueueMessages);
  }

  int descriptor() { return lcm_.getFileno(); }

  void Dispatch() {
    while (lcm_.handleTimeout(0) > 0) {
    }
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

  std::int64_t received() const { return received_; }
  std::int64_t lost() const { return lost_; }

 private:
  // LCM calls from C: an exception must not pass through it.
  void OnMessage(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    try {
      Decode(*buffer, channel.substr(prefix_.size()));
    } catch (...) {
      failure_ = std::current_exception();
    }
  }

  void Decode(const lcm::ReceiveBuffer& buffer, const std::string& name) {
    ++received_;
    Identify(buffer);
    if (GiveAny(buffer, name, static_cast<const AnyMessage*>(nullptr))) return;
    LiveMessage live = Named(name);
    live.body = Undecoded{"a channel that this version does not know"};
    handler_(live);
  }

  // False where the channel is none of theirs.
  template <typename... Message>
  bool GiveAny(const lcm::ReceiveBuffer& buffer, const std::string& name,
               const std::variant<Message...>*) {
    return ((name == Reflection<Message>::kChannel && Give<Message>(buffer, name)) || ...);
  }

  template <typename Message>
  bool Give(const lcm::ReceiveBuffer& buffer, const std::string& name) {
    LiveMessage live = Named(name);
    Message message;
    if (recording::DecodeSound(BytesOf(buffer), message)) {
      Count(message.seq, live);
      live.body = std::move(message);
    } else {
      live.body = Undecoded{"of another version or damaged: the type does not match"};
    }
    handler_(live);
    return true;
  }

  static recording::MessageBytes BytesOf(const lcm::ReceiveBuffer& buffer) {
    return {static_cast<const std::uint8_t*>(buffer.data), buffer.data_size};
  }

  void Identify(const lcm::ReceiveBuffer& buffer) {
    const Senders::Id sender = recording::SenderOf(BytesOf(buffer));
    const bool is_stranger = senders_.IsStranger(sender, Senders::Steady::now());
    sender_ = sender ? recording::Name(*sender) : "";
    stranger_ = !is_stranger ? "" : sender ? "instance " + sender_ : "without an instance";
  }

  LiveMessage Named(const std::string& channel) const {
    LiveMessage live;
    live.channel = channel;
    live.sender = sender_;
    live.stranger = stranger_;
    return live;
  }

  // Each sender counts for itself; the daemon that was started anew is another one.
  void Count(std::int64_t seq, LiveMessage& live) {
    const auto [last, first] =
        last_.try_emplace({live.channel, live.stranger}, Last{seq, live.sender});
    if (first) return;
    const bool another = live.sender != last->second.sender;
    const bool anew = another || seq <= last->second.seq;
    live.lost = anew ? 0 : seq - last->second.seq - 1;
    // All channels begin anew with another daemon, and that is said once.
    live.restarted = anew && (!another || started_.emplace(live.stranger, live.sender).second);
    last->second = {seq, live.sender};
    if (live.stranger.empty()) lost_ += live.lost;
  }

  lcm::LCM lcm_;
  std::string prefix_;
  Senders senders_;
  std::string sender_, stranger_;  // of the message at hand
  Handler handler_;
  struct Last {
    std::int64_t seq;
    std::string sender;
  };
  std::map<std::pair<std::string, std::string>, Last> last_;  // of each channel and stranger
  std::set<std::pair<std::string, std::string>> started_;     // strangers and senders: said
  std::int64_t received_ = 0;
  std::int64_t lost_ = 0;
  std::exception_ptr failure_;
};

LiveFeed::LiveFeed(const std::string& url, const std::string& channel_prefix, Senders::Ask ask,
                   Handler handler)
    : impl_(std::make_unique<Impl>(url, channel_prefix, std::move(ask), std::move(handler))) {}
LiveFeed::~LiveFeed() = default;
int LiveFeed::descriptor() const { return impl_->descriptor(); }
void LiveFeed::Dispatch() { impl_->Dispatch(); }
std::int64_t LiveFeed::received() const { return impl_->received(); }
std::int64_t LiveFeed::lost() const { return impl_->lost(); }

}  // namespace gyrobench::cli
