#include "daemon/control_server.h"

#include <grp.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"

namespace gyrobench::daemon {
namespace {

namespace fs = std::filesystem;

class ControlServerTest : public testing::Test {
 protected:
  ControlServerTest() {
    std::string pattern = (fs::temp_directory_path() / "gyrobench-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~ControlServerTest() override { fs::remove_all(folder_); }

  sockaddr_un Address() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, socket_.c_str(), sizeof address.sun_path - 1);
    return address;
  }
  // -1 where nobody listens.
  int Connect() const {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    const sockaddr_un address = Address();
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
    ::close(fd);
    return -1;
  }
  // Sends `request` as it is and returns all that comes back until the server closes.
  std::string Exchange(const std::string& request) const {
    const int fd = Connect();
    if (fd < 0) return "";
    EXPECT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(request.size()));
    std::string reply;
    char buffer[4096];
    for (ssize_t n; (n = ::read(fd, buffer, sizeof buffer)) > 0;) {
      reply.append(buffer, static_cast<std::size_t>(n));
    }
    ::close(fd);
    return reply;
  }

  // False where nothing comes back within a tenth of a second.
  bool AnswersSoon(const std::string& request) const {
    const int fd = Connect();
    if (fd < 0) return false;
    const timeval patience{.tv_sec = 0, .tv_usec = 100'000};
    ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::send(fd, request.data(), request.size(), MSG_NOSIGNAL);
    char first = 0;
    const bool answers = ::read(fd, &first, 1) == 1;
    ::close(fd);
    return answers;
  }

  static HttpReply Echo(const HttpRequest& request) {
    return {201, request.method + " " + request.path + " [" + request.body + "]"};
  }

  fs::path folder_;
  fs::path socket_;
  void SetUp() override { socket_ = folder_ / "run" / "control.sock"; }
};

TEST_F(ControlServerTest, HandsRequestsOnAndRepliesBack) {
  const ControlServer server(socket_, {0600}, Echo);
  const std::string reply = Exchange(
      "POST /v1/runs HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: 2\r\n\r\n{}");
  EXPECT_NE(reply.find("HTTP/1.1 201"), std::string::npos) << reply;
  EXPECT_NE(reply.find("POST /v1/runs [{}]"), std::string::npos) << reply;
}

TEST_F(ControlServerTest, ThePermissionsAreTheOnesAskedFor) {
  const ControlServer server(socket_, {0640}, Echo);
  struct stat status {};
  ASSERT_EQ(::stat(socket_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST_F(ControlServerTest, IsOfTheGroupThatWasAskedForAndSaysWhoIsNotKnown) {
  const gid_t own = ::getegid();
  const group* entry = ::getgrgid(own);
  ASSERT_NE(entry, nullptr);
  {
    const ControlServer server(socket_, {0660, {}, entry->gr_name}, Echo);
    struct stat status {};
    ASSERT_EQ(::stat(socket_.c_str(), &status), 0);
    EXPECT_EQ(status.st_gid, own);
  }
  for (const SocketRights& rights :
       {SocketRights{0660, "no-such-user", {}}, SocketRights{0660, {}, "no-such-group"}}) {
    try {
      const ControlServer server(socket_, rights, Echo);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("no-such-"), std::string::npos) << error.what();
    }
    EXPECT_FALSE(fs::exists(socket_));
  }
}

TEST_F(ControlServerTest, HandsOnWhoAsks) {
  const ControlServer server(socket_, {0600}, [](const HttpRequest& request) -> HttpReply {
    return {200, request.peer ? NameOf(*request.peer) : "nobody"};
  });
  EXPECT_NE(Exchange("GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
                .find("(process " + std::to_string(::getpid()) + ")"),
            std::string::npos);
}

TEST_F(ControlServerTest, GarbageAndOversizedRequestsAreDroppedAndTheServerLives) {
  const ControlServer server(socket_, {0600}, Echo);
  Exchange("\x01\x02 this is no HTTP\r\n\r\n");
  Exchange("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 10000000\r\n\r\n");
  EXPECT_NE(Exchange("GET /a HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").find("GET /a"),
            std::string::npos);
}

// Whatever is thrown in the server's thread would end the daemon while an axis turns.
TEST_F(ControlServerTest, WhatAHandlerThrowsIsAnsweredAndTheServerLives) {
  const ControlServer server(socket_, {0600}, [](const HttpRequest& request) -> HttpReply {
    if (request.path == "/number") throw 7;
    throw std::runtime_error(request.path);
  });
  for (const std::string path : {"/number", "/error"}) {
    const std::string reply =
        Exchange("GET " + path + " HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    EXPECT_NE(reply.find("HTTP/1.1 500"), std::string::npos) << reply;
    EXPECT_NE(reply.find("\"internal\""), std::string::npos) << reply;
  }
}

constexpr const char* kGetStart = "GET /start HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
constexpr const char* kGetStop = "GET /stop HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";

TEST_F(ControlServerTest, ARequestDoesNotWaitForThoseOfAnotherLane) {
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future().share();
  const ControlServer server(
      socket_, {0600},
      [ended](const HttpRequest& request) {
        if (request.path == "/slow") ended.wait();
        return Echo(request);
      },
      {2, [](const HttpRequest& request) { return std::size_t{request.path == "/slow"}; }});
  std::thread slow([this] {
    const std::string reply =
        Exchange("GET /slow HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    EXPECT_NE(reply.find("GET /slow"), std::string::npos) << reply;
  });
  EXPECT_NE(Exchange(kGetStop).find("GET /stop"), std::string::npos);
  end.set_value();
  slow.join();
}

// What a request that waits is told of the bench is how it was when the request came.
TEST_F(ControlServerTest, ARequestIsStampedBeforeItWaits) {
  std::atomic<std::int64_t> stops = 0;
  std::atomic<int> came = 0;
  std::promise<void> end;
  const std::shared_future<void> ended = end.get_future().share();
  const ControlServer server(
      socket_, {0600},
      [&stops, ended](const HttpRequest& request) -> HttpReply {
        if (request.path == "/stop") ++stops;
        if (request.path == "/start") ended.wait();
        return {200, "after " + std::to_string(request.stamp.value()) + " stops"};
      },
      {2,
       [&came](const HttpRequest& request) {
         came += request.path == "/start";
         return std::size_t{request.path == "/start"};
       },
       [&stops] { return stops.load(); }});
  std::vector<std::future<std::string>> starts;
  for (int i = 0; i < 2; ++i) {
    starts.push_back(std::async(std::launch::async, [this] { return Exchange(kGetStart); }));
  }
  while (came < 2) std::this_thread::yield();
  EXPECT_NE(Exchange(kGetStop).find("after 0 stops"), std::string::npos);
  end.set_value();
  for (auto& start : starts) EXPECT_NE(start.get().find("after 0 stops"), std::string::npos);
  EXPECT_NE(Exchange(kGetStart).find("after 1 stops"), std::string::npos);
}

// A queue without a bound would let whoever may connect take all memory.
TEST_F(ControlServerTest, MoreRequestsThanMayWaitAreToldToComeAgain) {
  std::promise<void> begun, goes_on;
  std::atomic<int> handled = 0;
  ControlServer server(socket_, {}, [&](const HttpRequest&) {
    if (handled++ == 0) {
      begun.set_value();
      goes_on.get_future().wait();
    }
    return HttpReply{};
  });
  const auto ask = [this] { return Exchange("GET / HTTP/1.1\r\nConnection: close\r\n\r\n"); };
  std::vector<std::future<std::string>> replies;
  replies.push_back(std::async(std::launch::async, ask));
  begun.get_future().wait();
  for (int i = 0; i < 30; ++i) replies.push_back(std::async(std::launch::async, ask));
  // Those beyond are answered while the first one is still at work.
  const auto answered = [&] {
    return std::ranges::count_if(replies, [](const auto& reply) {
      return reply.wait_for(std::chrono::milliseconds(1)) == std::future_status::ready;
    });
  };
  while (answered() < 14) {
  }
  goes_on.set_value();
  int refused = 0;
  for (auto& reply : replies) {
    if (reply.get().find("503") != std::string::npos) ++refused;
  }
  EXPECT_EQ(refused, 14) << "one at work and 16 that wait are served";
}

// A watchdog asks. Starts and dry runs take as long as their script; `stop` and what steers do not.
TEST_F(ControlServerTest, AQuickRequestThatHangsIsSeenFromOutsideAndALongOneIsNone) {
  std::promise<void> begun[2], goes_on[2];
  ControlServer server(
      socket_, {},
      [&](const HttpRequest& request) {
        const std::size_t lane = request.path == "/quick" ? 0 : 1;
        begun[lane].set_value();
        goes_on[lane].get_future().wait();
        return HttpReply{};
      },
      {2,
       [](const HttpRequest& request) -> std::size_t { return request.path == "/quick" ? 0 : 1; },
       {},
       1});
  const auto ask = [this](const char* path) {
    return std::async(std::launch::async, [this, path] {
      return Exchange(std::string("GET ") + path + " HTTP/1.1\r\nConnection: close\r\n\r\n");
    });
  };
  auto slow = ask("/slow");
  begun[1].get_future().wait();
  EXPECT_EQ(server.Stuck(0.0).find("requests"), std::string::npos);
  auto quick = ask("/quick");
  begun[0].get_future().wait();
  EXPECT_NE(server.Stuck(0.0).find("the thread of requests 0"), std::string::npos);
  goes_on[0].set_value();
  quick.wait();
  goes_on[1].set_value();
  slow.wait();
  EXPECT_EQ(server.Stuck(), "");
}

// Its connection was closed in services that were gone.
TEST_F(ControlServerTest, EndsWhileARequestWaitsForAnother) {
  std::atomic<int> came = 0;
  auto server = std::make_unique<ControlServer>(
      socket_, SocketRights{0600},
      [this, &came](const HttpRequest& request) {
        if (request.path == "/start") {
          while (came < 2) std::this_thread::yield();
          while (AnswersSoon(kGetStop)) continue;  // until it has begun to end
        }
        return Echo(request);
      },
      ControlServer::Lanes{2, [&came](const HttpRequest& request) {
                             came += request.path == "/start";
                             return std::size_t{request.path == "/start"};
                           }});
  std::vector<std::future<std::string>> starts;
  for (int i = 0; i < 2; ++i) {
    starts.push_back(std::async(std::launch::async, [this] { return Exchange(kGetStart); }));
  }
  while (came < 2) std::this_thread::yield();
  EXPECT_NE(Exchange(kGetStop).find("GET /stop"), std::string::npos);
  server.reset();
  for (auto& start : starts) EXPECT_EQ(start.get(), "");
  EXPECT_EQ(Connect(), -1);
}

// A crowd that connects and says nothing.
TEST_F(ControlServerTest, ManyIdleConnectionsKeepNobodyOut) {
  const ControlServer server(socket_, {0600}, Echo);
  std::vector<int> crowd;
  for (int i = 0; i < 300; ++i) crowd.push_back(Connect());
  EXPECT_NE(Exchange(kGetStop).find("GET /stop"), std::string::npos);
  for (const int fd : crowd) ::close(fd);
}

// Not the one that came first.
TEST_F(ControlServerTest, InACrowdTheOneThatWasHeardOfLastStays) {
  const ControlServer server(socket_, {0600}, Echo);
  const std::string request = "GET /here HTTP/1.1\r\nHost: x\r\n\r\n";
  char buffer[4096];
  const int first = Connect();
  std::vector<int> crowd;
  for (int i = 0; i < 200; ++i) {
    crowd.push_back(Connect());
    ASSERT_EQ(::send(first, request.data(), request.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(request.size()));
    ASSERT_GT(::read(first, buffer, sizeof buffer), 0) << "dropped beside " << i << " idle ones";
  }
  for (const int fd : crowd) ::close(fd);
  ::close(first);
}

TEST_F(ControlServerTest, SomethingElseThanASocketInItsPlaceIsLeftAloneAndNamed) {
  fs::create_directories(socket_.parent_path());
  std::ofstream(socket_) << "somebody's file";
  try {
    const ControlServer server(socket_, {0600}, Echo);
    FAIL() << "a file was taken for a socket";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("something else than a socket"), std::string::npos);
  }
  std::string text;
  std::getline(std::ifstream(socket_), text);
  EXPECT_EQ(text, "somebody's file");
}

TEST_F(ControlServerTest, TakesOverTheSocketOfADeadDaemonButNotOfALiveOne) {
  fs::create_directories(socket_.parent_path());
  // Bound, and left behind by whoever bound it.
  const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
  const sockaddr_un address = Address();
  ASSERT_EQ(::bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(dead);
  const ControlServer server(socket_, {0600}, Echo);
  try {
    const ControlServer second(socket_, {0600}, Echo);
    FAIL() << "two daemons on one socket";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("another gyrobenchd"), std::string::npos);
  }
}

TEST_F(ControlServerTest, AFolderThatCannotBeMadeIsAnErrorThatNamesTheSocket) {
  try {
    const ControlServer server("/proc/none/control.sock", {0600}, Echo);
    FAIL() << "a socket in /proc";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/proc/none/control.sock"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobench::daemon
