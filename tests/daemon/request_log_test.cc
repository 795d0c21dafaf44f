// The log of requests beside a directory of users that hangs.
#include "daemon/request_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <semaphore>
#include <string>

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

// Its thread is left to itself, and says nothing in a log that may be another's by then.
TEST(RequestLog, EndsBesideADirectoryThatHangs) {
  Directory directory;
  std::promise<void> let_go;
  {
    RequestLog requests(
        [name_of = directory.name_of(), &let_go](const Peer& peer) {
          std::string name = name_of(peer);
          let_go.set_value_at_thread_exit();
          return name;
        },
        std::chrono::milliseconds(1));
    requests.Add(kPeer, "/v1/stop", 200);
    directory.WaitUntilAsked();
  }
  const LogLines log;
  directory.Answer();
  let_go.get_future().wait();
  EXPECT_THAT(log.text(), Not(HasSubstr("alice")));
}

}  // namespace
}  // namespace gyrobench::daemon
