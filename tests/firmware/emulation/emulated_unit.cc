#include "tests/firmware/emulation/emulated_unit.h"

extern "C" {
#include <simavr/avr_ioport.h>
#include <simavr/avr_twi.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_irq.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <utility>

namespace gyrobench::firmware {
namespace {

constexpr double kFrequency_hz = 16e6;
constexpr std::uint8_t kSensorAddress = 0x68;
constexpr int kIntPin = 2, kDirectionPin = 3, kDefaultsPin = 4;  // of port D
constexpr int kSdaPin = 4, kSclPin = 5;                          // of port C
constexpr double kPulse_s = 50e-6;                               // of the sensor's INT
constexpr std::uint16_t kDdrC = 0x27, kTwsr = 0xB9;
constexpr double kBitsOfCharacter = 10.0;
// main.c: what memory that was never written keeps, and how far from the end of it is painted.
constexpr std::uint8_t kUntouched = 0xC5;

// simavr's macros make an int of what its functions take as unsigned.
constexpr std::uint32_t Ioctl(int code) { return static_cast<std::uint32_t>(code); }

}  // namespace

struct EmulatedUnit::Impl {
  Impl(const std::filesystem::path& elf, VirtualMpu6050& its_sensor, double resonator_rel)
      : sensor(its_sensor), cycles_per_s(kFrequency_hz * (1.0 + resonator_rel)) {
    elf_firmware_t firmware = {};
    if (elf_read_firmware(elf.c_str(), &firmware) != 0)
      throw std::runtime_error("the image " + elf.string() + " cannot be read");
    end_of_data = firmware.datasize + firmware.bsssize;
    avr = avr_make_mcu_by_name("atmega328p");
    if (avr == nullptr) throw std::runtime_error("simavr knows no ATmega328P");
    avr_init(avr);
    avr->frequency = static_cast<std::uint32_t>(kFrequency_hz);
    avr->log = LOG_NONE;
    avr_load_firmware(avr, &firmware);
    // Which logs what its image lacks.
    avr->log = LOG_NONE;
    Connect();
  }
  ~Impl() { avr_terminate(avr); }

  double now_s() const { return static_cast<double>(avr->cycle) / cycles_per_s; }
  avr_cycle_count_t CycleAt(double t_s) const {
    return static_cast<avr_cycle_count_t>(std::llround(t_s * cycles_per_s));
  }

  avr_irq_t* Pin(char port, int pin) {
    return avr_io_getirq(avr, Ioctl(AVR_IOCTL_IOPORT_GETIRQ(port)), pin);
  }

  template <class Part>
  Part* Find(const char* kind) {
    for (avr_io_t* io = avr->io_port; io != nullptr; io = io->next) {
      if (std::strcmp(io->kind, kind) == 0) return reinterpret_cast<Part*>(io);
    }
    throw std::runtime_error(std::string("simavr has no ") + kind);
  }

  void Connect() {
    std::uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~static_cast<std::uint32_t>(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    uart = Find<avr_uart_t>("uart");
    Find<avr_twi_t>("twi")->twi.raise_sticky = 0;
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), OnSent,
                            this);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_OUTPUT), OnBus,
                            this);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_STATUS), OnStatus,
                            this);
    avr_irq_register_notify(Pin('D', kDirectionPin), OnDirection, this);
    avr_irq_register_notify(
        avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('C'), IOPORT_IRQ_DIRECTION_ALL), OnDirectionC,
        this);
    SetPins();
  }

  // simavr passes changes on, and a reset changes what the processor sees and not what was told.
  void SetPin(char port, int pin, bool high) {
    avr_raise_irq(Pin(port, pin), high ? 0 : 1);
    avr_raise_irq(Pin(port, pin), high ? 1 : 0);
  }

  // Beside the processor's own pull-ups, which simavr else lets win.
  void PullFromOutside(char port, unsigned mask, unsigned value) {
    avr_ioport_external_t outside = {};
    outside.name = static_cast<unsigned char>(port) & 0x7F;
    outside.mask = mask & 0xFF;
    outside.value = value & 0xFF;
    avr_ioctl(avr, Ioctl(AVR_IOCTL_IOPORT_SET_EXTERNAL(port)), &outside);
  }

  // The pull-ups of the two-wire bus, and what the sensor does to SDA.
  void SetLines() {
    const bool held = clocks_to_free > 0;
    PullFromOutside('C', 1U << kSdaPin | 1U << kSclPin,
                    held ? 1U << kSclPin : 1U << kSdaPin | 1U << kSclPin);
    SetPin('C', kSclPin, !scl_low);
    SetPin('C', kSdaPin, !held);
  }

  // Pull-ups and what is wired, which a reset forgets.
  void SetPins() {
    PullFromOutside('D', 1U << kDefaultsPin, defaults_asked ? 0 : 1U << kDefaultsPin);
    SetLines();
    SetPin('D', kDefaultsPin, !defaults_asked);
  }

  static Impl& Of(void* param) { return *static_cast<Impl*>(param); }

  static void OnSent(avr_irq_t*, std::uint32_t value, void* param) {
    Impl& self = Of(param);
    // Of simavr's one buffer: the byte goes out from here on.
    const double begin_s = std::max(self.now_s(), self.line_free_s);
    self.line_free_s =
        begin_s + static_cast<double>(self.uart->cycles_per_byte) / self.cycles_per_s;
    self.sent.push_back({static_cast<std::uint8_t>(value), self.line_free_s});
  }

  static void OnDirection(avr_irq_t*, std::uint32_t value, void* param) {
    Of(param).sends = value != 0;
  }

  void TellBus(std::uint8_t what, std::uint8_t address, std::uint8_t data) {
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_INPUT),
                  avr_twi_irq_msg(what, address, data));
  }

  static void OnBus(avr_irq_t*, std::uint32_t value, void* param) {
    Impl& self = Of(param);
    avr_twi_msg_irq_t message;
    message.u.v = value;
    const auto address = static_cast<std::uint8_t>(message.u.twi.addr);
    const bool ours =
        address >> 1 == kSensorAddress && self.sensor.present() && self.clocks_to_free == 0;
    if ((message.u.twi.msg & TWI_COND_START) != 0) {
      self.address_was_sent = (address & 1) == 0;
      if (!ours) return;
      if ((address & 1) == 0) self.sensor.Begin();
      self.TellBus(TWI_COND_ACK, address, 1);
    } else if (ours && (message.u.twi.msg & TWI_COND_WRITE) != 0) {
      self.sensor.Write(static_cast<std::uint8_t>(message.u.twi.data), self.now_s());
      self.Schedule();
      self.TellBus(TWI_COND_ACK, address, 1);
    } else if ((message.u.twi.msg & TWI_COND_READ) != 0) {
      // Of a line that is held low the master reads zeros.
      self.TellBus(TWI_COND_READ, address, ours ? self.sensor.Read() : 0);
    }
  }

  static void OnStatus(avr_irq_t*, std::uint32_t value, void* param) {
    Impl& self = Of(param);
    const auto status = static_cast<std::uint8_t>(value & 0xF8);
    if (!self.address_was_sent || (status != 0x28 && status != 0x30)) return;
    self.address_was_sent = false;
    std::uint8_t& twsr = self.avr->data[kTwsr];
    twsr = static_cast<std::uint8_t>((twsr & 0x07) | (status == 0x28 ? 0x18 : 0x20));
  }

  // SCL is pulled low by its direction.
  static void OnDirectionC(avr_irq_t*, std::uint32_t value, void* param) {
    Impl& self = Of(param);
    const bool low = (value >> kSclPin & 1) != 0;
    const bool falls = low && !self.scl_low;
    self.scl_low = low;
    if (falls && self.clocks_to_free > 0 && --self.clocks_to_free == 0) self.SetLines();
  }

  // Its next sample, by the cycle at which it is ready.
  void Schedule() {
    avr_cycle_timer_cancel(avr, OnReady, this);
    const auto next_s = sensor.next_ready_s();
    if (!next_s) return;
    const avr_cycle_count_t at = CycleAt(*next_s);
    avr_cycle_timer_register(avr, at > avr->cycle ? at - avr->cycle : 1, OnReady, this);
  }

  static avr_cycle_count_t OnReady(avr_t*, avr_cycle_count_t, void* param) {
    Impl& self = Of(param);
    if (!self.sensor.next_ready_s()) return 0;
    self.sensor.MakeReady();
    avr_raise_irq(self.Pin('D', kIntPin), 1);
    avr_cycle_timer_register(self.avr, self.CycleAt(kPulse_s), OnPulseEnd, param);
    const auto next_s = self.sensor.next_ready_s();
    return next_s ? self.CycleAt(*next_s) : 0;
  }

  static avr_cycle_count_t OnPulseEnd(avr_t*, avr_cycle_count_t, void* param) {
    avr_raise_irq(Of(param).Pin('D', kIntPin), 0);
    return 0;
  }

  // A character is in the receiver at its end; simavr takes a character's time from when it is
  // told.
  static avr_cycle_count_t OnCharacter(avr_t*, avr_cycle_count_t, void* param) {
    Impl& self = Of(param);
    avr_raise_irq(avr_io_getirq(self.avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT),
                  self.to_send.front());
    self.to_send.pop_front();
    self.next_character += self.character_cycles;
    return self.to_send.empty() ? 0
                                : static_cast<avr_cycle_count_t>(std::llround(self.next_character));
  }

  // Of ten bits; simavr counts eleven whenever the rate is written.
  void MendCharacter() {
    const int divisor = avr->data[0xC4] | (avr->data[0xC5] & 0x0F) << 8;
    uart->cycles_per_byte = static_cast<avr_cycle_count_t>(kBitsOfCharacter * 8 * (divisor + 1));
  }

  VirtualMpu6050& sensor;
  const double cycles_per_s;
  avr_t* avr = nullptr;
  avr_uart_t* uart = nullptr;
  std::size_t end_of_data = 0;
  std::deque<std::uint8_t> to_send;
  double character_cycles = 0.0, next_character = 0.0;
  std::vector<Byte> sent;
  double line_free_s = 0.0;
  bool sends = false, defaults_asked = false, address_was_sent = false, scl_low = false;
  int clocks_to_free = 0;
};

