#include "procedures/engine/sandbox.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <lua.hpp>
#include <string_view>
#include <utility>

namespace gyrobench::procedures {
namespace {

// Instructions between two looks at the limits. Near the memory limit each of them may cost a
// collection.
constexpr int kHookInterval = 200;
constexpr lua_Integer kRepeatBytes = 1 << 20;
constexpr lua_Integer kRandomSeed = 1;

double ProcessorTime_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

using Names = std::initializer_list<std::string_view>;

// Removes all fields of the table on top of the stack but those of `kept`.
void KeepOnly(lua_State* state, Names kept) {
  lua_pushnil(state);
  while (lua_next(state, -2) != 0) {
    lua_pop(state, 1);
    const std::string_view key = lua_tostring(state, -1);
    if (std::find(kept.begin(), kept.end(), key) != kept.end()) continue;
    lua_pushvalue(state, -1);
    lua_pushnil(state);
    lua_rawset(state, -4);
  }
}

// string.rep loops once a repetition, also for an empty string, where no hook can stop it.
int BoundedRepeat(lua_State* state) {
  std::size_t length = 0;
  std::size_t separator = 0;
  luaL_checklstring(state, 1, &length);
  luaL_optlstring(state, 3, "", &separator);
  const auto each = static_cast<lua_Integer>(std::max<std::size_t>(1, length + separator));
  if (luaL_checkinteger(state, 2) > kRepeatBytes / each) {
    return luaL_error(state, "string.rep: more than %I bytes", kRepeatBytes);
  }
  lua_pushvalue(state, lua_upvalueindex(1));
  lua_insert(state, 1);
  lua_call(state, lua_gettop(state) - 1, 1);
  return 1;
}

void OpenLibrary(lua_State* state, const char* name, lua_CFunction open, Names kept) {
  luaL_requiref(state, name, open, 1);
  KeepOnly(state, kept);
  lua_pop(state, 1);
}

// Puts `function` with the library's own one as its upvalue in the place of that.
void Wrap(lua_State* state, const char* library, const char* name, lua_CFunction function) {
  lua_getglobal(state, library);
  lua_getfield(state, -1, name);
  lua_pushcclosure(state, function, 1);
  lua_setfield(state, -2, name);
  lua_pop(state, 1);
}

// The same numbers in every run, dry or not.
void SeedRandom(lua_State* state) {
  lua_getglobal(state, "math");
  lua_getfield(state, -1, "randomseed");
  lua_pushinteger(state, kRandomSeed);
  lua_call(state, 1, 0);
  lua_pushnil(state);
  lua_setfield(state, -2, "randomseed");
  lua_pop(state, 1);
}

std::string ErrorText(lua_State* state) {
  const int type = lua_type(state, -1);
  if (type == LUA_TSTRING || type == LUA_TNUMBER) return lua_tostring(state, -1);
  return fmt::format("error() was called with a value of type {}: give it a text",
                     lua_typename(state, type));
}

int LineOf(lua_State* state) {
  lua_Debug activation{};
  for (int level = 0; lua_getstack(state, level, &activation) != 0; ++level) {
    lua_getinfo(state, "l", &activation);
    if (activation.currentline > 0) return activation.currentline;
  }
  return 0;
}

}  // namespace

struct Sandbox::Guard {
  enum class Trip { kNone, kMemory, kStep, kTotal, kProcessor, kWholeProcessor, kCancelled };

  SandboxLimits limits;
  std::size_t memory_bytes = 0;
  std::int64_t step_instructions = 0;
  std::int64_t instructions = 0;
  double begin_s = ProcessorTime_s();
  double step_begin_s = 0.0;
  Trip trip = Trip::kNone;
  int trip_line = 0;
  std::string file;

  Trip Exceeded() const {
    if (step_instructions > limits.instructions_per_step) return Trip::kStep;
    if (instructions > limits.instructions) return Trip::kTotal;
    const double now_s = ProcessorTime_s();
    if (now_s - step_begin_s > limits.processor_s_per_step) return Trip::kProcessor;
    if (now_s - begin_s > limits.processor_s) return Trip::kWholeProcessor;
    if (limits.cancelled && limits.cancelled()) return Trip::kCancelled;
    return Trip::kNone;
  }

  void Set(Trip reason, lua_State* state) {
    if (trip != Trip::kNone) return;
    trip = reason;
    trip_line = LineOf(state);
  }

