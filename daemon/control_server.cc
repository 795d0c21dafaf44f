#include "daemon/control_server.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <cerrno>
#include <chrono>
#include <deque>
#include <list>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "base/error.h"
#include "daemon/busy_time.h"

namespace gyrobench::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Local = asio::local::stream_protocol;
using Stream = beast::basic_stream<Local>;

constexpr std::size_t kMaxBody = 64 * 1024;
constexpr std::chrono::seconds kPatience{10};

// Who waits for a lane beyond these is told to come again.
constexpr std::size_t kMostWaiting = 16;
// Beyond these the connection that has been idle for longest gives way, so that no crowd keeps a
// stop out, nor takes the descriptors that devices and records need.
constexpr std::size_t kMostConnections = 64;

HttpReply Unhandled(unsigned status, const char* code, const char* message) {
  return {status, fmt::format(R"({{"error": {{"code": "{}", "message": "{}", "where": ""}}}})",
                              code, message)};
}

// A thread of its own for requests of a kind, and those of them that wait.
class LaneThread {
 public:
  // False where too many wait already.
  bool Post(std::function<void()> task) {
    if (waiting_.fetch_add(1) >= kMostWaiting) {
      --waiting_;
      return false;
    }
    asio::post(pool_, [this, task = std::move(task)] {
      --waiting_;
      const BusyTime::While busy(busy_);
      task();
    });
    return true;
  }
  const BusyTime& busy() const { return busy_; }
  // What waits is given up, what is under way is waited for.
  void Stop() {
    pool_.stop();
    pool_.join();
  }

 private:
  std::atomic<std::size_t> waiting_ = 0;
  BusyTime busy_;
  asio::thread_pool pool_{1};
};

// What all connections share.
struct Service {
  ControlServer::Handler handler;
  ControlServer::Lanes lanes;
  std::deque<LaneThread> threads;

  // The last resort: whatever is thrown, the daemon goes on.
  HttpReply Handle(const HttpRequest& request) const {
    try {
      return handler(request);
    } catch (...) {
      return Unhandled(500, "internal", "the request could not be handled; the daemon goes on");
    }
  }
};

// One connection: requests and replies in turn until the client closes it. All but Handle runs in
// the thread of the connections.
class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(Local::socket socket, Service& service)
      : peer_(PeerOf(socket.native_handle())), stream_(std::move(socket)), service_(service) {}

  void Read() {
    parser_.emplace();
    parser_->body_limit(kMaxBody);
    idle_ = true;
    idle_since_ = std::chrono::steady_clock::now();
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       self->idle_ = false;
                       if (!error) self->Answer();
                     });
  }
  bool idle() const { return idle_; }
  std::chrono::steady_clock::time_point idle_since() const { return idle_since_; }
  void Close() { stream_.close(); }

 private:
  void Answer() {
    const auto& request = parser_->get();
    HttpRequest asked{std::string(request.method_string()), std::string(request.target()),
                      request.body()};
    asked.peer = peer_;
    if (service_.lanes.stamp) asked.stamp = service_.lanes.stamp();
    LaneThread& lane = service_.threads.at(service_.lanes.of(asked));
    const bool taken = lane.Post([self = shared_from_this(), asked = std::move(asked)] {
      asio::post(self->stream_.get_executor(),
                 [self, reply = self->service_.Handle(asked)] { self->Write(reply); });
    });
    if (!taken) Write(Unhandled(503, "busy", "too many requests of this kind wait; try again"));
  }

  void Write(const HttpReply& reply) {
    const auto& request = parser_->get();
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

  const Peer peer_;
  Stream stream_;
  Service& service_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  http::response<http::string_body> response_;
  bool idle_ = false;
  std::chrono::steady_clock::time_point idle_since_;
};

std::string Whose(const SocketRights& rights) {
  std::string text = rights.owner ? fmt::format("user \"{}\"", *rights.owner) : "";
  if (rights.group) {
    if (rights.owner) text += ", ";
    text += fmt::format("group \"{}\"", *rights.group);
  }
  return text;
}

bool SomebodyListens(asio::io_context& io, const Local::endpoint& endpoint) {
  Local::socket probe(io);
  boost::system::error_code error;
  probe.connect(endpoint, error);
  return !error;
}

}  // namespace

void RequireSocketOrNothing(const std::filesystem::path& socket) {
  const auto found = std::filesystem::symlink_status(socket).type();
  if (found == std::filesystem::file_type::not_found ||
      found == std::filesystem::file_type::socket) {
    return;
  }
  throw Error(
      fmt::format("control socket {}: something else than a socket is in its place, and is "
                  "left alone. Choose another place in the stand file (control_socket)",
                  socket.string()));
}

