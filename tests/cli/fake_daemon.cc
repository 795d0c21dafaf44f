#include "tests/cli/fake_daemon.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace gyrobench::cli {

namespace http = boost::beast::http;
using Local = boost::asio::local::stream_protocol;

FakeDaemon::FakeDaemon(const std::filesystem::path& socket, Handler handler)
    : socket_(socket), handler_(std::move(handler)) {
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const Local::endpoint endpoint(socket.string());
  if (bind(listener_, endpoint.data(), static_cast<socklen_t>(endpoint.size())) != 0 ||
      listen(listener_, 8) != 0) {
    throw std::runtime_error("fake daemon: " + socket.string() + ": " + std::strerror(errno));
  }
  thread_ = std::thread([this] { Serve(); });
}

FakeDaemon::~FakeDaemon() {
  shutdown(listener_, SHUT_RDWR);  // ends accept
  thread_.join();
  close(listener_);
  std::filesystem::remove(socket_);
}

void FakeDaemon::Serve() {
  for (;;) {
    const int accepted = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (accepted < 0) return;
    boost::asio::io_context context;
    Local::socket stream(context, Local(), accepted);
    boost::beast::flat_buffer buffer;
    http::request<http::string_body> request;
    boost::system::error_code error;
    http::read(stream, buffer, request, error);
    if (error) continue;
    const FakeRequest seen{
        std::string(request.method_string()) + " " + std::string(request.target()), request.body()};
    const FakeReply reply = handler_(seen);
    http::response<http::string_body> response{http::int_to_status(reply.status), 11};
    response.body() = reply.body.dump();
    response.prepare_payload();
    http::write(stream, response, error);
    const std::lock_guard lock(mutex_);
    requests_.push_back(seen);
    changed_.notify_all();
  }
}

std::string FakeDaemon::WaitForRequest(const std::string& what) {
  std::unique_lock lock(mutex_);
  const auto find = [&] {
    return std::find_if(requests_.begin(), requests_.end(),
                        [&](const FakeRequest& request) { return request.what == what; });
  };
  if (!changed_.wait_for(lock, std::chrono::seconds(60),
                         [&] { return find() != requests_.end(); })) {
    throw std::runtime_error("no request " + what);
  }
  return find()->body;
}

FakeReply Refusal(unsigned status, const std::string& code, const std::string& message,
                  const std::string& where) {
  return {status, {{"error", {{"code", code}, {"message", message}, {"where", where}}}}};
}

}  // namespace gyrobench::cli
