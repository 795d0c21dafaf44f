// A Modbus line with a mind of its own: a server over a pseudo-terminal or loopback TCP, written
// without libmodbus, that answers as its devices say, or as badly as it is told.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"

namespace gyrobench {

using Bytes = std::vector<std::uint8_t>;
using Words = std::vector<std::uint16_t>;
using Transport = config::BusConfig::Transport;

// CRC-16 of Modbus RTU, bit by bit from its definition (polynomial 0xA001 reflected, start 0xFFFF).
std::uint16_t ModbusCrc(const Bytes& bytes);

// Thrown by a device that refuses.
struct ModbusException {
  int code;
};

// What is behind a unit number. Called by the line's thread.
class FakeUnit {
 public:
  virtual ~FakeUnit() = default;
  virtual Words Read(int function, std::uint16_t address, std::uint16_t count) = 0;
  virtual void Write(std::uint16_t address, const Words& values) = 0;
};

// Plain registers; those that were never set are illegal addresses.
class RegisterUnit : public FakeUnit {
 public:
  Words Read(int function, std::uint16_t address, std::uint16_t count) override;
  void Write(std::uint16_t address, const Words& values) override;
  void SetHolding(std::uint16_t address, const Words& values);
  void SetInput(std::uint16_t address, const Words& values);
  std::uint16_t Holding(std::uint16_t address) const;
  // `act` is called after a write, with the registers as they are then and the lock held.
  using Registers = std::map<std::uint16_t, std::uint16_t>;
  using Action =
      std::function<void(std::uint16_t address, const Words& values, Registers& holding)>;
  void OnWrite(Action act);

 protected:
  mutable std::mutex mutex_;

 private:
  Registers holding_, input_;
  Action on_write_ = [](std::uint16_t, const Words&, Registers&) {};
};

struct LineFault {
  enum Kind {
    kNone,
    kLostRequest,  // the unit never hears of it
    kLostReply,    // the unit acts, nobody hears
    kLate,         // reply after `value` microseconds of bench time
    kHeld,         // reply kept, and sent right before the next one or by ReleaseHeld
    kTruncated,    // half a reply
    kBadChecksum,  // RTU: CRC; TCP: transaction number
    kWrongUnit,
    kWrongFunction,
    kWrongLength,  // one register too few
    kException,    // code `value`, and the unit does not act
    kExtraAfter,   // reply, and in the same breath one of the same form with other values
    kRepeatOld,    // the frame before instead of this one's (TCP: with its transaction number)
    kGarbage,
    kDisconnect,  // TCP: closes the connection instead of answering
  };
  Kind kind = kNone;
  int value = 0;
};

class FakeLine {
 public:
  explicit FakeLine(Transport transport);
  ~FakeLine();
  FakeLine(const FakeLine&) = delete;
  FakeLine& operator=(const FakeLine&) = delete;

  // A bus named A that leads here.
  config::BusConfig Config() const { return config_; }
  // `device` outlives the line; units without a device are silent. `baud`: the device is set to this
  // rate, and hears nothing while the serial line has another; 0: it follows the line.
  void Connect(int unit, FakeUnit& device, int baud = 0);
  // How a late reply lets bench time pass.
  void SetDelay(std::function<void(Utime)> delay);
  // Every request comes back to who sent it, before the answer, as by an adapter that hears itself.
  void Echo() { echoes_ = true; }
  // What happens to the next requests, one each, in this order.
  void Inject(LineFault::Kind kind, int value = 0, int times = 1);
  void ReleaseHeld();
  // Pulls the plug: the far end of the line is gone for good.
  void Unplug();
  // Requests as they came, RTU: with unit and CRC; TCP: from the unit number on.
  std::vector<Bytes> requests() const;

 private:
  struct Client {
    int fd;
    Bytes received;
  };

  void OpenPty();
  void OpenTcp();
  void Run();
  void Accept();
  bool Receive(Client& client);
  LineFault NextFault(const Bytes& body);
  // Length of the whole request at the start of `bytes`, 0 while it is not complete.
  std::size_t RequestLength(const Bytes& bytes) const;
  // False when the client is to be dropped.
  bool Answer(Client& client, const Bytes& request);
  Bytes Pdu(int unit, const Bytes& pdu, bool& silent);
  void Delay(Utime duration_us);
  static void Spoil(const LineFault& fault, int& unit, Bytes& pdu);
  void SpoilFrame(const LineFault& fault, Bytes& frame) const;
  Bytes Frame(const Bytes& request, int unit, const Bytes& pdu) const;
  void Send(int fd, const Bytes& bytes);

  const Transport transport_;
  std::atomic<bool> echoes_ = false;
  config::BusConfig config_;
  struct Connected {
    FakeUnit* device = nullptr;
    int baud = 0;
  };
  // nullptr where nobody hears.
  FakeUnit* Listener(int unit) const;

  std::map<int, Connected> units_;
  std::function<void(Utime)> delay_ = [](Utime) {};
  int master_fd_ = -1, slave_fd_ = -1, listen_fd_ = -1, wake_fd_ = -1;
  mutable std::mutex mutex_;
  std::deque<LineFault> faults_;
  std::vector<Bytes> requests_;
  Bytes held_;
  Bytes last_frame_;
  int held_fd_ = -1;
  std::vector<Client> clients_;  // of the thread alone
  std::thread thread_;
};

}  // namespace gyrobench
