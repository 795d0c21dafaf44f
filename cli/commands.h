// The commands: each does its work, prints to stdout and returns the exit status. They throw Error.
#pragma once

#include "cli/options.h"

namespace gyrobench::cli {

// daemon_commands.cc
int Procedures(const Options& options);
int Check(const Options& options);
int Status(const Options& options);
int Pause(const Options& options);
int Resume(const Options& options);
int Abort(const Options& options);
int Answer(const Options& options);
int Stop(const Options& options);
int Reset(const Options& options);
// run_command.cc
int Run(const Options& options);
// `resume RUN`: as Run, of a run whose daemon ended before it did.
int TakeUp(const Options& options);
// watch_command.cc
int Watch(const Options& options);
// bus_command.cc
int Bus(const Options& options);
// devices_command.cc
int Devices(const Options& options);
// record_commands.cc
int Runs(const Options& options);
int Show(const Options& options);
int ExportRecord(const Options& options);
// export_command.cc
int Export(const Options& options);
// analyze_command.cc
int Analyze(const Options& options);
// trace_command.cc
int Trace(const Options& options);
int Report(const Options& options);
// effects_command.cc
int Effects(const Options& options);
// hold_command.cc
int Hold(const Options& options);
// apply_command.cc
int Apply(const Options& options);

}  // namespace gyrobench::cli
