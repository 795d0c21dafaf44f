// A struct each of whose fields has a value of its own, whatever fields it has.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/json_fields.h"

namespace gyrobench {

// Visits a list of fields as FieldReader does, and gives each field another value: numbers and
// texts are never the same twice, lists have two entries, nothing is empty.
class DistinctFields {
 public:
  template <typename T>
  using Field = T;

  template <typename T, typename... Rules>
  void operator()(Key, T& value, const Rules&... rules) {
    Fill(value, rules...);
  }
  template <typename T>
  void LaterAs(const char*, T& value, const T&) {
    Fill(value);
  }
  template <typename T>
  void IfThere(const char*, std::optional<T>& value) {
    Fill(value.emplace());
  }
  template <typename List>
  void Group(Key, const List& list) {
    list(*this);
  }
  template <typename Value>
  void Derived(const char*, const Value&) {}
  void Constant(const char*, const char*) {}
  template <typename CheckAt>
  void Check(const CheckAt&) {}

  void Fill(double& value) { value = static_cast<double>(++count_) + 1.0 / 3.0; }
  void Fill(bool& value) { value = ++count_ % 2 == 0; }
  void Fill(std::int64_t& value) { value = ++count_; }
  void Fill(std::string& value) { value = fmt::format("text {}", ++count_); }
  void Fill(std::map<std::string, std::string>& values) { Fill(values["key"]); }
  template <typename T>
  void Fill(std::vector<T>& values) {
    values.resize(2);
    for (T& value : values) Fill(value);
  }
  template <typename T, std::size_t kCount, typename... Rules>
  void Fill(std::array<T, kCount>& values, const Rules&...) {
    for (T& value : values) Fill(value);
  }
  template <typename T, typename... Rules>
  void Fill(std::optional<T>& value, const Rules&... rules) {
    Fill(value.emplace(), rules...);
  }
  template <typename T>
  void Fill(T& value) {
    Fields(*this, value);
  }
  template <typename T>
  void Fill(T& value, Names names) {
    value = static_cast<T>(static_cast<std::size_t>(++count_) % names.size());
  }
  void Fill(double& value, NeverNull) { Fill(value); }
  void Fill(double& value, AboveZero) { Fill(value); }
  void Fill(double& value, InsteadOfNull) { Fill(value); }
  void Fill(std::vector<double>& values, SquareOf square) {
    values.resize(square.n * square.n);
    for (double& value : values) Fill(value);
  }
  template <typename T, typename... Rules>
  void Fill(T& value, NullUnless, const Rules&... rules) {
    Fill(value, rules...);
  }

 private:
  std::int64_t count_ = 0;
};

}  // namespace gyrobench
