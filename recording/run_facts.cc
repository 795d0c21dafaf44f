// run.json as facts for people. One damaged field costs that field, and is named.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "base/json_text.h"
#include "recording/plausible.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

using nlohmann::json;

namespace {

class FactReader {
 public:
  FactReader(const json& object, std::string path, std::vector<std::string>& damage)
      : object_(object), path_(std::move(path)), damage_(damage) {
    if (!object_.is_object()) Complain("", object_, "an object {...}");
  }

  void Read(const char* key, std::string& text) const {
    const json* value = Find(key);
    if (value == nullptr) return;
    if (value->is_string()) {
      text = value->get<std::string>();
    } else {
      Complain(key, *value, "a text");
    }
  }
  void Read(const char* key, double& number) const {
    const json* value = Find(key);
    if (value == nullptr) return;
    if (value->is_number() && IsPlausible(value->get<double>())) {
      number = value->get<double>();
    } else {
      Complain(key, *value, "a number");
    }
  }
  void Read(const char* key, Utime& utime) const {
    const json* value = Find(key);
    if (value == nullptr) return;
    constexpr double kLatest = 1.0 * kLatestUtime;
    if (value->is_number_integer() && std::abs(value->get<double>()) <= kLatest) {
      utime = value->get<Utime>();
    } else {
      Complain(key, *value, "microseconds since the epoch");
    }
  }
  // Reads the members of an object, or nothing where there is none.
  template <typename Members>
  void Within(const char* key, const Members& members) const {
    if (const json* value = Find(key)) members(FactReader(*value, path_ + key + ".", damage_));
  }
  template <typename Entry>
  void Each(const char* key, const Entry& entry) const {
    const json* list = Find(key);
    if (list == nullptr) return;
    if (!list->is_array()) Complain(key, *list, "a list [...]");
    for (std::size_t i = 0; list->is_array() && i < list->size(); ++i)
      entry(FactReader((*list)[i], fmt::format("{}{}[{}].", path_, key, i), damage_));
  }
  // All of an object, as a person reads them.
  void ReadAll(std::vector<std::pair<std::string, std::string>>& values) const {
    if (!object_.is_object()) return;
    for (const auto& [name, value] : object_.items()) values.emplace_back(name, Plain(value));
  }

 private:
  static std::string Plain(const json& value) {
    if (value.is_string()) return value.get<std::string>();
    return value.is_number_float() ? fmt::format("{}", value.get<double>()) : JsonText(value);
  }
  const json* Find(const char* key) const {
    const auto found = object_.find(key);
    return object_.is_object() && found != object_.end() && !found->is_null() ? &*found : nullptr;
  }
  void Complain(const std::string& key, const json& found, const char* expected) const {
    constexpr std::size_t kShown = 60;
    std::string name = path_ + key, text = JsonText(found);
    if (name.ends_with('.')) name.pop_back();
    if (text.size() > kShown) text.replace(kShown, std::string::npos, "...");
    damage_.push_back(fmt::format("{}{}expected {}, found {}: it is left out", name,
                                  name.empty() ? "" : ": ", expected, text));
  }

  const json& object_;
  std::string path_;  // of the object, with the point behind it
  std::vector<std::string>& damage_;
};

}  // namespace

RunFacts RunFactsFromJson(const json& run) {
  RunFacts facts;
  const FactReader reader(run, "", facts.damage);
  reader.Read(kRunIdKey, facts.run_id);
  reader.Read("procedure", facts.procedure);
  reader.Read("version", facts.version);
  reader.Read(kStartUtimeKey, facts.started_utime);
  reader.Read("end_utime", facts.ended_utime);
  reader.Within("stand", [&](const FactReader& stand) { stand.Read("name", facts.configuration); });
  reader.Within(kMeasurementKey, [&](const FactReader& measurement) {
    measurement.Read("sensor", facts.sensor);
    measurement.Read("power_on_utime", facts.power_on_utime);
  });
  reader.Within("parameters", [&](const FactReader& all) { all.ReadAll(facts.parameters); });
  reader.Each(kSaidKey, [&](const FactReader& entry) {
    RunFacts::Said& said = facts.said.emplace_back();
    entry.Read("t_s", said.t_s);
    entry.Read("text", said.text);
  });
  return facts;
}

RunFacts ReadRunFacts(const std::filesystem::path& folder) {
  try {
    return RunFactsFromJson(ReadJson(folder / kRunJsonName));
  } catch (const DataError& error) {
    RunFacts facts;
    facts.damage.emplace_back(error.what());
    return facts;
  }
}

}  // namespace gyrobench::recording
