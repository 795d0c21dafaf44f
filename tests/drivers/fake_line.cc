#include "tests/drivers/fake_line.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace gyrobench {
namespace {

void Check(bool good, const char* what) {
  if (!good) throw std::runtime_error(std::string("fake line: ") + what);
}

std::uint16_t WordAt(const Bytes& bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

void Append(Bytes& bytes, std::uint16_t word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
}

// 0 for a rate that no test uses.
speed_t SpeedOf(int baud) {
  if (baud == 9600) return B9600;
  if (baud == 19200) return B19200;
  return baud == 115200 ? B115200 : speed_t{0};
}

}  // namespace

std::uint16_t ModbusCrc(const Bytes& bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xA001 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

Words RegisterUnit::Read(int function, std::uint16_t address, std::uint16_t count) {
  const std::lock_guard lock(mutex_);
  const Registers& registers = function == 3 ? holding_ : input_;
  Words words;
  for (int i = 0; i < count; ++i) {
    const auto found = registers.find(static_cast<std::uint16_t>(address + i));
    if (found == registers.end()) throw ModbusException{2};
    words.push_back(found->second);
  }
  return words;
}

void RegisterUnit::Write(std::uint16_t address, const Words& values) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    holding_[static_cast<std::uint16_t>(address + i)] = values[i];
  }
  on_write_(address, values, holding_);
}

void RegisterUnit::OnWrite(Action act) {
  const std::lock_guard lock(mutex_);
  on_write_ = std::move(act);
}

void RegisterUnit::SetHolding(std::uint16_t address, const Words& values) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    holding_[static_cast<std::uint16_t>(address + i)] = values[i];
  }
}

void RegisterUnit::SetInput(std::uint16_t address, const Words& values) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    input_[static_cast<std::uint16_t>(address + i)] = values[i];
  }
}

std::uint16_t RegisterUnit::Holding(std::uint16_t address) const {
  const std::lock_guard lock(mutex_);
  return holding_.at(address);
}

FakeLine::FakeLine(Transport transport) : transport_(transport) {
  config_.name = "A";
  config_.transport = transport;
  wake_fd_ = eventfd(0, EFD_CLOEXEC);
  Check(wake_fd_ >= 0, "eventfd");
  transport == Transport::kRtu ? OpenPty() : OpenTcp();
  thread_ = std::thread([this] { Run(); });
}

FakeLine::~FakeLine() {
  Unplug();
  close(wake_fd_);
}

void FakeLine::Unplug() {
  if (!thread_.joinable()) return;
  const std::uint64_t one = 1;
  if (write(wake_fd_, &one, sizeof one) != sizeof one) std::abort();
  thread_.join();
  for (const Client& client : clients_) {
    if (client.fd != master_fd_) close(client.fd);
  }
  clients_.clear();
  for (const int fd : {master_fd_, slave_fd_, listen_fd_}) {
    if (fd >= 0) close(fd);
  }
}

void FakeLine::OpenPty() {
  master_fd_ = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  Check(master_fd_ >= 0 && grantpt(master_fd_) == 0 && unlockpt(master_fd_) == 0, "openpt");
  char path[64] = {};
  Check(ptsname_r(master_fd_, path, sizeof path) == 0, "ptsname");
  config_.device = path;
  // Held open, so that the master does not see a hang-up while the driver reopens.
  slave_fd_ = open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
  Check(slave_fd_ >= 0, "open slave");
  termios settings = {};
  tcgetattr(slave_fd_, &settings);
  cfmakeraw(&settings);
  tcsetattr(slave_fd_, TCSANOW, &settings);
  clients_.push_back({master_fd_, {}});
}

void FakeLine::OpenTcp() {
  listen_fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* plain = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  Check(bind(listen_fd_, plain, size) == 0 && listen(listen_fd_, 8) == 0, "listen");
  Check(getsockname(listen_fd_, plain, &size) == 0, "getsockname");
  config_.host = "127.0.0.1";
  config_.port = ntohs(address.sin_port);
}

void FakeLine::Connect(int unit, FakeUnit& device, int baud) {
  const std::lock_guard lock(mutex_);
  units_[unit] = {&device, baud};
}

