#include "tests/daemon/published.h"

#include "recording/event_log.h"
#include "recording/sender.h"

namespace gyrobench::daemon {

std::vector<Published> EventsOf(const std::filesystem::path& log) {
  std::vector<Published> events;
  recording::EventLogReader reader(log);
  for (recording::LogEvent event; reader.Next(event);) {
    const bool is_signed = recording::SenderOf(event.data).has_value();
    const std::size_t behind = is_signed ? recording::SenderBytes().size() : 0;
    events.push_back(
        {std::string(event.channel),
         {event.data.begin(), event.data.end() - static_cast<std::ptrdiff_t>(behind)}});
  }
  return events;
}

}  // namespace gyrobench::daemon
