// One list of a struct's fields, from which its JSON is written and from which it is read.
//
//   template <typename Visitor>
//   void Fields(Visitor& field, FieldsOf<Visitor, Defect>& defect) {
//     field("kind", defect.kind);
//     field("count", defect.count);
//   }
//
// The list stands in the struct's namespace, in a header that only sources include. A type has one
// form: a number that is not known (NaN) is null, an empty std::optional is null, a vector or array
// is a list, a map is an object, a struct with a list of its own is an object. A list of numbers
// of any length holds no null. Rules behind the field say what is special of it.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/json_place.h"
#include "base/json_text.h"

namespace gyrobench {

// const T for those visitors that only look.
template <typename Visitor, typename T>
using FieldsOf = typename Visitor::template Field<T>;

// Rules. An enumeration, or a number that counts from 0, is one of these names.
using Names = std::span<const char* const>;
struct NeverNull {};  // what is not a number is refused, also within
struct AboveZero {};  // a number above 0
struct SquareOf {     // a list that is row by row a matrix, written as a list of rows
  std::size_t n = 0;
};
struct InsteadOfNull {  // written where the field is not a number
  double value = kMissing;
};
struct NullUnless {  // null, and not read, where it means nothing
  bool known = true;
};

// All of an enumeration that counts from 0, by the function Name of its namespace.
template <typename Enum>
std::vector<const char*> NamesUpTo(Enum last) {
  std::vector<const char*> names;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(last); ++i)
    names.push_back(Name(static_cast<Enum>(i)));
  return names;
}

// Of a field. A key that came later than the format may be missing: then the field stays as it is.
struct Key {
  Key(const char* key, bool may_be_missing = false)  // NOLINT: a plain name is a key
      : name(key), later(may_be_missing) {}
  const char* name;
  bool later;
};
inline Key Later(const char* key) { return {key, true}; }

// Writes the fields of one object.
class FieldWriter {
 public:
  template <typename T>
  using Field = const T;

  template <typename T, typename... Rules>
  void operator()(Key key, const T& value, const Rules&... rules) {
    object_[key.name] = Written(value, rules...);
  }
  // Came later; where a file does not have it, it is as `other`, which the list names before it.
  template <typename T>
  void LaterAs(const char* key, const T& value, const T& /*other*/) {
    object_[key] = Written(value);
  }
  // No key where there is no value.
  template <typename T>
  void IfThere(const char* key, const std::optional<T>& value) {
    if (value) object_[key] = Written(*value);
  }
  // Fields of this struct in an object of their own. `list(visitor)` names them.
  template <typename List>
  void Group(Key key, const List& list) {
    FieldWriter part;
    list(part);
    object_[key.name] = std::move(part.object_);
  }
  // Follows from the other fields, by `value()`: it has to be there, and is not read.
  template <typename Value>
  void Derived(const char* key, const Value& value) {
    object_[key] = value();
  }
  // The same in all files; another text is refused.
  void Constant(const char* key, const char* text) { object_[key] = text; }
  // Called as check(place) where the fields named so far have been read.
  template <typename CheckAt>
  void Check(const CheckAt& /*check*/) {}

  nlohmann::json Take() { return std::move(object_); }

  static nlohmann::json Written(double value) { return Number(value); }
  static nlohmann::json Written(bool value) { return value; }
  static nlohmann::json Written(std::int64_t value) { return value; }
  static nlohmann::json Written(const std::string& value) { return value; }
  static nlohmann::json Written(const std::map<std::string, std::string>& value) { return value; }
  template <typename T>
  static nlohmann::json Written(const std::vector<T>& values) {
    return List(values);
  }
  template <typename T, std::size_t kCount>
  static nlohmann::json Written(const std::array<T, kCount>& values) {
    return List(values);
  }
  template <typename T, typename... Rules>
  static nlohmann::json Written(const std::optional<T>& value, const Rules&... rules) {
    return value ? Written(*value, rules...) : nlohmann::json(nullptr);
  }
  template <typename T>
  static nlohmann::json Written(const T& value) {
    FieldWriter writer;
    Fields(writer, value);
    return writer.Take();
  }
  template <typename T>
  static nlohmann::json Written(const T& value, Names names) {
    return names[static_cast<std::size_t>(value)];
  }
  template <typename T>
  static nlohmann::json Written(const T& value, NeverNull) {
    return Written(value);
  }
  static nlohmann::json Written(double value, AboveZero) { return Number(value); }
  static nlohmann::json Written(double value, InsteadOfNull other) {
    return Number(std::isfinite(value) ? value : other.value);
  }
  static nlohmann::json Written(const std::vector<double>& values, SquareOf square) {
    nlohmann::json rows = nlohmann::json::array();
    for (std::size_t i = 0; i < square.n; ++i) {
      nlohmann::json& row = rows.emplace_back(nlohmann::json::array());
      for (std::size_t j = 0; j < square.n; ++j) row.push_back(Number(values.at(i * square.n + j)));
    }
    return rows;
  }
  template <typename T, typename... Rules>
  static nlohmann::json Written(const T& value, NullUnless unless, const Rules&... rules) {
    return unless.known ? Written(value, rules...) : nlohmann::json(nullptr);
  }

 private:
  template <typename Values>
  static nlohmann::json List(const Values& values) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& value : values) list.push_back(Written(value));
    return list;
  }

  nlohmann::json object_ = nlohmann::json::object();
};