FakeUnit* FakeLine::Listener(int unit) const {
  const std::lock_guard lock(mutex_);
  const auto found = units_.find(unit);
  if (found == units_.end()) return nullptr;
  const auto [device, baud] = found->second;
  if (baud == 0 || transport_ == Transport::kTcp) return device;
  termios settings = {};
  tcgetattr(slave_fd_, &settings);
  return cfgetospeed(&settings) == SpeedOf(baud) ? device : nullptr;
}

void FakeLine::SetDelay(std::function<void(Utime)> delay) {
  const std::lock_guard lock(mutex_);
  delay_ = std::move(delay);
}

void FakeLine::Inject(LineFault::Kind kind, int value, int times) {
  const std::lock_guard lock(mutex_);
  for (int i = 0; i < times; ++i) faults_.push_back({kind, value});
}

std::vector<Bytes> FakeLine::requests() const {
  const std::lock_guard lock(mutex_);
  return requests_;
}

void FakeLine::ReleaseHeld() {
  const std::lock_guard lock(mutex_);
  if (held_.empty()) return;
  Send(held_fd_, held_);
  held_.clear();
  // A pty hands bytes over from a kernel thread: only what has arrived has been released.
  pollfd arrived = {slave_fd_, POLLIN, 0};
  if (transport_ == Transport::kRtu) poll(&arrived, 1, 1000);
}

void FakeLine::Run() {
  std::vector<pollfd> polled;
  while (true) {
    polled = {{wake_fd_, POLLIN, 0}, {listen_fd_, POLLIN, 0}};
    for (const Client& client : clients_) polled.push_back({client.fd, POLLIN, 0});
    if (poll(polled.data(), polled.size(), -1) < 0) continue;
    if (polled[0].revents != 0) return;
    std::vector<Client> kept;
    for (std::size_t i = 0; i < clients_.size(); ++i) {
      Client& client = clients_[i];
      if (polled[i + 2].revents == 0 || Receive(client)) {
        kept.push_back(std::move(client));
      } else {
        close(client.fd);
      }
    }
    clients_ = std::move(kept);
    if (polled[1].revents != 0) Accept();
  }
}

void FakeLine::Accept() {
  const int fd = accept4(listen_fd_, nullptr, nullptr, SOCK_CLOEXEC);
  if (fd < 0) return;
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  clients_.push_back({fd, {}});
}

bool FakeLine::Receive(Client& client) {
  std::uint8_t buffer[512];
  const ssize_t count = read(client.fd, buffer, sizeof buffer);
  if (count <= 0) return transport_ == Transport::kRtu;
  client.received.insert(client.received.end(), buffer, buffer + count);
  while (const std::size_t length = RequestLength(client.received)) {
    const auto end = client.received.begin() + static_cast<std::ptrdiff_t>(length);
    const Bytes request(client.received.begin(), end);
    client.received.erase(client.received.begin(), end);
    if (!Answer(client, request)) return false;
  }
  return true;
}

std::size_t FakeLine::RequestLength(const Bytes& bytes) const {
  std::size_t length = 0;
  if (transport_ == Transport::kTcp) {
    if (bytes.size() >= 6) length = 6U + WordAt(bytes, 4);
  } else if (bytes.size() >= 7) {
    length = bytes[1] == 16 ? 9U + bytes[6] : 8U;
  }
  return length != 0 && bytes.size() >= length ? length : 0;
}

// The answer of the unit itself, without faults of the line.
Bytes FakeLine::Pdu(int unit, const Bytes& pdu, bool& silent) {
  FakeUnit* device = Listener(unit);
  silent = device == nullptr;
  if (silent) return {};
  const int function = pdu[0];
  const std::uint16_t address = WordAt(pdu, 1);
  Bytes reply = {pdu[0]};
  try {
    if (function == 3 || function == 4) {
      const Words words = device->Read(function, address, WordAt(pdu, 3));
      reply.push_back(static_cast<std::uint8_t>(2 * words.size()));
      for (const std::uint16_t word : words) Append(reply, word);
    } else {
      Words words;
      const std::size_t first = function == 6 ? 3 : 6;
      for (std::size_t i = first; i + 1 < pdu.size(); i += 2) words.push_back(WordAt(pdu, i));
      device->Write(address, words);
      reply.assign(pdu.begin(), pdu.begin() + 5);
    }
  } catch (const ModbusException& exception) {
    reply = {static_cast<std::uint8_t>(function | 0x80), static_cast<std::uint8_t>(exception.code)};
  }
  return reply;
}

