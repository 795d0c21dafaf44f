#include "procedures/engine/table_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <lua.hpp>
#include <utility>

#include "procedures/engine/sandbox.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {
namespace {

// Keeps the stack as it was, also when an error is thrown.
class StackMark {
 public:
  explicit StackMark(lua_State* state) : state_(state), top_(lua_gettop(state)) {
    if (lua_checkstack(state, LUA_MINSTACK) == 0)
      throw ScriptError("the script's stack is used up");
  }
  ~StackMark() { lua_settop(state_, top_); }
  StackMark(const StackMark&) = delete;
  StackMark& operator=(const StackMark&) = delete;

 private:
  lua_State* state_;
  int top_;
};

}  // namespace

std::string ShowValue(lua_State* state, int index) {
  switch (lua_type(state, index)) {
    case LUA_TNIL:
    case LUA_TNONE:
      return "nothing";
    case LUA_TBOOLEAN:
      return lua_toboolean(state, index) != 0 ? "true" : "false";
    case LUA_TNUMBER:
      return fmt::format("{:.10g}", lua_tonumber(state, index));
    case LUA_TSTRING: {
      const std::string text = lua_tostring(state, index);
      return IsText(text) && text.size() <= 60 ? "\"" + text + "\"" : "a long text";
    }
    default:
      return fmt::format("a {}", luaL_typename(state, index));
  }
}

std::string ReadText(lua_State* state, int index, const std::string& what) {
  const int type = lua_type(state, index);
  if (type != LUA_TSTRING && type != LUA_TNUMBER) {
    throw ScriptError(fmt::format("{}: expected a text, got {}", what, ShowValue(state, index)));
  }
  const StackMark mark(state);
  lua_pushvalue(state, index);  // lua_tolstring changes a number where it lies
  std::size_t length = 0;
  const char* data = lua_tolstring(state, -1, &length);
  std::string text(data, length);
  if (length > TableReader::kMaxText || !IsText(text)) {
    throw ScriptError(fmt::format("{}: expected UTF-8 text of at most {} bytes, got {} bytes{}",
                                  what, TableReader::kMaxText, length,
                                  IsText(text) ? "" : " that are not"));
  }
  return text;
}

TableReader::TableReader(lua_State* state, int index, std::string what,
                         std::vector<std::string> known)
    : state_(state),
      index_(lua_absindex(state, index)),
      what_(std::move(what)),
      known_(std::move(known)) {
  if (!lua_istable(state, index_)) {
    Refuse(fmt::format("expected a table {{ ... }} with the fields {}, got {}",
                       fmt::join(known_, ", "), ShowValue(state, index_)));
  }
  CheckFields();
}

void TableReader::CheckFields() const {
  const StackMark mark(state_);
  lua_pushnil(state_);
  while (lua_next(state_, index_) != 0) {
    if (lua_type(state_, -2) != LUA_TSTRING) {
      Refuse(fmt::format("{} stands without a name; fields: {}", ShowValue(state_, -1),
                         fmt::join(known_, ", ")));
    }
    const std::string key = lua_tostring(state_, -2);
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
      Refuse(fmt::format("unknown field {}{}; fields: {}", ShowValue(state_, -2),
                         DidYouMean(key, known_), fmt::join(known_, ", ")));
    }
    lua_pop(state_, 1);
  }
}

void TableReader::Refuse(const std::string& message) const {
  throw ScriptError(what_ + ": " + message);
}

void TableReader::Expected(const char* field, const std::string& expected) const {
  Refuse(fmt::format("{} = {}: expected {}", field, ShowValue(state_, -1), expected));
}

bool TableReader::Has(const char* field) const {
  const StackMark mark(state_);
  return lua_getfield(state_, index_, field) != LUA_TNIL;
}

std::optional<double> TableReader::AnyNumber(const char* field) const {
  const StackMark mark(state_);
  const int type = lua_getfield(state_, index_, field);
  if (type == LUA_TNIL) return std::nullopt;
  if (type != LUA_TNUMBER) Expected(field, "a number");
  return lua_tonumber(state_, -1);
}

std::optional<double> TableReader::Number(const char* field) const {
  const std::optional<double> value = AnyNumber(field);
  if (value && !std::isfinite(*value)) {
    Refuse(fmt::format("{} = {}: expected a finite number", field, *value));
  }
  return value;
}

std::optional<double> TableReader::PositiveNumber(const char* field) const {
  const std::optional<double> value = Number(field);
  if (value && *value <= 0.0) {
    Refuse(fmt::format("{} = {:.10g}: expected a number above 0", field, *value));
  }
  return value;
}

std::optional<std::string> TableReader::Text(const char* field) const {
  const StackMark mark(state_);
  const int type = lua_getfield(state_, index_, field);
  if (type == LUA_TNIL) return std::nullopt;
  if (type != LUA_TSTRING) Expected(field, "a text");
  return ReadText(state_, -1, what_ + "." + field);
}

std::vector<std::string> TableReader::Texts(const char* field) const {
  const StackMark mark(state_);
  std::vector<std::string> texts;
  const int type = lua_getfield(state_, index_, field);
  if (type == LUA_TNIL) return texts;
  if (type != LUA_TTABLE) Expected(field, "a list of texts, { \"...\", \"...\" }");
  const auto count = static_cast<lua_Integer>(lua_rawlen(state_, -1));
  for (lua_Integer i = 1; i <= count; ++i) {
    lua_rawgeti(state_, -1, i);
    texts.push_back(ReadText(state_, -1, fmt::format("{}.{}[{}]", what_, field, i)));
    lua_pop(state_, 1);
  }
  return texts;
}

double TableReader::RequiredNumber(const char* field) const {
  if (const auto value = Number(field)) return *value;
  Refuse(fmt::format("{} is missing: expected a number", field));
}

std::string TableReader::RequiredText(const char* field) const {
  if (auto text = Text(field)) return *text;
  Refuse(fmt::format("{} is missing: expected a text", field));
}

bool TableReader::RequiredFlag(const char* field) const {
  const StackMark mark(state_);
  if (lua_getfield(state_, index_, field) != LUA_TBOOLEAN) Expected(field, "true or false");
  return lua_toboolean(state_, -1) != 0;
}

}  // namespace gyrobench::procedures
