#include "cli/stored_results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/json_text.h"
#include "calibration/artefact/trace_fields.h"
#include "calibration/estimators/result_fields.h"
#include "cli/json_field.h"

namespace gyrobench::cli {
namespace {

template <typename T>
concept HasFields = requires(FieldWriter& writer, const T& value) {
  Fields(writer, value);
};

// What an entry of a list is of, for the sentences on those that are left out.
template <typename T>
std::string SubjectOf(const T& /*entry*/) {
  return "axis";
}
std::string SubjectOf(const calibration::TracedEffect& effect) {
  return effect.id.empty() ? "effect" : fmt::format("effect ({})", effect.id);
}

template <typename T, typename... Rules>
constexpr bool kIsName = std::is_enum_v<T> && sizeof...(Rules) == 1 &&
                         (std::is_convertible_v<const Rules&, Names> && ...);

// Visits the fields of one object as FieldReader does, but takes what is missing, null or of
// another kind for not known: another version may have had other fields.
class StoredFields {
 public:
  template <typename T>
  using Field = T;
  // `path`: of the object, for the sentences of `not_known`.
  StoredFields(const nlohmann::json& object, std::string path, std::vector<std::string>& not_known)
      : object_(object), path_(std::move(path)), not_known_(not_known) {}

  template <typename T, typename... Rules>
  void operator()(Key key, T& value, const Rules&... rules) {
    const nlohmann::json& stored = cli::Field(object_, key.name);
    if constexpr (kIsName<T, Rules...>) {
      ReadName(stored, key.name, value, rules...);
    } else {
      Read(stored, PathOf(key.name), value, rules...);
    }
  }
  template <typename T>
  void LaterAs(const char* key, T& value, const T& other) {
    value = other;
    (*this)(key, value);
  }
  template <typename T>
  void IfThere(const char* key, std::optional<T>& value) {
    const nlohmann::json& json = cli::Field(object_, key);
    T stored{};
    if (!json.is_null() && ReadValue(json, stored)) value = std::move(stored);
  }
  template <typename List>
  void Group(Key key, const List& list) {
    StoredFields part(cli::Field(object_, key.name), PathOf(key.name), not_known_);
    list(part);
    part.SayUnread(kOnlyNotKnown);
  }
  void Constant(const char*, const char*) {}

  // What the file is of.
  template <typename T>
  void ReadTop(T& value) {
    Fields(*this, value);
    SayUnread(kOnlyNotKnown);
  }

 private:
  static constexpr const char* kOnlyNotKnown = "it is not known here";

  std::string PathOf(const std::string& key) const { return path_ + "." + key; }

  template <typename Enum>
  void ReadName(const nlohmann::json& json, const char* key, Enum& value, Names names) {
    const auto found = std::ranges::find_if(
        names, [&](const char* name) { return json.is_string() && json == name; });
    if (found != names.end()) {
      value = static_cast<Enum>(found - names.begin());
      return;
    }
    if (!object_.is_object()) return;  // all of it is not there
    unread_.push_back(fmt::format("{} is {}, and this version knows {}", PathOf(key),
                                  json.is_null() ? "not there" : JsonText(json),
                                  fmt::join(names, ", ")));
  }

