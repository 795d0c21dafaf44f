#include "recording/replay.h"

#include "recording/measurement_files.h"

namespace gyrobench::recording {

void Replay(const std::filesystem::path& path, MeasurementSink& sink,
            const ReplayProgress& progress) {
  if (FilesOfMeasurement(path).is_record) {
    ReplayRun(path, sink, progress);
  } else {
    ReplayTable(path, sink, progress);
  }
}

}  // namespace gyrobench::recording
