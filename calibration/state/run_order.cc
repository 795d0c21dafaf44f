#include "calibration/state/run_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace gyrobench::calibration {
namespace {

bool Before(const Recording& a, const Recording& b) {
  const auto key = [](const Recording& recording) {
    return std::tie(recording.info.power_on, recording.first_time_s, recording.last_time_s,
                    recording.info.source, recording.samples);
  };
  if (key(a) != key(b)) return key(a) < key(b);
  // Files of one name, one length: what they hold.
  const std::vector<Node>&x = a.columns.nodes, &y = b.columns.nodes;
  return std::lexicographical_compare(
      x.begin(), x.end(), y.begin(), y.end(),
      [](const Node& one, const Node& other) { return one.at.z < other.at.z; });
}

// Runs [begin, end) are of one power-on.
void PlaceRestarts(std::span<const Recording* const> recordings, std::size_t begin, std::size_t end,
                   std::vector<OrderedRun>* runs, std::vector<std::string>* remarks) {
  const auto run = [&](std::size_t k) -> const Recording& { return *recordings[(*runs)[k].index]; };
  for (std::size_t k = begin + 1; k < end; ++k) {
    if (run(k).first_time_s >= run(k - 1).last_time_s) continue;
    remarks->push_back(fmt::format(
        "{} and {} say power-on {} and overlap in time, so that their times do not count from it: "
        "each of its measurements is taken to begin with a power-on",
        run(k - 1).info.source, run(k).info.source, run(k).info.power_on));
    return;
  }
  for (std::size_t k = begin + 1; k < end; ++k) (*runs)[k].restart = false;
}

}  // namespace

std::vector<OrderedRun> OrderRuns(std::span<const Recording* const> recordings,
                                  std::vector<std::string>* remarks) {
  std::vector<OrderedRun> runs;
  for (std::size_t i = 0; i < recordings.size(); ++i) runs.push_back({i, true});
  std::sort(runs.begin(), runs.end(), [&](const OrderedRun& a, const OrderedRun& b) {
    return Before(*recordings[a.index], *recordings[b.index]);
  });
  const auto power_on = [&](std::size_t k) -> const std::string& {
    return recordings[runs[k].index]->info.power_on;
  };
  for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
    for (end = begin + 1; end < runs.size() && power_on(end) == power_on(begin);) ++end;
    if (!power_on(begin).empty()) PlaceRestarts(recordings, begin, end, &runs, remarks);
  }
  return runs;
}

}  // namespace gyrobench::calibration