  template <typename T, typename... Rules>
  void Read(const nlohmann::json& json, const std::string&, T& value, const Rules&... rules) {
    ReadValue(json, value, rules...);
  }
  // False where it is of another kind, and `value` as it was.
  template <typename T, typename... Rules>
  bool ReadValue(const nlohmann::json& json, T& value, const Rules&... rules) {
    static const std::string kNoFile;
    T read = value;
    try {
      FieldReader::Read(Place(json, kNoFile), read, rules...);
    } catch (const DataError&) {
      return false;
    }
    value = std::move(read);
    return true;
  }
  // One number that is not known leaves the others of its list in their places.
  void Read(const nlohmann::json& json, const std::string& path, std::vector<double>& values) {
    if (!json.is_array()) return;
    for (const nlohmann::json& one : json) {
      double number = kMissing;
      Read<double>(one, path, number);
      values.push_back(number);
    }
  }
  template <HasFields T>
  void Read(const nlohmann::json& json, const std::string& path, T& value) {
    StoredFields reader(json, path, not_known_);
    Fields(reader, value);
    reader.SayUnread(kOnlyNotKnown);
  }
  template <HasFields T>
  void Read(const nlohmann::json& json, const std::string& path, std::vector<T>& values) {
    if (!json.is_array()) return;
    for (std::size_t i = 0; i < json.size(); ++i) {
      const std::string place = fmt::format("{}[{}]", path, i);
      T value;
      if (ReadWhole(json[i], place, value)) values.push_back(std::move(value));
    }
  }
  // False where a name of the entry, what it is of or how it was judged, is not known: a default in
  // its place would be a statement that nobody made.
  template <typename T>
  bool ReadWhole(const nlohmann::json& json, const std::string& path, T& value) {
    StoredFields reader(json, path, not_known_);
    Fields(reader, value);
    if constexpr (std::is_same_v<T, calibration::ChannelTrace>) {
      if (reader.unread_.empty() && !IsTraced(value) && !cli::Field(json, "baseline").is_object())
        reader.unread_.push_back(path +
                                 ".baseline is not there, which says whether the axis was traced");
    }
    reader.SayUnread(fmt::format("nothing is said of that {} here", SubjectOf(value)));
    return reader.unread_.empty();
  }
  void SayUnread(const std::string& consequence) const {
    for (const std::string& why : unread_)
      not_known_.push_back(fmt::format("{}: {}", why, consequence));
  }

  const nlohmann::json& object_;
  std::string path_;
  std::vector<std::string>& not_known_;
  std::vector<std::string> unread_;  // names of this object that are not known, or not there
};

template <typename T>
T ReadStored(const nlohmann::json& json, const char* what, std::vector<std::string>& not_known) {
  T value;
  StoredFields reader(json, what, not_known);
  reader.ReadTop(value);
  return value;
}

}  // namespace

calibration::AnalysisResult ReadAnalysis(const nlohmann::json& json) {
  std::vector<std::string> not_known;
  auto result = ReadStored<calibration::AnalysisResult>(json, "result", not_known);
  if (Field(json, "info").is_null()) result.info.source = Text(json, "source");
  result.remarks.insert(result.remarks.end(), not_known.begin(), not_known.end());
  return result;
}

StoredTrace ReadTrace(const nlohmann::json& json) {
  StoredTrace trace;
  trace.result = ReadStored<calibration::TraceResult>(json, "trace", trace.not_known);
  return trace;
}

presentation::Document WiringDocument(const nlohmann::json& wiring) {
  presentation::Document document;
  const nlohmann::json& findings = Field(wiring, "findings");
  if (!findings.is_array()) return document;
  if (findings.empty())
    Add(document, presentation::Paragraph{"The stand is wired as its file says."});
  for (const nlohmann::json& finding : findings) {
    presentation::Section section{Text(finding, "what"), {}};
    Add(section.blocks, presentation::Paragraph{Text(finding, "reason")});
    presentation::List lines;
    for (const nlohmann::json& line : Field(finding, "corrections")) {
      lines.items.emplace_back(fmt::format("{} = {} (was {})", Text(line, "key"),
                                           Text(line, "value"), Text(line, "was")));
    }
    Add(section.blocks, std::move(lines));
    Add(document, std::move(section));
  }
  presentation::Section well{"As it should be", {}};
  presentation::List notes;
  for (const nlohmann::json& note : Field(wiring, "notes")) notes.items.emplace_back(Plain(note));
  Add(well.blocks, std::move(notes));
  Add(document, std::move(well));
  return document;
}

}  // namespace gyrobench::cli
