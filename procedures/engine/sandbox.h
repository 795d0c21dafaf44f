// A Lua state that a stranger's script can do no harm in: no files, no processes, no clock, bounded
// memory, instructions and processor time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "base/error.h"

struct lua_State;
struct lua_Debug;

namespace gyrobench::procedures {

// A script that is wrong, failed, or used more than it may. what() begins with file and line once
// the place is known.
class ScriptError : public Error {
 public:
  using Error::Error;  // the place follows
  // `line` 0: none is known.
  ScriptError(const std::string& file, int line, const std::string& message) : Error(message) {
    SetPlace({file, line});
  }
};

// Thrown when a run is to end because somebody wants it to: by a Bench, or in the middle of a
// script whose limits say so. Not a failure.
class Aborted : public Error {
 public:
  using Error::Error;
};

// What a script may use. The instruction counts make the same script stop at the same place on
// every machine; processor time is the last resort against library functions that work long within
// one instruction.
struct SandboxLimits {
  std::size_t memory_bytes = std::size_t{32} << 20;
  std::int64_t instructions_per_step = 20'000'000;  // between two bench commands
  std::int64_t instructions = 1'000'000'000;        // in all
  double processor_s_per_step = 5.0;
  // In all, with what the commands take in the same thread.
  double processor_s = std::numeric_limits<double>::infinity();
  // Asked again and again while the script computes: true ends it by Aborted.
  std::function<bool()> cancelled = {};
};

// One script in one Lua state, run as one coroutine. A step runs it until it yields, returns or
// fails. A limit, once tripped, cannot be caught by the script. Not thread-safe.
class Sandbox {
 public:
  // `file` is the name that errors carry.
  Sandbox(std::string file, const SandboxLimits& limits);
  ~Sandbox();
  Sandbox(const Sandbox&) = delete;
  Sandbox& operator=(const Sandbox&) = delete;

  // Compiles `source` (text, never precompiled code) and runs its top level. Throws ScriptError,
  // also where the top level calls a bench command.
  void Load(const std::string& source);

  struct Step {
    bool finished = false;
    int values = 0;  // yielded or returned, on top of thread()'s stack
  };
  // Resumes the coroutine with the `arguments` values on top of thread()'s stack; before its first
  // step also the function below them. Throws ScriptError and Aborted.
  Step Resume(int arguments);

  lua_State* thread() const { return thread_; }
  const std::string& file() const { return file_; }
  // Line of the script that runs now (that called the bench command, after a yield). 0: none.
  int CurrentLine() const;
  std::int64_t instructions() const;

 private:
  struct Guard;
  struct Close {
    void operator()(lua_State* state) const;
  };
  [[noreturn]] void Fail(int status);
  static void* Allocate(void* user, void* block, std::size_t old_size, std::size_t new_size);
  static void OnCount(lua_State* state, lua_Debug* activation);
  static int ProtectedCall(lua_State* state);
  static int CompareForSort(lua_State* state);
  static int BoundedSort(lua_State* state);
  static int EndProtectedCall(lua_State* state, int status, std::ptrdiff_t context);
  static int Panic(lua_State* state);
  static int Leave(lua_State* state);
  static Guard& GuardOf(lua_State* state);
  void OpenLibraries();

  std::string file_;
  std::unique_ptr<Guard> guard_;
  std::unique_ptr<lua_State, Close> state_;
  lua_State* thread_ = nullptr;
};

}  // namespace gyrobench::procedures
