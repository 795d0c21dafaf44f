#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "base/error.h"
#include "stand/server/bus_server.h"
#include "stand/server/modbus.h"

namespace gyrobench::stand {
namespace {

constexpr std::size_t kHeader = 7;

sockaddr_in Address(const std::string& host, int port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    throw DeviceError(
        fmt::format("virtual stand: '{}': expected an IPv4 address such as 127.0.0.1", host));
  }
  return address;
}

sockaddr* Generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

Descriptor Listen(const std::string& host, int port) {
  Descriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  sockaddr_in address = Address(host, port);
  const int on = 1;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(listener.get(), Generic(address), sizeof address) != 0 ||
      ::listen(listener.get(), 8) != 0) {
    throw DeviceError(fmt::format("virtual stand: cannot listen on {}:{}: {}. Choose another port.",
                                  host, port, std::strerror(errno)));
  }
  return listener;
}

int PortOf(int socket) {
  sockaddr_in address = {};
  socklen_t size = sizeof address;
  ::getsockname(socket, Generic(address), &size);
  return ntohs(address.sin_port);
}

}  // namespace

TcpServer::TcpServer(std::unique_ptr<Responder> responder, const std::string& host, int port)
    : BusServer(std::move(responder)),
      listener_(Listen(host, port)),
      port_(PortOf(listener_.get())) {}

void TcpServer::Serve() {
  std::array<pollfd, kMostClients + 2> waits = {};
  while (!stopping()) {
    waits[0] = {.fd = stop_event(), .events = POLLIN, .revents = 0};
    waits[1] = {.fd = listener_.get(), .events = POLLIN, .revents = 0};
    for (std::size_t i = 0; i < kMostClients; ++i) {
      // cppcheck-suppress containerOutOfBounds ; it takes kMostClients + 2 for kMostClients
      waits[2 + i] = {.fd = clients_[i].socket.get(), .events = POLLIN, .revents = 0};
    }
    if (::poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR) return;
    for (std::size_t i = 0; i < kMostClients; ++i) {
      if (waits[2 + i].revents != 0) Receive(clients_[i]);
    }
    if (waits[1].revents != 0) Accept();
  }
}

void TcpServer::Accept() {
  Descriptor socket(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!socket) return;
  const int on = 1;
  ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  const auto free = std::ranges::find_if(clients_, [](const Client& c) { return !c.socket; });
  if (free == clients_.end()) return;  // closes it
  free->socket = std::move(socket);
  free->held = 0;
}

void TcpServer::Receive(Client& client) {
  const auto count = ::recv(client.socket.get(), client.input.data() + client.held,
                            client.input.size() - client.held, 0);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    client.socket = Descriptor();
    return;
  }
  client.held += static_cast<std::size_t>(count);
  if (!Handle(client)) client.socket = Descriptor();
}

// False: the connection cannot be understood any more.
bool TcpServer::Handle(Client& client) {
  while (client.held > 0) {
    const auto frame = FirstTcpFrame({client.input.data(), client.held});
    if (!frame) return true;
    if (!frame->sound) {
      responder().FrameRejected();
      return false;
    }
    if (!Answer(*frame, client.socket.get())) return false;
    std::copy(client.input.begin() + static_cast<std::ptrdiff_t>(frame->size),
              client.input.begin() + static_cast<std::ptrdiff_t>(client.held),
              client.input.begin());
    client.held -= frame->size;
  }
  return true;
}

bool TcpServer::Answer(const Frame& frame, int socket) {
  const auto pdu = std::span(output_).subspan(kHeader, kMaxPdu);
  const auto answer = responder().Respond(frame.unit, frame.pdu, frame.size, kHeader, pdu);
  if (answer.size == 0) return true;
  const auto put = [this](std::size_t i, std::size_t word) {
    output_[i] = static_cast<std::uint8_t>(word >> 8U);
    output_[i + 1] = static_cast<std::uint8_t>(word & 0xFFU);
  };
  const std::size_t answered = frame.transaction - (answer.stale ? 1U : 0U);
  put(0, answer.spoiled ? answered ^ 0x5AU : answered);
  put(2, answer.garbage ? 0xDEADU : 0U);
  put(4, answer.size + 1);
  output_[6] = frame.unit;
  return ::send(socket, output_.data(), kHeader + answer.size, MSG_NOSIGNAL) > 0;
}

}  // namespace gyrobench::stand