Bytes FakeLine::Frame(const Bytes& request, int unit, const Bytes& pdu) const {
  Bytes frame;
  if (transport_ == Transport::kTcp) {
    frame = {request[0], request[1], 0, 0};
    Append(frame, static_cast<std::uint16_t>(pdu.size() + 1));
  }
  frame.push_back(static_cast<std::uint8_t>(unit));
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  if (transport_ == Transport::kRtu) {
    const std::uint16_t crc = ModbusCrc(frame);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
  }
  return frame;
}

LineFault FakeLine::NextFault(const Bytes& body) {
  const std::lock_guard lock(mutex_);
  requests_.push_back(body);
  if (faults_.empty()) return {};
  const LineFault fault = faults_.front();
  faults_.pop_front();
  return fault;
}

void FakeLine::Delay(Utime duration_us) {
  std::function<void(Utime)> delay;
  {
    const std::lock_guard lock(mutex_);
    delay = delay_;
  }
  delay(duration_us);
}

// Faults of what is said.
void FakeLine::Spoil(const LineFault& fault, int& unit, Bytes& pdu) {
  if (fault.kind == LineFault::kWrongUnit) ++unit;
  if (fault.kind == LineFault::kWrongFunction) pdu[0] = static_cast<std::uint8_t>(pdu[0] ^ 0x07);
  if (fault.kind == LineFault::kWrongLength) {
    pdu.resize(pdu.size() - 2);
    pdu[1] = static_cast<std::uint8_t>(pdu[1] - 2);
  }
}

// Faults of how it is sent.
void FakeLine::SpoilFrame(const LineFault& fault, Bytes& frame) const {
  if (fault.kind == LineFault::kTruncated) frame.resize(frame.size() / 2);
  if (fault.kind == LineFault::kBadChecksum) {
    std::uint8_t& byte = transport_ == Transport::kRtu ? frame.back() : frame[0];
    byte = static_cast<std::uint8_t>(byte ^ 0x55);
  }
  if (fault.kind == LineFault::kRepeatOld) frame = last_frame_;
  if (fault.kind == LineFault::kGarbage) std::fill(frame.begin(), frame.end(), std::uint8_t{0xA5});
}

bool FakeLine::Answer(Client& client, const Bytes& request) {
  if (echoes_) Send(client.fd, request);
  const bool rtu = transport_ == Transport::kRtu;
  const Bytes body(request.begin() + (rtu ? 0 : 6), request.end());
  Bytes pdu(body.begin() + 1, body.end() - (rtu ? 2 : 0));
  int unit = body[0];
  const LineFault fault = NextFault(body);
  if (fault.kind == LineFault::kLostRequest) return true;
  bool silent = false;
  if (fault.kind == LineFault::kException) {
    pdu = {static_cast<std::uint8_t>(pdu[0] | 0x80), static_cast<std::uint8_t>(fault.value)};
  } else {
    pdu = Pdu(unit, pdu, silent);
  }
  if (silent || fault.kind == LineFault::kLostReply) return true;
  if (fault.kind == LineFault::kDisconnect) return false;
  if (fault.kind == LineFault::kLate) Delay(fault.value);
  Spoil(fault, unit, pdu);
  Bytes frame = Frame(request, unit, pdu);
  SpoilFrame(fault, frame);
  last_frame_ = frame;
  if (fault.kind == LineFault::kExtraAfter) {
    pdu.back() = static_cast<std::uint8_t>(pdu.back() + 1);
    const Bytes extra = Frame(request, unit, pdu);
    frame.insert(frame.end(), extra.begin(), extra.end());
  }
  const std::lock_guard lock(mutex_);
  held_.insert(held_.end(), frame.begin(), frame.end());
  held_fd_ = client.fd;
  if (fault.kind == LineFault::kHeld) return true;
  Send(client.fd, held_);
  held_.clear();
  return true;
}

void FakeLine::Send(int fd, const Bytes& bytes) {
  const ssize_t sent = transport_ == Transport::kTcp
                           ? send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL)
                           : write(fd, bytes.data(), bytes.size());
  // The driver may have closed its end already; then nobody hears, as on a real line.
  static_cast<void>(sent);
}

}  // namespace gyrobench