EmulatedUnit::EmulatedUnit(const std::filesystem::path& elf, VirtualMpu6050& sensor,
                           double resonator_rel)
    : impl_(std::make_unique<Impl>(elf, sensor, resonator_rel)) {}

EmulatedUnit::~EmulatedUnit() = default;

double EmulatedUnit::now_s() const { return impl_->now_s(); }

void EmulatedUnit::RunUntil(double t_s) {
  const avr_cycle_count_t end = impl_->CycleAt(t_s);
  while (impl_->avr->cycle < end) {
    const int state = avr_run(impl_->avr);
    if (state == cpu_Done || state == cpu_Crashed)
      throw std::runtime_error("the emulated processor has stopped");
  }
}

void EmulatedUnit::Send(std::span<const std::uint8_t> bytes, int baud) {
  if (bytes.empty()) return;
  const bool busy = !impl_->to_send.empty();
  impl_->to_send.insert(impl_->to_send.end(), bytes.begin(), bytes.end());
  if (busy) return;
  impl_->MendCharacter();
  impl_->character_cycles = impl_->cycles_per_s * kBitsOfCharacter / baud;
  // What simavr takes from then on is the first character's own time.
  impl_->next_character = static_cast<double>(impl_->avr->cycle) + 1.0;
  avr_cycle_timer_register(impl_->avr, 1, Impl::OnCharacter, impl_.get());
}

std::vector<EmulatedUnit::Byte> EmulatedUnit::TakeSent() { return std::exchange(impl_->sent, {}); }

void EmulatedUnit::Reset() {
  avr_reset(impl_->avr);
  impl_->to_send.clear();
  avr_cycle_timer_cancel(impl_->avr, Impl::OnCharacter, impl_.get());
  impl_->Schedule();
  impl_->SetPins();
}

void EmulatedUnit::SetDefaultsPin(bool to_ground) {
  impl_->defaults_asked = to_ground;
  impl_->SetPins();
}

void EmulatedUnit::HoldSda(int clocks) {
  impl_->clocks_to_free = clocks;
  impl_->SetLines();
}

std::size_t EmulatedUnit::StackLeft() const {
  const std::uint8_t* memory = impl_->avr->data;
  const std::size_t begin = 0x100 + impl_->end_of_data;
  std::size_t at = begin;
  while (at < impl_->avr->ramend && memory[at] == kUntouched) ++at;
  return at - begin;
}

bool EmulatedUnit::sends() const { return impl_->sends; }

}  // namespace gyrobench::firmware
