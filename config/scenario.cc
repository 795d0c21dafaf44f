#include "config/scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <utility>

#include "config/scenario_keys.h"
#include "config/toml_reader.h"

namespace gyrobench::config {
namespace {

constexpr std::array<const char*, 3> kAxes = {"outer", "middle", "inner"};

NumberRange RangeOf(const KeyInfo& info) { return {info.min, info.max, info.unit}; }

// Sets what the table says and leaves the rest.
class Reader {
 public:
  explicit Reader(TomlTable table) : table_(std::move(table)) {}

  void Number(std::string_view key, double& value, const KeyInfo& info) {
    value = table_.Number(key, RangeOf(info), value);
  }
  void Duration(std::string_view key, double& value, const KeyInfo& info) {
    value = table_.OptionalNumber(key, RangeOf(info)).value_or(value);
  }
  void Optional(std::string_view key, std::optional<double>& value, const KeyInfo& info) {
    if (const auto given = table_.OptionalNumber(key, RangeOf(info))) value = given;
  }
  template <std::size_t N>
  void Array(std::string_view key, std::array<double, N>& value, const KeyInfo& info) {
    if (!table_.Has(key)) return;
    const std::vector<double> given = table_.Numbers(key, RangeOf(info), {N, N});
    std::ranges::copy(given, value.begin());
  }
  template <class T>
  void Integer(std::string_view key, T& value, const KeyInfo& info) {
    const IntegerRange range{static_cast<std::int64_t>(info.min),
                             static_cast<std::int64_t>(info.max)};
    value = static_cast<T>(table_.Integer(key, range, value));
  }
  void Flag(std::string_view key, bool& value, std::string_view /*help*/) {
    value = table_.Bool(key, value);
  }
  template <class T>
  void Choice(std::string_view key, T& value, TomlTable::Choices<T> choices,
              std::string_view /*help*/) {
    value = table_.Choice(key, choices, value);
  }
  void Device(std::string_view key, std::string& value, std::string_view help) {
    value = table_.String(key);
    if (!IsDevice(value)) table_.Fail(key, fmt::format("expected one of {}", help));
  }
  template <class T>
  void Section(std::string_view key, T& part) {
    if (const auto table = table_.OptionalTable(key)) Read(*table, part);
  }
  // [key] for all axes, then [key.inner] and so on for one.
  template <class T>
  void PerAxis(std::string_view key, std::array<T, 3>& parts) {
    const auto table = table_.OptionalTable(key);
    if (!table) return;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      Read(*table, parts[i]);
      if (const auto own = table->OptionalTable(kAxes[i])) Read(*own, parts[i]);
    }
  }
  template <class T>
  void List(std::string_view key, std::vector<T>& items) {
    if (!table_.Has(key)) return;
    items.clear();
    for (const TomlTable& table : table_.Tables(key)) Read(table, items.emplace_back());
  }

 private:
  template <class T>
  static void Read(const TomlTable& table, T& part) {
    Reader reader(table);
    Describe(reader, part);
  }
  static bool IsDevice(std::string_view name) {
    if (name == "gyro" || name == "relays") return true;
    return std::ranges::any_of(kAxes, [&](const char* axis) {
      return name == fmt::format("{}.drive", axis) || name == fmt::format("{}.encoder", axis);
    });
  }

  TomlTable table_;
};

// Writes down what there is to set.
class Lister {
 public:
  Lister(std::string prefix, std::vector<ScenarioKey>& keys)
      : prefix_(std::move(prefix)), keys_(keys) {}

  void Number(std::string_view key, double value, const KeyInfo& info) {
    Add(key, fmt::format("{}", value), info);
  }
  void Duration(std::string_view key, double /*value*/, const KeyInfo& info) { Add(key, "", info); }
  void Optional(std::string_view key, const std::optional<double>& value, const KeyInfo& info) {
    Add(key, value ? fmt::format("{}", *value) : "", info);
  }
  template <std::size_t N>
  void Array(std::string_view key, const std::array<double, N>& value, const KeyInfo& info) {
    const bool same = std::ranges::all_of(value, [&](double v) { return v == value[0]; });
    Add(key, same ? fmt::format("{} x {}", N, value[0]) : fmt::format("{}", fmt::join(value, ", ")),
        info);
  }
  template <class T>
  void Integer(std::string_view key, T value, const KeyInfo& info) {
    Add(key, fmt::format("{}", value), info);
  }
  void Flag(std::string_view key, bool value, std::string_view help) {
    keys_.push_back({Name(key), "", value ? "true" : "false", "true, false", std::string(help)});
  }
  template <class T>
  void Choice(std::string_view key, const T& value, TomlTable::Choices<T> choices,
              std::string_view help) {
    std::vector<std::string_view> words;
    std::string_view now;
    for (const auto& [word, meaning] : choices) {
      words.push_back(word);
      if (meaning == value) now = word;
    }
    keys_.push_back({Name(key), "", std::string(now), fmt::format("{}", fmt::join(words, ", ")),
                     std::string(help)});
  }
  void Device(std::string_view key, const std::string& /*value*/, std::string_view help) {
    keys_.push_back({Name(key), "", "", "", std::string(help)});
  }
  template <class T>
  void Section(std::string_view key, T& part) {
    Lister lister(Name(key), keys_);
    Describe(lister, part);
  }
  template <class T>
  void PerAxis(std::string_view key, std::array<T, 3>& parts) {
    Section(key, parts[0]);
  }
  template <class T>
  void List(std::string_view key, std::vector<T>& /*items*/) {
    T item;
    Section(key, item);
  }

