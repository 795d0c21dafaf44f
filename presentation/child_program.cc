#include "presentation/child_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "base/error.h"

namespace gyrobench::presentation {
namespace {

using Clock = std::chrono::steady_clock;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

// Input and error output go through unnamed files: a child that does not read, or writes much,
// then never blocks on us.
File UnnamedFile(const std::string& content = {}) {
  File file(std::tmpfile());
  if (!file || std::fwrite(content.data(), 1, content.size(), file.get()) != content.size() ||
      std::fflush(file.get()) != 0) {
    throw Error(std::string("temporary file for a child program: ") + std::strerror(errno));
  }
  std::rewind(file.get());
  fcntl(fileno(file.get()), F_SETFD, FD_CLOEXEC);
  return file;
}

class SpawnActions {
 public:
  SpawnActions() { posix_spawn_file_actions_init(&actions_); }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  void Become(int from, int to) { posix_spawn_file_actions_adddup2(&actions_, from, to); }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

// Reads until the other end closes; false where `deadline` comes first.
bool ReadUntil(int descriptor, Clock::time_point deadline, std::string& text) {
  std::array<char, 65536> buffer{};
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return false;
    pollfd wait{descriptor, POLLIN, 0};
    const int ready = poll(&wait, 1, static_cast<int>(left.count()));
    if (ready == 0) return false;
    if (ready < 0 && errno == EINTR) continue;
    const ssize_t n = read(descriptor, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

// Ends the child where it has not ended by `deadline`; it may have closed its output long before.
int WaitFor(pid_t pid, Clock::time_point deadline, bool& timed_out) {
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(pid, &status, timed_out ? 0 : WNOHANG);
    if (ended == pid) break;
    if (ended < 0 && errno != EINTR) return -1;
    if (ended == 0 && Clock::now() < deadline) {
      poll(nullptr, 0, 1);
    } else if (ended == 0) {
      timed_out = true;
      kill(pid, SIGKILL);
    }
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string ReadAll(std::FILE* file) {
  std::string text;
  std::array<char, 4096> buffer{};
  std::rewind(file);
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), file)) {
    text.append(buffer.data(), n);
  }
  return text;
}

}  // namespace

ProgramRun RunProgram(const std::vector<std::string>& command, const std::string& input,
                      std::chrono::milliseconds limit) {
  const File in = UnnamedFile(input);
  const File err = UnnamedFile();
  std::array<int, 2> out = {-1, -1};
  if (pipe2(out.data(), O_CLOEXEC) != 0) {
    throw Error(std::string("pipe to a child program: ") + std::strerror(errno));
  }
  SpawnActions actions;
  actions.Become(fileno(in.get()), 0);
  actions.Become(out[1], 1);
  actions.Become(fileno(err.get()), 2);
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);

  ProgramRun run;
  pid_t pid = -1;
  run.started = posix_spawnp(&pid, argv[0], actions.get(), nullptr, argv.data(), environ) == 0;
  close(out[1]);
  if (run.started) {
    const Clock::time_point deadline = Clock::now() + limit;
    run.timed_out = !ReadUntil(out[0], deadline, run.out);
    if (run.timed_out) kill(pid, SIGKILL);
    run.exit_status = WaitFor(pid, deadline, run.timed_out);
    run.err = ReadAll(err.get());
  }
  close(out[0]);
  return run;
}

}  // namespace gyrobench::presentation
