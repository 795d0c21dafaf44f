// Answers on a control socket of its own as a test tells it to.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

namespace gyrobench::cli {

struct FakeRequest {
  std::string what;  // "POST /v1/runs"
  std::string body;
};

// The moves of the library's JSON are said to throw nothing, and clang-tidy does not believe it.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct FakeReply {
  unsigned status = 200;
  nlohmann::json body;
};

class FakeDaemon {
 public:
  // Called in the daemon's own thread, one request at a time.
  using Handler = std::function<FakeReply(const FakeRequest&)>;
  FakeDaemon(const std::filesystem::path& socket, Handler handler);
  ~FakeDaemon();
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;

  // Waits until the first request of this kind has been answered, and gives its body. Throws after
  // 60 s.
  std::string WaitForRequest(const std::string& what);

 private:
  void Serve();

  std::filesystem::path socket_;
  Handler handler_;
  int listener_ = -1;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FakeRequest> requests_;
  std::thread thread_;
};

// The answer of the control socket when it refuses.
FakeReply Refusal(unsigned status, const std::string& code, const std::string& message,
                  const std::string& where = "");

}  // namespace gyrobench::cli