 private:
  std::string Name(std::string_view key) const {
    return prefix_.empty() ? std::string(key) : fmt::format("{}.{}", prefix_, key);
  }
  void Add(std::string_view key, std::string value, const KeyInfo& info) {
    keys_.push_back({Name(key), std::string(info.unit), std::move(value),
                     fmt::format("{:g} .. {:g}", info.min, info.max), std::string(info.help)});
  }

  std::string prefix_;
  std::vector<ScenarioKey>& keys_;
};

using Kind = FaultScenario::Kind;

// Which devices a kind of fault is for, by the end of their names.
std::vector<std::string_view> DevicesOf(Kind kind) {
  switch (kind) {
    case Kind::kFrozen:
    case Kind::kJump:
      return {"gyro", "encoder", "drive"};
    case Kind::kDropout:
    case Kind::kLoose:
      return {"encoder"};
    case Kind::kSaturation:
    case Kind::kOverheating:
    case Kind::kClockJump:
      return {"gyro"};
    case Kind::kAlarm:
    case Kind::kEmergencyStop:
    case Kind::kLimitPlus:
    case Kind::kLimitMinus:
    case Kind::kLostSteps:
    case Kind::kJammed:
    case Kind::kSlipping:
    case Kind::kRunaway:
      return {"drive"};
    default:
      return {"gyro", "relays", "encoder", "drive"};
  }
}

void CheckFaults(const TomlTable& root, const std::vector<FaultScenario>& faults) {
  if (faults.empty()) return;
  const std::vector<TomlTable> tables = root.Tables("fault");
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const auto devices = DevicesOf(faults[i].kind);
    const bool fits = std::ranges::any_of(
        devices, [&](std::string_view end) { return faults[i].device.ends_with(end); });
    if (!fits) {
      tables[i].Fail("kind", fmt::format("expected a fault that {} can have; this one is of: {}",
                                         faults[i].device, fmt::join(devices, ", ")));
    }
  }
}

void CheckCrossAxis(const TomlTable& root, std::string_view section, const Square& cross_axis) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (cross_axis[4 * i] == 0.0) continue;
    root.Table(section).Fail("cross_axis_rel",
                             "expected 0 on the diagonal; scale errors are scale_rel");
  }
}

}  // namespace

Scenario IdealScenario() {
  Scenario ideal;
  ideal.name = "ideal";
  ideal.thermal.self_heating_degC = 0.0;
  ideal.thermal.thermometer_noise_degC = 0.0;
  ideal.gyro.angle_random_walk_deg_sqrt_s = {};
  ideal.gyro.bias_random_walk_deg_s_sqrt_s = {};
  ideal.accelerometer.noise_g_sqrt_s = {};
  ideal.unit.tick_jitter_s = 0.0;
  for (MechanicsScenario& axis : ideal.mechanics) {
    axis.worm_1_deg = axis.worm_2_deg = axis.backlash_deg = axis.ripple_deg = 0.0;
    axis.pull_out_rpm_per_s = 1e9;
  }
  for (EncoderScenario& encoder : ideal.encoder) {
    encoder.noise_deg = encoder.latency_s = 0.0;
    encoder.refresh_s = 1e-6;
    encoder.eccentricity_1_deg = encoder.eccentricity_2_deg = 0.0;
  }
  ideal.bus.turnaround_s = 0.0;
  ideal.site.earth_rate = false;
  ideal.drawn = {.phases = false,
                 .gyro_scale_rel = 0.0,
                 .gyro_cross_axis_rel = 0.0,
                 .gyro_scale_temperature_per_degC = 0.0,
                 .gyro_bias_deg_s = 0.0,
                 .gyro_bias_deg_s_per_degC = 0.0,
                 .gyro_bias_deg_s_per_degC2 = 0.0,
                 .gyro_bias_deg_s_per_degC3 = 0.0,
                 .gyro_g_linear_deg_s_per_g = 0.0,
                 .gyro_g_squared_deg_s_per_g2 = 0.0,
                 .sample_clock_rel = 0.0,
                 .accelerometer_offset_g = 0.0,
                 .accelerometer_scale_rel = 0.0,
                 .accelerometer_cross_axis_rel = 0.0,
                 .thermometer_offset_degC = 0.0,
                 .tick_rel = 0.0,
                 .drive_clock_rel = 0.0,
                 .mount_deg = 0.0};
  return ideal;
}

Scenario LoadScenario(const std::filesystem::path& file) {
  return TomlTable::FromFile(file).ReadWhole([&](const TomlTable& root) {
    const bool ideal = root.Choice("based_on", {{"typical", false}, {"ideal", true}}, false);
    Scenario scenario = ideal ? IdealScenario() : Scenario{};
    scenario.name = root.String("name", file.stem().string());
    Reader reader(root);
    Describe(reader, scenario);
    CheckFaults(root, scenario.faults);
    CheckCrossAxis(root, "gyro", scenario.gyro.cross_axis_rel);
    CheckCrossAxis(root, "accelerometer", scenario.accelerometer.cross_axis_rel);
    return scenario;
  });
}

std::vector<FaultScenario> LoadFaults(const std::filesystem::path& file) {
  return TomlTable::FromFile(file).ReadWhole([&](const TomlTable& root) {
    std::vector<FaultScenario> faults;
    Reader(root).List("fault", faults);
    CheckFaults(root, faults);
    return faults;
  });
}

std::vector<ScenarioKey> ScenarioKeys() {
  std::vector<ScenarioKey> keys = {
      {"name", "", "file name", "", "for messages"},
      {"based_on", "", "typical", "typical, ideal", "what holds where this file is silent"}};
  Lister lister("", keys);
  Scenario defaults;
  Describe(lister, defaults);
  return keys;
}

}  // namespace gyrobench::config
