// The log of requests beside a directory of users that hangs.
#include "daemon/request_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <semaphore>
#include <string>
#include <utility>

#include "tests/daemon/slow_names.h"

namespace gyrobench::daemon {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Peer kPeer{4711, 1001, 1001, {}};
constexpr std::chrono::minutes kPatience{1};

// Asks a directory that answers once it is let.
class Directory {
 public:
  RequestLog::Name name_of() {
    return [this](const Peer&) {
      asked_.release();
      answers_.wait();
      return std::string("alice");
    };
  }
  void WaitUntilAsked() { asked_.acquire(); }
  void Answer() { answer_.set_value(); }

 private:
  std::counting_semaphore<> asked_{0};
  std::promise<void> answer_;
  std::shared_future<void> answers_ = answer_.get_future().share();
};

TEST(RequestLog, WritesWhoAskedAndWhatBecameOfIt) {
  const LogLines log;
  {
    RequestLog requests([](const Peer&) { return std::string("alice"); }, kPatience);
    requests.Add(kPeer, "/v1/stop", 200);
    requests.Add(kPeer, "/v1/runs", 403);
    requests.Add(kPeer, "/v1/resume", 409);
  }
  EXPECT_EQ(log.text(),
            "alice asked for /v1/stop\n"
            "alice asked for /v1/runs and may not move the stand\n"
            "alice asked for /v1/resume: refused (409)\n");
}

TEST(RequestLog, WhatFindsNoRoomIsCounted) {
  const LogLines log;
  Directory directory;
  {
    RequestLog requests(directory.name_of(), kPatience);
    requests.Add(kPeer, "/v1/stop", 200);
    directory.WaitUntilAsked();
    for (int i = 0; i < 107; ++i) requests.Add(kPeer, "/v1/abort", 200);
    directory.Answer();
  }
  EXPECT_THAT(log.text(), HasSubstr("7 more requests came"));
}

// Tells when the last who holds it has let it go.
class Held {
 public:
  explicit Held(std::shared_ptr<std::binary_semaphore> gone) : gone_(std::move(gone)) {}
  ~Held() { gone_->release(); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

 private:
  const std::shared_ptr<std::binary_semaphore> gone_;
};

// Its thread is left to itself, and says nothing in a log that may be another's by then.
TEST(RequestLog, EndsBesideADirectoryThatHangs) {
  Directory directory;
  const auto gone = std::make_shared<std::binary_semaphore>(0);
  {
    RequestLog requests([name_of = directory.name_of(), held = std::make_shared<const Held>(gone)](
                            const Peer& peer) { return name_of(peer); },
                        std::chrono::milliseconds(1));
    requests.Add(kPeer, "/v1/stop", 200);
    directory.WaitUntilAsked();
  }
  const LogLines log;
  directory.Answer();
  gone->acquire();  // with the thread, which has it last
  EXPECT_THAT(log.text(), Not(HasSubstr("alice")));
}

}  // namespace
}  // namespace gyrobench::daemon