class ControlServer::Listener {
 public:
  Listener(const std::filesystem::path& socket, const SocketRights& rights, Handler handler,
           Lanes lanes)
      : path_(socket), service_{std::move(handler), std::move(lanes), {}}, acceptor_(io_) {
    service_.threads.resize(service_.lanes.count);
    RequireSocketOrNothing(path_);
    try {
      Open(rights);
    } catch (const std::exception& error) {
      throw Error(
          fmt::format("control socket {}: {}. Choose another place in the stand file "
                      "(control_socket) or give this "
                      "user the right to write there",
                      path_.string(), error.what()));
    }
    Accept();
    Beat();
    thread_ = std::thread([this] { Serve(); });
  }

  ~Listener() {
    io_.stop();
    thread_.join();
    for (LaneThread& lane : service_.threads) lane.Stop();
    std::error_code ignored;  // nobody is left to tell
    std::filesystem::remove(path_, ignored);
  }

  std::string Stuck(double longest_s) const {
    for (std::size_t i = 0; i < service_.lanes.quick; ++i) {
      const std::string text =
          Hangs(fmt::format("the thread of requests {}", i), service_.threads[i].busy(), longest_s);
      if (!text.empty()) return text;
    }
    return Hangs("the thread of connections", connections_, longest_s);
  }

 private:
  static std::string Hangs(const std::string& who, const BusyTime& time, double longest_s) {
    const double busy_s = time.For_s();
    if (busy_s <= longest_s) return {};
    return fmt::format("{} has been at one thing for {:.0f} s", who, busy_s);
  }

  // All that its thread does is short: one that does not come by here hangs.
  void Beat() {
    connections_.Next();
    beat_.expires_after(std::chrono::seconds(1));
    beat_.async_wait([this](boost::system::error_code stopped) {
      if (!stopped) Beat();
    });
  }

  void Open(const SocketRights& rights) {
    // Names that nobody has are told before anything is made.
    const uid_t owner = rights.owner ? UserByName(*rights.owner) : static_cast<uid_t>(-1);
    const gid_t group = rights.group ? GroupByName(*rights.group) : static_cast<gid_t>(-1);
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
    if (::chown(path_.c_str(), owner, group) != 0) {
      const std::string why = std::generic_category().message(errno);
      std::filesystem::remove(path_);
      throw Error(
          fmt::format("it cannot be given to {}: {}; a group must be one of this user's, "
                      "another owner needs root",
                      Whose(rights), why));
    }
    std::filesystem::permissions(path_, static_cast<std::filesystem::perms>(rights.mode));
    acceptor_.listen();
  }

  void Accept() {
    acceptor_.async_accept([this](boost::system::error_code error, Local::socket socket) {
      if (!error) {
        Begin(std::move(socket));
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

  // A connection that fails in a way that nobody thought of is not the end of the others.
  void Serve() {
    while (!io_.stopped()) {
      try {
        io_.run();
      } catch (const std::exception& error) {
        spdlog::error("control socket: {}", error.what());
      }
    }
  }

  void CloseIdlest() {
    std::shared_ptr<Session> idlest;
    for (const auto& weak : sessions_) {
      const auto session = weak.lock();
      if (!session || !session->idle()) continue;
      if (!idlest || session->idle_since() < idlest->idle_since()) idlest = session;
    }
    if (idlest) idlest->Close();
  }

  void Begin(Local::socket socket) {
    std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
    if (sessions_.size() >= kMostConnections) CloseIdlest();
    // All are busy: this one may come again.
    if (sessions_.size() >= 2 * kMostConnections) return;
    const auto session = std::make_shared<Session>(std::move(socket), service_);
    sessions_.push_back(session);
    session->Read();
  }

  const std::filesystem::path path_;
  // Before all that holds connections: requests that were given up in a lane are gone only with it.
  asio::io_context io_{1};
  Service service_;
  Local::acceptor acceptor_;
  asio::steady_timer retry_{io_};
  asio::steady_timer beat_{io_};
  BusyTime connections_;
  std::list<std::weak_ptr<Session>> sessions_;
  std::thread thread_;
};

ControlServer::ControlServer(const std::filesystem::path& socket, const SocketRights& rights,
                             Handler handler)
    : ControlServer(socket, rights, std::move(handler),
                    {1, [](const HttpRequest&) { return std::size_t{0}; }}) {}

ControlServer::ControlServer(const std::filesystem::path& socket, const SocketRights& rights,
                             Handler handler, Lanes lanes)
    : listener_(std::make_unique<Listener>(socket, rights, std::move(handler), std::move(lanes))) {}

ControlServer::~ControlServer() = default;

std::string ControlServer::Stuck(double longest_s) const { return listener_->Stuck(longest_s); }

}  // namespace gyrobench::daemon
