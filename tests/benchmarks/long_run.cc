// What a snapshot and a segment's result cost, early and late in a long run: processor time.
#include <cstdio>
#include <ctime>
#include <memory>

#include "calibration/estimators/analyzer.h"
#include "tests/daemon/long_measurement.h"

namespace {

template <typename Action>
double Duration_s(const Action& action) {
  const std::clock_t begin = std::clock();
  action();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

}  // namespace

int main() {
  gyrobench::daemon::LongMeasurement measurement(100.0);
  gyrobench::calibration::Analyzer analyzer;
  analyzer.OnInfo(gyrobench::daemon::LongMeasurement::Info());
  std::printf("%8s %15s %12s %12s\n", "run [h]", "snapshot [us]", "columns [s]", "result [s]");
  for (const double hours : {0.1, 0.5, 1.0, 2.0, 5.0, 10.0}) {
    measurement.FeedUntil(3600.0 * hours, analyzer);
    std::shared_ptr<const gyrobench::calibration::Analyzer> snapshot;
    const double snapshot_s = Duration_s(
        [&] { snapshot = std::make_shared<const gyrobench::calibration::Analyzer>(analyzer); });
    const double columns_s = Duration_s([&] { snapshot->Take(); });
    const double result_s = Duration_s([&] { snapshot->Result(); });
    std::printf("%8.1f %15.0f %12.3f %12.3f\n", hours, 1e6 * snapshot_s, columns_s, result_s);
  }
  return 0;
}
