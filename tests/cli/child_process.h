// A program run by a test: its output, its end, and a terminal where the test wants one.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace gyrobench::cli {

struct Finished {
  int status = -1;  // exit status; 128 + signal when it was killed
  std::string out;
  std::string err;  // empty on a terminal: both are one there
};

class ChildProcess {
 public:
  // `environment`: "NAME=value" on top of the test's own. With `on_terminal` stdin, stdout and
  // stderr are a pseudo-terminal of 100 columns.
  ChildProcess(const std::vector<std::string>& command,
               const std::vector<std::string>& environment = {}, bool on_terminal = false);
  // Kills it if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Reads until stdout or stderr holds `text`; throws with what there was when it ends before or 60
  // s pass.
  void WaitFor(const std::string& text);
  void Type(const std::string& text);  // on its terminal
  void Signal(int signal);
  // Reads to the end.
  Finished Wait();

 private:
  bool ReadSome();

  pid_t pid_ = -1;
  int out_ = -1, err_ = -1, terminal_ = -1;
  Finished finished_;
};

Finished RunToEnd(const std::vector<std::string>& command,
                  const std::vector<std::string>& environment = {});

}  // namespace gyrobench::cli
