// Speed and memory of reading measurement tables, next to pandas and numpy on the same files in the
// same run.
//   bench_table_reading [TABLE.csv[.gz]] [--python PROGRAM]
// Without a table: ../shared/datasets/stepper-encoder-z-slow.csv.gz where it is present. A larger
// table is made besides. Figures are of decompressed text.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "gyrobench/gyro_t.hpp"
#include "recording/event_log.h"
#include "recording/measurement_table.h"
#include "recording/replay.h"

namespace {

namespace fs = std::filesystem;
using gyrobench::recording::TableReader;
using gyrobench::recording::TableRows;

constexpr int kRepeats = 9;

// The analysis's door, adding up what comes so that nothing is optimised away.
class SumSink final : public gyrobench::MeasurementSink {
 public:
  void OnInfo(const gyrobench::MeasurementInfo&) override {}
  void OnGyro(const gyrobench::GyroSample& sample) override { sum_ += sample.xi[2] + sample.t_s; }
  void OnAngle(const gyrobench::AngleSample& sample) override { sum_ += sample.angle_deg; }
  void OnOrientation(const gyrobench::OrientationSample&) override {}
  void OnTickPair(const gyrobench::TickPair&) override {}
  void OnSegment(const gyrobench::SegmentMark&) override {}
  void OnDefect(const gyrobench::Defect&) override {}
  double sum() const { return sum_; }