  std::string Message() const {
    switch (trip) {
      case Trip::kMemory:
        return fmt::format(
            "the script needs more than {} MB of memory (endless recursion, or a table or text "
            "that "
            "grows without end?)",
            limits.memory_bytes >> 20);
      case Trip::kStep:
        return fmt::format(
            "the script computed {} instructions without a bench command (an endless loop?)",
            limits.instructions_per_step);
      case Trip::kTotal:
        return fmt::format("the script computed more than {} instructions in all",
                           limits.instructions);
      case Trip::kProcessor:
        return fmt::format(
            "the script computed for more than {:g} s without a bench command (an endless loop?)",
            limits.processor_s_per_step);
      case Trip::kWholeProcessor:
        return fmt::format("the script and its commands computed for more than {:g} s in all",
                           limits.processor_s);
      case Trip::kCancelled:
        return "given up while the script computed";
      case Trip::kNone:
        break;
    }
    return {};
  }
};

void Sandbox::Close::operator()(lua_State* state) const { lua_close(state); }

Sandbox::Guard& Sandbox::GuardOf(lua_State* state) {
  Guard* guard = nullptr;
  std::memcpy(&guard, lua_getextraspace(state), sizeof(void*));
  return *guard;
}

void* Sandbox::Allocate(void* user, void* block, std::size_t old_size, std::size_t new_size) {
  Guard& guard = *static_cast<Guard*>(user);
  if (block == nullptr) old_size = 0;  // Lua passes the kind of object there
  if (new_size == 0) {
    std::free(block);
    guard.memory_bytes -= old_size;
    return nullptr;
  }
  const std::size_t after = guard.memory_bytes - old_size + new_size;
  if (new_size > old_size && after > guard.limits.memory_bytes) return nullptr;
  void* moved = std::realloc(block, new_size);
  if (moved != nullptr) guard.memory_bytes = after;
  return moved;
}

// Reached where the host itself meets an error of Lua outside of a protected call: memory. The
// process must not end by it, so it goes on as an exception of ours; whoever catches it closes the
// state.
int Sandbox::Panic(lua_State* state) {
  const char* text = lua_tostring(state, -1);
  throw ScriptError(GuardOf(state).file, 0,
                    fmt::format("no memory is left for the script's state ({})",
                                text == nullptr ? "unknown error" : text));
}

// table.sort compares within one instruction of the script, where the hook does not come, and each
// comparison may take as long as its texts are: the limits are looked at here.
int Sandbox::CompareForSort(lua_State* state) {
  Guard& guard = GuardOf(state);
  if (guard.trip == Guard::Trip::kNone) {
    const Guard::Trip reason = guard.Exceeded();
    if (reason != Guard::Trip::kNone) guard.Set(reason, state);
  }
  if (guard.trip != Guard::Trip::kNone) return Leave(state);
  if (lua_isnil(state, lua_upvalueindex(1))) {
    lua_pushboolean(state, lua_compare(state, 1, 2, LUA_OPLT));
    return 1;
  }
  lua_pushvalue(state, lua_upvalueindex(1));
  lua_insert(state, 1);
  lua_call(state, 2, 1);
  return 1;
}

int Sandbox::BoundedSort(lua_State* state) {
  if (!lua_isnoneornil(state, 2)) luaL_checktype(state, 2, LUA_TFUNCTION);
  lua_settop(state, 2);
  lua_pushcclosure(state, CompareForSort, 1);
  lua_pushvalue(state, lua_upvalueindex(1));
  lua_insert(state, 1);
  lua_call(state, 2, 0);
  return 0;
}

// Leaves the script for good: yields to the host, which will not resume. An error would unwind
// level by level, at a cost that grows with the square of the depth; it is for where a yield cannot
// be (in table.sort, where the depth is small).
int Sandbox::Leave(lua_State* state) {
  if (lua_isyieldable(state) != 0) return lua_yield(state, 0);
  return luaL_error(state, "limit of the script reached");
}

// Once tripped, the hook comes at every instruction: whatever the script does to go on, it is
// stopped again.
void Sandbox::OnCount(lua_State* state, lua_Debug*) {
  Guard& guard = GuardOf(state);
  if (guard.trip == Guard::Trip::kNone) {
    guard.step_instructions += kHookInterval;
    guard.instructions += kHookInterval;
    const Guard::Trip reason = guard.Exceeded();
    if (reason == Guard::Trip::kNone) return;
    guard.Set(reason, state);
    lua_sethook(state, OnCount, LUA_MASKCOUNT, 1);
  }
  Leave(state);
}

// pcall of the sandbox: as Lua's, but it catches neither a tripped limit nor exhausted memory.
int Sandbox::ProtectedCall(lua_State* state) {
  luaL_checkany(state, 1);
  lua_pushboolean(state, 1);
  lua_insert(state, 1);
  const int status = lua_pcallk(state, lua_gettop(state) - 2, LUA_MULTRET, 0, 0, EndProtectedCall);
  return EndProtectedCall(state, status, 0);
}

int Sandbox::EndProtectedCall(lua_State* state, int status, std::ptrdiff_t) {
  Guard& guard = GuardOf(state);
  if (status == LUA_ERRMEM) guard.Set(Guard::Trip::kMemory, state);
  if (guard.trip != Guard::Trip::kNone) return Leave(state);
  if (status == LUA_OK || status == LUA_YIELD) return lua_gettop(state);
  lua_pushboolean(state, 0);
  lua_pushvalue(state, -2);
  return 2;
}

Sandbox::Sandbox(std::string file, const SandboxLimits& limits)
    : file_(std::move(file)), guard_(std::make_unique<Guard>()) {
  guard_->limits = limits;
  guard_->file = file_;
  state_.reset(lua_newstate(Allocate, guard_.get()));
  if (!state_) throw Error(file_ + ": no memory for a Lua state");
  lua_atpanic(state_.get(), Panic);
  Guard* guard = guard_.get();
  std::memcpy(lua_getextraspace(state_.get()), &guard, sizeof(void*));
  OpenLibraries();
  // Never collected: it stays on the stack of the main thread.
  thread_ = lua_newthread(state_.get());
  lua_sethook(thread_, OnCount, LUA_MASKCOUNT, kHookInterval);
}

Sandbox::~Sandbox() = default;

// Only what is listed here exists for a script. Left out, and why: io, os, package, debug, load,
// dofile, require (files, processes, code of unknown origin); coroutine (a command must reach the
// host); collectgarbage, setmetatable, getmetatable, raw* (finalizers, and lengths that make
// library functions loop without end); find, match, gmatch, gsub (patterns that run for years);
// table.move (the same); xpcall (its handler runs after a limit tripped).
void Sandbox::OpenLibraries() {
  lua_State* state = state_.get();
  OpenLibrary(state, LUA_STRLIBNAME, luaopen_string,
              {"byte", "char", "format", "len", "lower", "rep", "reverse", "sub", "upper"});
  OpenLibrary(state, LUA_TABLIBNAME, luaopen_table,
              {"concat", "insert", "pack", "remove", "sort", "unpack"});
  OpenLibrary(
      state, LUA_MATHLIBNAME, luaopen_math,
      {"abs",  "acos",   "asin",       "atan", "ceil",       "cos", "deg",        "exp",  "floor",
       "fmod", "huge",   "log",        "max",  "maxinteger", "min", "mininteger", "modf", "pi",
       "rad",  "random", "randomseed", "sin",  "sqrt",       "tan", "tointeger",  "type", "ult"});
  OpenLibrary(state, LUA_GNAME, luaopen_base,
              {"_G", "_VERSION", "assert", "error", "ipairs", "next", "pairs", "select", "tonumber",
               "tostring", "type", "string", "table", "math"});
  Wrap(state, LUA_STRLIBNAME, "rep", BoundedRepeat);
  Wrap(state, LUA_TABLIBNAME, "sort", BoundedSort);
  SeedRandom(state);
  lua_pushcfunction(state, ProtectedCall);
  lua_setglobal(state, "pcall");
}

void Sandbox::Load(const std::string& source) {
  const std::string chunk = "@" + file_;
  const int status = luaL_loadbufferx(thread_, source.data(), source.size(), chunk.c_str(), "t");
  if (status != LUA_OK) Fail(status);
  const Step step = Resume(0);
  if (!step.finished) {
    throw ScriptError(
        file_, CurrentLine(),
        "bench commands can be called from run(p) only, not while the script is read");
  }
  lua_settop(thread_, 0);
}

Sandbox::Step Sandbox::Resume(int arguments) {
  guard_->step_instructions = 0;
  guard_->step_begin_s = ProcessorTime_s();
  Step step;
  const int status = lua_resume(thread_, nullptr, arguments, &step.values);
  step.finished = status == LUA_OK;
  const bool running = step.finished || status == LUA_YIELD;
  if (!running || guard_->trip != Guard::Trip::kNone) Fail(status);
  return step;
}

void Sandbox::Fail(int status) {
  if (status == LUA_ERRMEM) guard_->Set(Guard::Trip::kMemory, thread_);
  if (guard_->trip == Guard::Trip::kCancelled) throw Aborted(file_ + ": " + guard_->Message());
  if (guard_->trip != Guard::Trip::kNone) {
    throw ScriptError(file_, guard_->trip_line, guard_->Message());
  }
  std::string text = ErrorText(thread_);
  int line = CurrentLine();
  // Lua has put "file:line: " before most of its messages; that line is the better one.
  if (text.starts_with(file_ + ":")) {
    const std::size_t begin = file_.size() + 1;
    const std::size_t end = text.find(':', begin);
    const int told = std::atoi(text.c_str() + begin);
    if (told > 0 && end != std::string::npos) {
      line = told;
      text.erase(0, std::min(text.size(), end + 2));
    }
  }
  throw ScriptError(file_, line, text);
}

int Sandbox::CurrentLine() const { return LineOf(thread_); }

std::int64_t Sandbox::instructions() const { return guard_->instructions; }

}  // namespace gyrobench::procedures
