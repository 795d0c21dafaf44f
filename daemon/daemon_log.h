// The daemon's log, on standard error.
#pragma once

namespace gyrobench::daemon {

// While it lives, what is logged with spdlog is written by a thread of its own: whoever reads the
// log may hang (a terminal that is stopped, a pipe that is full), and nothing that moves the stand
// or stops it waits for that. Where kMostUnwritten lines wait already, the oldest is dropped, and
// the next line that is written says how many were. That thread takes no signals.
//
// What a script, a request or a device brings into a line is text there: bytes that are no UTF-8
// and control characters, which a terminal would obey, show as U+FFFD.
//
// One at a time. Nothing may be logged once it is closed.
class DaemonLog {
 public:
  DaemonLog();
  ~DaemonLog() { Close(); }
  DaemonLog(const DaemonLog&) = delete;
  DaemonLog& operator=(const DaemonLog&) = delete;

  // Waits for 3 s at most until what waits is written. False where it is not: the thread that hangs
  // is still there then, so that the process has to be left by std::_Exit.
  bool Close();

  static constexpr unsigned kMostUnwritten = 1024;

 private:
  bool closed_ = false;
};

}  // namespace gyrobench::daemon
