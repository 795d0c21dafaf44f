// Gives a recorded measurement to a sink, whatever form it has on disk. All of it as streams:
// memory does not depend on the length of the run.
#pragma once

#include <filesystem>
#include <functional>

#include "base/measurement.h"

namespace gyrobench::recording {

// Called now and then with the share of the file that has been read, 0..1.
using ReplayProgress = std::function<void(double fraction)>;

// A record (recording/measurement_files.h). Channels are told by their endings _GYRO,
// _ANGLE, _RUN, whatever the prefix. Damage of the log and messages that cannot be decoded
// (damaged_message) are defects, given at the end. Where run.json is absent or damaged, what it
// would say is taken from the messages themselves, as far as they say it; a damaged one is a defect
// (damaged_run_json). Throws DataError when there is no event log or no message of a run in it.
void ReplayRun(const std::filesystem::path& record, MeasurementSink& sink,
               const ReplayProgress& progress = {});

// A measurement table. A row gives one gyro sample if it has a value of the gyro; one angle sample
// for each angle it has; an orientation if all four parts are there, made to length 1. Covariates
// are given with every gyro sample, and from rows without one that have a value of them. Defects,
// next to TableReader's: no_gyro (acceleration or temperature in a row without the gyro: not used),
// bad_quaternion (parts missing, or length off 1 by over 1 %: not used). Throws DataError.
void ReplayTable(const std::filesystem::path& table, MeasurementSink& sink,
                 const ReplayProgress& progress = {});

// Either, as recording/measurement_files.h tells them apart. Throws DataError.
void Replay(const std::filesystem::path& path, MeasurementSink& sink,
            const ReplayProgress& progress = {});

}  // namespace gyrobench::recording