// Reads the fields of one object strictly: Place says what is refused, where, and what is expected.
// Goes through the list twice, so that a key that is missing, or that nobody knows, comes first.
class FieldReader {
 public:
  template <typename T>
  using Field = T;

  template <typename T, typename... Rules>
  void operator()(Key key, T& value, const Rules&... rules) {
    Visit(key, [&](const Place& place) { Read(place, value, rules...); });
  }
  template <typename T>
  void LaterAs(const char* key, T& value, const T& other) {
    value = other;
    (*this)(Later(key), value);
  }
  template <typename T>
  void IfThere(const char* key, std::optional<T>& value) {
    Visit(Later(key), [&](const Place& place) { Read(place, value.emplace()); });
  }
  template <typename List>
  void Group(Key key, const List& list) {
    Visit(key, [&](const Place& place) { ReadObject(place, list); });
  }
  template <typename Value>
  void Derived(const char* key, const Value& /*value*/) {
    Visit(key, [](const Place&) {});
  }
  void Constant(const char* key, const char* text) {
    Visit(key, [&](const Place& place) {
      if (place.Text() != text) place.Expected(fmt::format("\"{}\"", text));
    });
  }
  template <typename CheckAt>
  void Check(const CheckAt& check) {
    if (keys_known_) check(place_);
  }

  static void Read(const Place& place, double& value) { value = place.NumberOrNull(); }
  static void Read(const Place& place, bool& value) { value = place.Flag(); }
  static void Read(const Place& place, std::int64_t& value) { value = place.Count(); }
  static void Read(const Place& place, std::string& value) { value = place.Text(); }
  static void Read(const Place& place, std::map<std::string, std::string>& values) {
    if (!place.value().is_object()) place.Expected("an object {...}");
    for (const auto& item : place.value().items())
      values[item.key()] = place[item.key().c_str()].Text();
  }
  static void Read(const Place& place, std::vector<double>& values) { values = place.Numbers(); }
  template <typename T>
  static void Read(const Place& place, std::vector<T>& values) {
    values.clear();
    for (const Place& one : place.List()) Read(one, values.emplace_back());
  }
  template <typename T, std::size_t kCount, typename... Rules>
  static void Read(const Place& place, std::array<T, kCount>& values, const Rules&... rules) {
    const std::vector<Place> places = place.List();
    if (places.size() != kCount) place.Expected(SizeOf(values));
    for (std::size_t i = 0; i < kCount; ++i) Read(places[i], values[i], rules...);
  }
  template <typename T, typename... Rules>
  static void Read(const Place& place, std::optional<T>& value, const Rules&... rules) {
    value.reset();
    if (!place.value().is_null()) Read(place, value.emplace(), rules...);
  }
  template <typename T>
  static void Read(const Place& place, T& value) {
    ReadObject(place, [&value](auto& field) { Fields(field, value); });
  }
  template <typename T>
  static void Read(const Place& place, T& value, Names names) {
    value = static_cast<T>(place.Choice(names));
  }
  static void Read(const Place& place, double& value, NeverNull) { value = place.Number(); }
  static void Read(const Place& place, double& value, AboveZero) { value = place.Positive(); }
  static void Read(const Place& place, double& value, InsteadOfNull) { Read(place, value); }
  static void Read(const Place& place, std::vector<double>& values, SquareOf square) {
    const std::size_t n = square.n;
    const std::vector<Place> rows = place.List();
    if (rows.size() != n) place.Fail(fmt::format("expected {} rows, found {}", n, rows.size()));
    values.clear();
    for (const Place& row : rows) {
      const std::vector<Place> numbers = row.List();
      if (numbers.size() != n)
        row.Fail(fmt::format("expected {} numbers, found {}", n, numbers.size()));
      for (const Place& number : numbers) values.push_back(number.NumberOrNull());
    }
  }
  template <typename T, typename... Rules>
  static void Read(const Place& place, T& value, NullUnless, const Rules&... rules) {
    if (!place.value().is_null()) Read(place, value, rules...);
  }

 private:
  // An object with the keys of the list and no others.
  template <typename List>
  static void ReadObject(const Place& place, const List& list) {
    FieldReader reader(place);
    list(reader);
    place.Keys(reader.needed_, reader.optional_);
    reader.keys_known_ = true;
    list(reader);
  }
  explicit FieldReader(const Place& place) : place_(place) {}
  template <typename ReadAt>
  void Visit(Key key, const ReadAt& read) {
    if (!keys_known_) {
      (key.later ? optional_ : needed_).push_back(key.name);
    } else if (!key.later || place_.Has(key.name)) {
      read(place_[key.name]);
    }
  }
  template <std::size_t kCount>
  static std::string SizeOf(const std::array<double, kCount>&) {
    return fmt::format("{} numbers", kCount);
  }
  template <std::size_t kCount>
  static std::string SizeOf(const std::array<bool, kCount>&) {
    return fmt::format("{} of true or false", kCount);
  }
  template <std::size_t kRows, std::size_t kColumns>
  static std::string SizeOf(const std::array<std::array<double, kColumns>, kRows>&) {
    return fmt::format("{} rows of {} numbers", kRows, kColumns);
  }

  Place place_;
  bool keys_known_ = false;
  std::vector<const char*> needed_, optional_;
};

template <typename T>
nlohmann::json WriteFields(const T& value) {
  return FieldWriter::Written(value);
}
// Throws DataError, as Place does.
template <typename T>
T ReadFields(const Place& place) {
  T value;
  FieldReader::Read(place, value);
  return value;
}

}  // namespace gyrobench
