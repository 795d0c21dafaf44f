#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>

#include "stand/server/bus_server.h"
#include "stand/server/modbus.h"

namespace gyrobench::stand {
namespace {

// Real time after which the rest of a frame will not come any more.
constexpr int kFrameTimeout_ms = 50;
constexpr std::size_t kOverhead = 3;  // unit and checksum

[[noreturn]] void Fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), "virtual stand: " + what);
}

}  // namespace

RtuServer::RtuServer(std::unique_ptr<Responder> responder) : BusServer(std::move(responder)) {
  int master = -1;
  int slave = -1;
  std::array<char, 64> name = {};
  termios raw = {};
  cfmakeraw(&raw);
  if (::openpty(&master, &slave, name.data(), &raw, nullptr) != 0) Fail("no pseudo-terminal");
  master_ = Descriptor(master);
  slave_ = Descriptor(slave);
  device_ = name.data();
  // A client that does not read must not hold the server.
  if (::fcntl(master, F_SETFL, O_NONBLOCK) != 0 || ::fcntl(master, F_SETFD, FD_CLOEXEC) != 0 ||
      ::fcntl(slave, F_SETFD, FD_CLOEXEC) != 0) {
    Fail("pseudo-terminal " + device_);
  }
}

void RtuServer::Serve() {
  std::array<pollfd, 2> waits = {pollfd{.fd = master_.get(), .events = POLLIN, .revents = 0},
                                 pollfd{.fd = stop_event(), .events = POLLIN, .revents = 0}};
  while (!stopping()) {
    const int ready = ::poll(waits.data(), waits.size(), held_ > 0 ? kFrameTimeout_ms : -1);
    if (ready < 0 && errno != EINTR) return;
    if (ready == 0) {
      held_ = 0;
      responder().FrameRejected();
    }
    if ((waits[0].revents & POLLIN) != 0 && Receive()) Handle();
  }
}

bool RtuServer::Receive() {
  const auto count = ::read(master_.get(), input_.data() + held_, input_.size() - held_);
  if (count <= 0) return false;
  held_ += static_cast<std::size_t>(count);
  return true;
}

void RtuServer::Handle() {
  while (held_ > 0) {
    const auto frame = FirstRtuFrame({input_.data(), held_});
    if (!frame) {
      if (held_ == input_.size()) held_ = 0;
      return;
    }
    if (frame->sound) {
      Answer(*frame);
    } else {
      responder().FrameRejected();
    }
    std::copy(input_.begin() + static_cast<std::ptrdiff_t>(frame->size),
              input_.begin() + static_cast<std::ptrdiff_t>(held_), input_.begin());
    held_ -= frame->size;
  }
}

void RtuServer::Answer(const Frame& frame) {
  const auto pdu = std::span(output_).subspan(1, kMaxPdu);
  const auto answer = responder().Respond(frame.unit, frame.pdu, frame.size, kOverhead, pdu);
  if (answer.size == 0) return;
  output_[0] = frame.unit;
  std::size_t size = answer.size + 1;
  if (!answer.garbage) {
    const std::uint16_t crc = Crc16({output_.data(), size});
    output_[size++] = static_cast<std::uint8_t>((crc & 0xFFU) ^ (answer.spoiled ? 0xA5U : 0U));
    output_[size++] = static_cast<std::uint8_t>(crc >> 8U);
  }
  // Bytes that the client does not take are lost, as on a wire.
  [[maybe_unused]] const auto written = ::write(master_.get(), output_.data(), size);
}

}  // namespace gyrobench::stand
