#include "cli/stored_results.h"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/error.h"
#include "calibration/artefact/trace_fields.h"
#include "calibration/estimators/result_fields.h"
#include "cli/json_field.h"

namespace gyrobench::cli {
namespace {

template <typename T>
concept HasFields = requires(FieldWriter& writer, const T& value) {
  Fields(writer, value);
};

// Visits the fields of one object as FieldReader does, but takes what is missing, null or of
// another kind for not known: another version may have had other fields.
class StoredFields {
 public:
  template <typename T>
  using Field = T;
  explicit StoredFields(const nlohmann::json& object) : object_(object) {}

  template <typename T, typename... Rules>
  void operator()(Key key, T& value, const Rules&... rules) {
    Read(cli::Field(object_, key.name), value, rules...);
  }
  template <typename T>
  void LaterAs(const char* key, T& value, const T& other) {
    value = other;
    (*this)(key, value);
  }
  template <typename List>
  void Group(Key key, const List& list) {
    StoredFields part(cli::Field(object_, key.name));
    list(part);
  }
  void Constant(const char*, const char*) {}

 private:
  template <typename T, typename... Rules>
  static void Read(const nlohmann::json& json, T& value, const Rules&... rules) {
    static const std::string kNoFile;
    T read = value;
    try {
      FieldReader::Read(Place(json, kNoFile), read, rules...);
      value = std::move(read);
    } catch (const DataError&) {  // stays as it is
    }
  }
  // One number that is not known leaves the others of its list in their places.
  static void Read(const nlohmann::json& json, std::vector<double>& values) {
    if (!json.is_array()) return;
    for (const nlohmann::json& one : json) {
      double number = kMissing;
      Read<double>(one, number);
      values.push_back(number);
    }
  }
  template <HasFields T>
  static void Read(const nlohmann::json& json, T& value) {
    StoredFields reader(json);
    Fields(reader, value);
  }
  template <HasFields T>
  static void Read(const nlohmann::json& json, std::vector<T>& values) {
    if (!json.is_array()) return;
    for (const nlohmann::json& one : json) Read(one, values.emplace_back());
  }

  const nlohmann::json& object_;
};

template <typename T>
T ReadStored(const nlohmann::json& json) {
  T value;
  StoredFields reader(json);
  Fields(reader, value);
  return value;
}

}  // namespace

calibration::AnalysisResult ReadAnalysis(const nlohmann::json& json) {
  auto result = ReadStored<calibration::AnalysisResult>(json);
  if (Field(json, "info").is_null()) result.info.source = Text(json, "source");
  return result;
}

calibration::TraceResult ReadTrace(const nlohmann::json& json) {
  return ReadStored<calibration::TraceResult>(json);
}

}  // namespace gyrobench::cli
