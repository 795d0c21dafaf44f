// Live data over LCM, as any program may subscribe to it: docs/subscribe.md.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "cli/senders.h"
#include "gyrobench/reflection.hpp"

namespace gyrobench::cli {

// What could not be read: a channel of this prefix that is not known here, or bytes of another
// version.
struct Undecoded {
  std::string why;
};

template <typename AnyMessage>
struct OrUndecoded;
template <typename... Message>
struct OrUndecoded<std::variant<Message...>> {
  using Type = std::variant<Undecoded, Message...>;
};

struct LiveMessage {
  std::string channel;     // without prefix: "SCALE_RESULT"
  std::int64_t lost = 0;   // messages of this channel missing right before this one
  bool restarted = false;  // numbers began anew: the daemon was restarted; said once of each
  std::string sender;      // its instance, empty where it names none
  std::string stranger;    // who it is in words, where it is not the daemon; empty: the daemon
  OrUndecoded<AnyMessage>::Type body;
};

// Subscribes to all channels of a prefix. For one thread.
class LiveFeed {
 public:
  using Handler = std::function<void(const LiveMessage&)>;
  // `ask`: which instance the daemon is. Throws Error, with the command that mends it, when LCM
  // cannot be joined.
  LiveFeed(const std::string& url, const std::string& channel_prefix, Senders::Ask ask,
           Handler handler);
  ~LiveFeed();
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;

  // Readable when Dispatch has something to do.
  int descriptor() const;
  // Gives what has arrived to the handler, without waiting.
  void Dispatch();
  std::int64_t received() const;
  // Of the daemon's own.
  std::int64_t lost() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobench::cli
