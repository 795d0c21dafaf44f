// How long `gyrobench trace` takes, the reading of its tables included: against the length of a
// table, and of many tables together against each alone. Wall time is what a user waits for;
// processor time, of all threads together, is what other work on the machine changes least.
//
//   bench_trace_speed [--quick]
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "recording/table_writer.h"
#include "tests/blind_trials/trial.h"

namespace {

using namespace gyrobench::blind_trials;
namespace fs = std::filesystem;

// Of a table of 38 minutes at 100 Hz with three channels: wall time on two cores.
constexpr double kMinutes = 38.0, kTarget_s = 1.5;
// Of so many tables together: processor time over the mean of one alone.
constexpr int kTogether = 10;

// A folder of its own, that is gone at the end.
class Tables {
 public:
  Tables() {
    std::string name = (fs::temp_directory_path() / "trace_speed_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for tables");
    folder_ = name;
  }
  ~Tables() { fs::remove_all(folder_); }
  Tables(const Tables&) = delete;
  Tables& operator=(const Tables&) = delete;

  // All three channels; `minutes` of the full sequence, over and over.
  std::string Write(double minutes, std::uint64_t run) {
    const fs::path file = folder_ / fmt::format("{:.0f}_{}.csv", minutes, run);
    gyrobench::recording::TableWriter writer(file);
    Cut cut(writer, 60.0 * minutes);
    TrialSpec spec = {
        .seed = 7, .run = run, .effects = {{"scale.cubic", kMid}}, .all_channels = true};
    spec.name = fmt::format("recording {}", run);
    spec.repeats = minutes > 40.0 ? 2 : 1;
    RecordTrial(spec, cut);
    writer.Close();
    return file.string();
  }

 private:
  class Cut : public gyrobench::MeasurementSink {
   public:
    Cut(gyrobench::MeasurementSink& sink, double end_s) : sink_(sink), end_s_(end_s) {}
    void OnInfo(const gyrobench::MeasurementInfo& info) override { sink_.OnInfo(info); }
    void OnGyro(const gyrobench::GyroSample& s) override {
      if (s.t_s <= end_s_) sink_.OnGyro(s);
    }
    void OnCovariates(double t_s, std::span<const double> values) override {
      if (t_s <= end_s_) sink_.OnCovariates(t_s, values);
    }
    void OnAngle(const gyrobench::AngleSample& s) override {
      if (s.t_s <= end_s_) sink_.OnAngle(s);
    }
    void OnOrientation(const gyrobench::OrientationSample& s) override { sink_.OnOrientation(s); }
    void OnTickPair(const gyrobench::TickPair& pair) override {
      if (pair.host_s <= end_s_) sink_.OnTickPair(pair);
    }
    void OnSegment(const gyrobench::SegmentMark& mark) override {
      if (mark.end_s <= end_s_) sink_.OnSegment(mark);
    }
    void OnDefect(const gyrobench::Defect& defect) override { sink_.OnDefect(defect); }

   private:
    gyrobench::MeasurementSink& sink_;
    double end_s_;
  };

  fs::path folder_;
};

struct Cost {
  double wall_s = 0.0, processor_s = 0.0, peak_MB = 0.0;
};

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// The program beside this one, as a user runs it.
Cost Trace(const std::vector<std::string>& tables) {
  const std::string program =
      (fs::read_symlink("/proc/self/exe").parent_path() / "gyrobench").string();
  std::vector<std::string> words = {program, "trace", "--json", "--quiet", "--seed", "1"};
  words.insert(words.end(), tables.begin(), tables.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  const auto begin = std::chrono::steady_clock::now();
  pid_t child = 0;
  const int failed =
      posix_spawn(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error("cannot run " + program);
  int status = 0;
  rusage usage = {};
  wait4(child, &status, 0, &usage);
  if (status != 0) throw std::runtime_error(program + " trace failed");
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  return {wall.count(), Seconds(usage.ru_utime) + Seconds(usage.ru_stime),
          static_cast<double>(usage.ru_maxrss) / 1024.0};
}

void Print(const std::string& what, const Cost& cost, const std::string& target = "") {
  fmt::print("{:<40} {:>9.2f} {:>12.2f} {:>9.0f}{}\n", what, cost.wall_s, cost.processor_s,
             cost.peak_MB, target);
}

void ByLength(bool quick) {
  Tables tables;
  for (const double minutes : {19.0, kMinutes, 76.0}) {
    if (quick && minutes > 20.0) break;
    Print(fmt::format("{:.0f} min", minutes), Trace({tables.Write(minutes, 7)}),
          minutes == kMinutes ? fmt::format("  (target {:.1f} s of wall time)", kTarget_s) : "");
  }
}

// As many samples in four times as many power-ons, each of which has an offset in every model.
void InShortTables(int count) {
  Tables tables;
  std::vector<std::string> all;
  for (int i = 0; i < 4 * count; ++i)
    all.push_back(tables.Write(kMinutes / 4.0, 200U + static_cast<std::uint64_t>(i)));
  Print(fmt::format("{} of {:.1f} min together", 4 * count, kMinutes / 4.0), Trace(all));
}

void Together(int count) {
  Tables tables;
  std::vector<std::string> all;
  Cost one;
  for (int i = 0; i < count; ++i) {
    all.push_back(tables.Write(kMinutes, 100U + static_cast<std::uint64_t>(i)));
    const Cost alone = Trace({all.back()});
    one.wall_s += alone.wall_s / count;
    one.processor_s += alone.processor_s / count;
    one.peak_MB = std::max(one.peak_MB, alone.peak_MB);
  }
  Print(fmt::format("each of {} of {:.0f} min alone, mean", count, kMinutes), one);
  const Cost together = Trace(all);
  Print(fmt::format("{} together", count), together);
  fmt::print(
      "{} together over one alone: {:.1f} of processor time (target {}), {:.1f} of wall time\n",
      count, together.processor_s / one.processor_s, count, together.wall_s / one.wall_s);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
    fmt::print("{} cores\n{:<40} {:>9} {:>12} {:>9}\n", std::thread::hardware_concurrency(),
               "3 channels, 100 Hz, reading included", "wall s", "processor s", "peak MB");
    ByLength(quick);
    Together(quick ? 2 : kTogether);
    InShortTables(quick ? 2 : kTogether);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_trace_speed: %s\n", error.what());
    return 1;
  }
}
