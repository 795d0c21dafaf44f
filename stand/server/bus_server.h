// A thread that serves one bus.
#pragma once

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "stand/server/responder.h"

namespace gyrobench::stand {

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

class BusServer {
 public:
  virtual ~BusServer() = default;
  BusServer(const BusServer&) = delete;
  BusServer& operator=(const BusServer&) = delete;

  // Begins to serve; no device may be added from here on.
  void Start();

 protected:
  explicit BusServer(std::unique_ptr<Responder> responder);
  // To be called by the destructor of each server, before its parts go.
  void Stop();

  Responder& responder() { return *responder_; }
  bool stopping() const { return stopping_.load(std::memory_order_relaxed); }
  // Becomes readable when the thread is to end.
  int stop_event() const { return stop_event_.get(); }

 private:
  virtual void Serve() = 0;

  std::unique_ptr<Responder> responder_;
  Descriptor stop_event_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

// Serves a pseudo-terminal in raw mode. Its slave end stays open here, so that a client may come
// and go.
class RtuServer final : public BusServer {
 public:
  explicit RtuServer(std::unique_ptr<Responder> responder);
  ~RtuServer() override { Stop(); }
  // Path of the end that the client opens.
  const std::string& device() const { return device_; }

 private:
  void Serve() override;
  bool Receive();
  void Handle();
  void Answer(const struct Frame& frame);

  Descriptor master_, slave_;
  std::string device_;
  std::array<std::uint8_t, 512> input_;
  std::size_t held_ = 0;
  std::array<std::uint8_t, 260> output_;
};

// Serves Modbus TCP to up to kMostClients at a time.
class TcpServer final : public BusServer {
 public:
  // `port` 0: a free one. Throws DeviceError when the address cannot be had.
  TcpServer(std::unique_ptr<Responder> responder, const std::string& host, int port);
  ~TcpServer() override { Stop(); }
  int port() const { return port_; }

 private:
  static constexpr std::size_t kMostClients = 8;
  struct Client {
    Descriptor socket;
    std::array<std::uint8_t, 512> input;
    std::size_t held = 0;
  };
  void Serve() override;
  void Accept();
  void Receive(Client& client);
  bool Handle(Client& client);
  bool Answer(const struct Frame& frame, int socket);

  Descriptor listener_;
  int port_ = 0;
  std::array<Client, kMostClients> clients_;
  std::array<std::uint8_t, 300> output_;
};

}  // namespace gyrobench::stand
