#include "tests/daemon/published.h"

#include "recording/event_log.h"

namespace gyrobench::daemon {

std::vector<Published> EventsOf(const std::filesystem::path& log) {
  std::vector<Published> events;
  recording::EventLogReader reader(log);
  for (recording::LogEvent event; reader.Next(event);) {
    events.push_back({std::string(event.channel), {event.data.begin(), event.data.end()}});
  }
  return events;
}

}  // namespace gyrobench::daemon
