#include "stand/server/bus_server.h"

#include <sys/eventfd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace gyrobench::stand {

BusServer::BusServer(std::unique_ptr<Responder> responder)
    : responder_(std::move(responder)), stop_event_(::eventfd(0, EFD_CLOEXEC)) {
  if (!stop_event_)
    throw std::system_error(errno, std::generic_category(), "virtual stand: eventfd");
}

void BusServer::Start() {
  thread_ = std::thread([this] { Serve(); });
}

void BusServer::Stop() {
  stopping_ = true;
  responder_->Stop();
  const std::uint64_t one = 1;
  // An event counter takes it always.
  [[maybe_unused]] const auto written = ::write(stop_event_.get(), &one, sizeof one);
  if (thread_.joinable()) thread_.join();
}

}  // namespace gyrobench::stand
