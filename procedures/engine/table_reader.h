// Reads a Lua table of named fields into C++ values.
#pragma once

#include <optional>
#include <string>
#include <vector>

struct lua_State;

namespace gyrobench::procedures {

// The table at `index` of the stack. `what` names it in messages ("bench.turn"). All fields must be
// among `known`. Every error is a ScriptError that names table, field, value and what was expected;
// fields that are absent are nullopt. Numbers are finite, texts are UTF-8 of at most kMaxText
// bytes.
class TableReader {
 public:
  static constexpr std::size_t kMaxText = 4000;

  TableReader(lua_State* state, int index, std::string what, std::vector<std::string> known);
  bool Has(const char* field) const;
  std::optional<double> Number(const char* field) const;
  // As Number, but NaN and infinity are let through, for values that somebody judges.
  std::optional<double> AnyNumber(const char* field) const;
  std::optional<double> PositiveNumber(const char* field) const;
  std::optional<std::string> Text(const char* field) const;
  std::vector<std::string> Texts(const char* field) const;
  double RequiredNumber(const char* field) const;
  std::string RequiredText(const char* field) const;
  bool RequiredFlag(const char* field) const;
  [[noreturn]] void Refuse(const std::string& message) const;

 private:
  [[noreturn]] void Expected(const char* field, const std::string& expected) const;
  void CheckFields() const;

  lua_State* state_;
  int index_;
  std::string what_;
  std::vector<std::string> known_;
};

// The text at `index`, checked as above. Numbers are taken as text too.
std::string ReadText(lua_State* state, int index, const std::string& what);

// A value as messages show it: 5, "abc", a table.
std::string ShowValue(lua_State* state, int index);

}  // namespace gyrobench::procedures
