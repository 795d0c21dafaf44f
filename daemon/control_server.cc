#include "daemon/control_server.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "base/error.h"

namespace gyrobench::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Local = asio::local::stream_protocol;
using Stream = beast::basic_stream<Local>;

constexpr std::size_t kMaxBody = 64 * 1024;
constexpr std::chrono::seconds kPatience{10};

// One connection: requests and replies in turn until the client closes it.
class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(Local::socket socket, const ControlServer::Handler& handler)
      : stream_(std::move(socket)), handler_(handler) {}

  void Read() {
    parser_.emplace();
    parser_->body_limit(kMaxBody);
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error) self->Answer();
                     });
  }

 private:
  void Answer() {
    const auto& request = parser_->get();
    const HttpReply reply = handler_(HttpRequest{std::string(request.method_string()),
                                                 std::string(request.target()), request.body()});
    response_ = {};
    response_.result(reply.status);
    response_.version(request.version());
    response_.set(http::field::content_type, "application/json");
    response_.body() = reply.body;
    response_.keep_alive(request.keep_alive());
    response_.prepare_payload();
    stream_.expires_after(kPatience);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        if (!error && self->response_.keep_alive()) self->Read();
                      });
  }

  Stream stream_;
  const ControlServer::Handler& handler_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> response_;
};

bool SomebodyListens(asio::io_context& io, const Local::endpoint& endpoint) {
  Local::socket probe(io);
  boost::system::error_code error;
  probe.connect(endpoint, error);
  return !error;
}

}  // namespace

class ControlServer::Listener {
 public:
  Listener(const std::filesystem::path& socket, unsigned mode, Handler handler)
      : path_(socket), handler_(std::move(handler)), acceptor_(io_) {
    try {
      Open(mode);
    } catch (const std::exception& error) {
      throw Error(
          fmt::format("control socket {}: {}. Choose another place in the stand file "
                      "(control_socket) or give this "
                      "user the right to write there",
                      path_.string(), error.what()));
    }
    Accept();
    thread_ = std::thread([this] { io_.run(); });
  }

  ~Listener() {
    io_.stop();
    thread_.join();
    std::error_code ignored;  // nobody is left to tell
    std::filesystem::remove(path_, ignored);
  }

 private:
  void Open(unsigned mode) {
    if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path());
    const Local::endpoint endpoint(path_.string());
    if (std::filesystem::exists(path_)) {
      if (SomebodyListens(io_, endpoint)) throw Error("another gyrobenchd serves it already");
      std::filesystem::remove(path_);
    }
    acceptor_.open(endpoint.protocol());
    // Nobody may connect between bind and chmod.
    const mode_t before = ::umask(0177);
    boost::system::error_code error;
    acceptor_.bind(endpoint, error);
    ::umask(before);
    if (error) throw boost::system::system_error(error);
    std::filesystem::permissions(path_, static_cast<std::filesystem::perms>(mode));
    acceptor_.listen();
  }

  void Accept() {
    acceptor_.async_accept([this](boost::system::error_code error, Local::socket socket) {
      if (!error) {
        std::make_shared<Session>(std::move(socket), handler_)->Read();
        Accept();
        return;
      }
      // Out of descriptors, most likely: they come back when sessions end.
      retry_.expires_after(std::chrono::milliseconds(200));
      retry_.async_wait([this](boost::system::error_code stopped) {
        if (!stopped) Accept();
      });
    });
  }

  const std::filesystem::path path_;
  const Handler handler_;
  asio::io_context io_{1};
  Local::acceptor acceptor_;
  asio::steady_timer retry_{io_};
  std::thread thread_;
};

ControlServer::ControlServer(const std::filesystem::path& socket, unsigned mode, Handler handler)
    : listener_(std::make_unique<Listener>(socket, mode, std::move(handler))) {}

ControlServer::~ControlServer() = default;

}  // namespace gyrobench::daemon