 private:
  double sum_ = 0.0;
};

// Best of some repeats: time on the wall, and time of the processor, which other work on the
// machine does not lengthen as much.
struct Seconds {
  double wall = 1e300;
  double processor = 1e300;
};

Seconds Best(const std::function<void()>& work) {
  Seconds best;
  for (int i = 0; i < kRepeats; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t processor_begin = std::clock();
    work();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    best.wall = std::min(best.wall, took.count());
    best.processor = std::min(best.processor,
                              static_cast<double>(std::clock() - processor_begin) / CLOCKS_PER_SEC);
  }
  return best;
}

std::uintmax_t TextSize(const fs::path& table) {
  gzFile file = gzopen(table.c_str(), "rb");
  std::vector<char> buffer(1u << 20);
  std::uintmax_t size = 0;
  for (int got = 0;
       (got = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0;) {
    size += static_cast<std::uintmax_t>(got);
  }
  gzclose(file);
  return size;
}

void Repack(const fs::path& from, const fs::path& to, const char* mode) {
  gzFile in = gzopen(from.c_str(), "rb");
  gzFile out = gzopen(to.c_str(), mode);
  std::vector<char> buffer(1u << 20);
  for (int got = 0; (got = gzread(in, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0;) {
    gzwrite(out, buffer.data(), static_cast<unsigned>(got));
  }
  gzclose(in);
  gzclose(out);
}

// What a bench records: counts at 200 Hz, an angle in every fourth row.
void MakeTable(const fs::path& table, int rows) {
  std::ofstream out(table);
  out << "t_s,gyro_x_lsb,gyro_y_lsb,gyro_z_lsb,accel_x_g,accel_y_g,accel_z_g,temp_degC,ref_inner_"
         "deg\n";
  std::mt19937 random(1);
  const auto count = [&random] { return static_cast<int>(random() % 8000) - 4000; };
  for (int i = 0; i < rows; ++i) {
    const std::string angle = i % 4 == 0 ? fmt::format("{:.6f}", i * 0.1) : "";
    out << fmt::format("{:.6f},{},{},{},{:.6f},{:.6f},{:.6f},{:.4f},{}\n", i * 0.005, count(),
                       count(), count(), count() / 16384.0, count() / 16384.0,
                       1.0 + count() / 16384.0, 25.0 + count() * 1e-4, angle);
  }
}

void Print(const std::string& what, double text_bytes, const Seconds& seconds) {
  fmt::print("  {:<34}{:>8.1f} MB/s{:>10.1f} ms{:>10.1f} ms of the processor\n", what,
             text_bytes / seconds.wall * 1e-6, seconds.wall * 1e3, seconds.processor * 1e3);
  std::fflush(stdout);
}

void PrintRatio(const char* what, const Seconds& theirs, const Seconds& ours) {
  fmt::print("    {} is {:.1f} times as fast ({:.1f} times by the processor)\n", what,
             theirs.wall / ours.wall, theirs.processor / ours.processor);
}

struct Ours {
  Seconds reader;
  Seconds replay;
};

Ours Measure(const fs::path& table) {
  Ours ours;
  double sum = 0.0;
  ours.reader = Best([&] {
    TableReader reader(table);
    for (TableRows rows = reader.Next(); rows.count() > 0; rows = reader.Next())
      sum += rows.values[0];
  });
  ours.replay = Best([&] {
    SumSink sink;
    gyrobench::recording::ReplayTable(table, sink);
    sum += sink.sum();
  });
  if (sum == 0.0) fmt::print("(empty)\n");
  return ours;
}

double Rows(const fs::path& table) {
  TableReader reader(table);
  double count = 0.0;
  for (TableRows rows = reader.Next(); rows.count() > 0; rows = reader.Next()) {
    count += static_cast<double>(rows.count());
  }
  return count;
}

// The first Python that has both libraries: the one first in PATH may be without.
std::string FindPython(const std::string& wished) {
  for (const std::string& candidate :
       {wished, std::string("python3"), std::string("/usr/bin/python3")}) {
    if (candidate.empty()) continue;
    const std::string command = candidate + " -c 'import numpy, pandas' 2>/dev/null";
    if (std::system(command.c_str()) == 0) return candidate;
  }
  return "";
}

// As table_reading.py prints them; negative when it failed.
Seconds PythonSeconds(const std::string& python, const std::string& method, const fs::path& table) {
  const std::string command = fmt::format("{} '{}/tests/benchmarks/table_reading.py' {} '{}'",
                                          python, GYROBENCH_SOURCE_DIR, method, table.string());
  Seconds seconds;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr || std::fscanf(pipe, "%lf %lf", &seconds.wall, &seconds.processor) != 2)
    seconds = {-1.0, -1.0};
  if (pipe != nullptr) pclose(pipe);
  return seconds;
}

void Compare(const fs::path& table, const std::string& python) {
  const auto bytes = static_cast<double>(TextSize(table));
  fmt::print("{}: {:.1f} MB of text, {:.0f} rows\n", table.filename().string(), bytes * 1e-6,
             Rows(table));
  const Ours ours = Measure(table);
  Print("gyrobench TableReader", bytes, ours.reader);
  Print("gyrobench ReplayTable (to a sink)", bytes, ours.replay);
  if (python.empty()) return;
  for (const std::string method : {"pandas", "numpy"}) {
    const Seconds theirs = PythonSeconds(python, method, table);
    if (theirs.wall <= 0.0) {
      fmt::print("  {}: could not read this table\n", method);
      continue;
    }
    Print(method == "pandas" ? "pandas.read_csv (C engine)" : "numpy.loadtxt", bytes, theirs);
    PrintRatio("TableReader", theirs, ours.reader);
    PrintRatio("ReplayTable", theirs, ours.replay);
  }
}

// Peak memory of a process of its own that reads one table and does nothing else.
long PeakKilobytes(const fs::path& table) {
  const pid_t child = fork();
  if (child == 0) {
    execl("/proc/self/exe", "bench_table_reading", "--read-only", table.c_str(), nullptr);
    _exit(127);
  }
  rusage usage = {};
  int status = 0;
  wait4(child, &status, 0, &usage);
  return status == 0 ? usage.ru_maxrss : -1;
}

// Samples at 200 Hz, ten a message.
void MakeRecord(const fs::path& log, int samples) {
  constexpr int kBlock = 10;
  gyrobench::recording::EventLogWriter writer(log);
  gyrobench::gyro_t message = {};
  message.run_id = "bench";
  message.tick_rate_hz = 250'000.0;
  message.accel_lsb_per_g = 16384.0;
  message.n = kBlock;
  message.gyro_lsb.assign(3, std::vector<std::int16_t>(kBlock, 1234));
  message.accel_lsb.assign(3, std::vector<std::int16_t>(kBlock, 567));
  message.temperature_degC.assign(kBlock, 25.0F);
  message.sample_tick.resize(kBlock);
  message.sample_utime.resize(kBlock);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  for (int i = 0; i < samples; i += kBlock) {
    message.first_counter = i;
    message.utime = 1'795'000'000'000'000 + std::int64_t{5000} * i;
    for (std::size_t k = 0; k < kBlock; ++k) {
      message.sample_utime[k] = message.utime + static_cast<std::int64_t>(5000 * k);
    }
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    writer.Write("BENCH_GYRO", message.utime, bytes.data(), bytes.size());
  }
  writer.Close();
}

void CompareMemory(const fs::path& folder) {
  for (const int rows : {200'000, 2'000'000}) {
    const std::string name = fmt::format("{}.csv", rows);
    const fs::path plain = folder / name;
    const fs::path packed = folder / (name + ".gz");
    const fs::path log = folder / fmt::format("{}.lcmlog", rows);
    MakeTable(plain, rows);
    MakeRecord(log, rows);
    Repack(plain, packed, "wb1");
    fmt::print("peak memory, {:>8} samples: text {} kB, gzip {} kB, event log {} kB\n", rows,
               PeakKilobytes(plain), PeakKilobytes(packed), PeakKilobytes(log));
  }
}

void Run(const fs::path& given, const std::string& wished_python, const fs::path& folder) {
  CompareMemory(folder);
  const std::string python = FindPython(wished_python);
  if (python.empty()) {
    fmt::print(
        "no Python with numpy and pandas found (packages python3-numpy, python3-pandas): no "
        "comparison\n");
  }
  MakeTable(folder / "made.csv", 500'000);
  Repack(folder / "made.csv", folder / "made.csv.gz", "wb6");
  std::vector<fs::path> tables = {folder / "made.csv", folder / "made.csv.gz"};
  if (fs::exists(given)) {
    Repack(given, folder / "given.csv", "wbT");
    tables.insert(tables.begin(), {folder / "given.csv", given});
  } else {
    fmt::print("{} is not here: only made tables\n", given.string());
  }
  for (const fs::path& table : tables) Compare(table, python);
}

}  // namespace

int main(int argc, char** argv) {
  fs::path given = fs::path(GYROBENCH_SOURCE_DIR).parent_path() /
                   "shared/datasets/stepper-encoder-z-slow.csv.gz";
  std::string python;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--read-only" && i + 1 < argc) {
      SumSink sink;
      gyrobench::recording::Replay(argv[i + 1], sink);
      return sink.sum() == 0.0 ? 1 : 0;
    }
    if (std::string(argv[i]) == "--python" && i + 1 < argc) {
      python = argv[++i];
    } else {
      given = argv[i];
    }
  }
  std::string folder = (fs::temp_directory_path() / "gyrobench-bench-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return 1;
  int result = 0;
  try {
    Run(given, python, folder);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    result = 1;
  }
  fs::remove_all(folder);
  return result;
}
