#include "tests/cli/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>

namespace gyrobench::cli {
namespace {

// A stuck program must fail a test, not hang it.
constexpr int kPatience_ms = 60'000;

bool ReadInto(int& descriptor, std::string& text) {
  std::array<char, 4096> buffer{};
  const ssize_t n = read(descriptor, buffer.data(), buffer.size());
  if (n <= 0) {  // EIO: the other end of a terminal is closed
    close(descriptor);
    descriptor = -1;
    return false;
  }
  text.append(buffer.data(), static_cast<std::size_t>(n));
  return true;
}

[[noreturn]] void BecomeChild(const std::vector<std::string>& command,
                              const std::vector<std::string>& environment, int in, int out,
                              int err) {
  dup2(in, 0);
  dup2(out, 1);
  dup2(err, 2);
  for (const std::string& setting : environment) {
    const std::size_t equals = setting.find('=');
    setenv(setting.substr(0, equals).c_str(), setting.c_str() + equals + 1, 1);
  }
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  execvp(argv[0], argv.data());
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command,
                           const std::vector<std::string>& environment, bool on_terminal) {
  int in = -1, out[2] = {-1, -1}, err[2] = {-1, -1};
  if (on_terminal) {
    const winsize size{30, 100, 0, 0};
    if (openpty(&terminal_, &in, nullptr, nullptr, &size) != 0) throw std::runtime_error("openpty");
    fcntl(terminal_, F_SETFD, FD_CLOEXEC);
    out_ = dup(terminal_);
    fcntl(out_, F_SETFD, FD_CLOEXEC);
  } else {
    in = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
    out_ = out[0];
    err_ = err[0];
  }
  pid_ = fork();
  if (pid_ == 0) {
    BecomeChild(command, environment, in, on_terminal ? in : out[1], on_terminal ? in : err[1]);
  }
  close(in);
  if (!on_terminal) {
    close(out[1]);
    close(err[1]);
  }
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  for (const int descriptor : {out_, err_, terminal_}) {
    if (descriptor >= 0) close(descriptor);
  }
}

bool ChildProcess::ReadSome() {
  if (out_ < 0 && err_ < 0) return false;
  std::array<pollfd, 2> waits = {{{out_, POLLIN, 0}, {err_, POLLIN, 0}}};
  if (poll(waits.data(), waits.size(), kPatience_ms) <= 0) {
    throw std::runtime_error("no output for a minute; so far: " + finished_.out + finished_.err);
  }
  if (waits[0].revents != 0) ReadInto(out_, finished_.out);
  if (waits[1].revents != 0) ReadInto(err_, finished_.err);
  return true;
}

void ChildProcess::WaitFor(const std::string& text) {
  while (finished_.out.find(text) == std::string::npos &&
         finished_.err.find(text) == std::string::npos) {
    if (!ReadSome()) {
      throw std::runtime_error("ended without '" + text + "'; said: " + finished_.out +
                               finished_.err);
    }
  }
}

void ChildProcess::Type(const std::string& text) {
  if (write(terminal_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("write to the terminal");
  }
}

void ChildProcess::Signal(int signal) { kill(pid_, signal); }

Finished ChildProcess::Wait() {
  while (ReadSome()) {
  }
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  finished_.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return finished_;
}

Finished RunToEnd(const std::vector<std::string>& command,
                  const std::vector<std::string>& environment) {
  return ChildProcess(command, environment).Wait();
}

}  // namespace gyrobench::cli
