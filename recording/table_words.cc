#include "recording/table_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <vector>

#include "base/geometry.h"
#include "base/nearest_word.h"

namespace gyrobench::recording {
namespace {

// Words in small letters, split at anything that is neither letter nor digit, and before a capital
// that follows a small letter (GyroZ) unless it ends a unit (degC).
std::vector<std::string> WordsOf(std::string_view name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool capital = std::isupper(c) != 0 && i > 0 &&
                         std::islower(static_cast<unsigned char>(name[i - 1])) != 0 &&
                         !name.substr(0, i).ends_with("deg");
    if ((std::isalnum(c) == 0 || capital) && !words.back().empty()) words.emplace_back();
    if (std::isalnum(c) != 0) words.back() += static_cast<char>(std::tolower(c));
  }
  if (words.back().empty()) words.pop_back();
  const auto dps = std::find(words.begin(), words.end(), "dps");
  if (dps != words.end()) {
    *dps = "deg";
    words.insert(dps + 1, "s");
  }
  return words;
}

std::string Joined(const std::vector<std::string>& words, std::size_t from = 0) {
  std::string text;
  for (std::size_t i = from; i < words.size(); ++i) text += (i > from ? "_" : "") + words[i];
  return text;
}

// Same words, but for a few slips of the pen in a long name.
bool IsMistyped(const std::vector<std::string>& words, std::string_view known) {
  constexpr std::size_t kLettersPerSlip = 6;
  const std::vector<std::string> expected = WordsOf(known);
  if (words.size() != expected.size()) return false;
  // A number makes it another of the kind: temp2_degC.
  const auto digits = [](const std::string& text) {
    return std::count_if(text.begin(), text.end(),
                         [](unsigned char c) { return std::isdigit(c) != 0; });
  };
  const std::string text = Joined(words), right = Joined(expected);
  const auto slips = static_cast<int>(right.size() / kLettersPerSlip);
  return digits(text) == digits(right) && EditDistance(text, right) <= slips;
}

std::string WithoutLastWord(const std::string& name) { return name.substr(0, name.rfind('_')); }

bool IsNearKey(const std::vector<std::string>& words, const std::string& known) {
  const std::string key = Joined(words);
  if (key == Joined(WordsOf(known)) || IsMistyped(words, known)) return true;
  if (words.size() < 2) return false;
  // Cut short, or with another last word where two words and more are the same.
  const bool cut = known.starts_with(key + "_");
  const bool other_end = words.size() > 2 && WithoutLastWord(key) == WithoutLastWord(known);
  return cut || other_end;
}

using Units = std::map<std::string, std::string>;

// Units as people write them, and the one of the format that comes nearest.
const Units kRates = {{"", "deg_s"},          {"degs", "deg_s"},        {"deg_per_s", "deg_s"},
                      {"deg_sec", "deg_s"},   {"deg_per_sec", "deg_s"}, {"degree_s", "deg_s"},
                      {"degrees_s", "deg_s"}, {"deg_s", "deg_s"},       {"mdps", "deg_s"},
                      {"mdeg_s", "deg_s"},    {"deg_h", "deg_s"},       {"dph", "deg_s"},
                      {"deg", "deg_s"},       {"rad_s", "rad_s"},       {"rads", "rad_s"},
                      {"rps", "rad_s"},       {"rad_per_s", "rad_s"},   {"rad_sec", "rad_s"},
                      {"rad", "rad_s"},       {"mrad_s", "rad_s"},      {"lsb", "lsb"},
                      {"raw", "lsb"},         {"count", "lsb"},         {"counts", "lsb"},
                      {"adc", "lsb"},         {"digits", "lsb"}};
const Units kForces = {{"", "g"},         {"g", "g"},        {"mg", "g"},          {"gs", "g"},
                       {"m_s2", "m_s2"},  {"ms2", "m_s2"},   {"m_ss", "m_s2"},     {"mps2", "m_s2"},
                       {"m_s_2", "m_s2"}, {"m_s_s", "m_s2"}, {"m_per_s2", "m_s2"}, {"lsb", "lsb"},
                       {"raw", "lsb"},    {"count", "lsb"},  {"counts", "lsb"},    {"adc", "lsb"},
                       {"digits", "lsb"}};
const Units kTemperatures = {{"", "degC"},       {"c", "degC"},       {"degc", "degC"},
                             {"deg_c", "degC"},  {"celsius", "degC"}, {"k", "degC"},
                             {"kelvin", "degC"}, {"f", "degC"},       {"degf", "degC"},
                             {"deg", "degC"},    {"lsb", "degC"},     {"raw", "degC"}};
const Units kAngles = {{"", "deg"},        {"deg", "deg"}, {"degs", "deg"},  {"degree", "deg"},
                       {"degrees", "deg"}, {"rad", "deg"}, {"mrad", "deg"},  {"turn", "deg"},
                       {"turns", "deg"},   {"rev", "deg"}, {"count", "deg"}, {"counts", "deg"},
                       {"lsb", "deg"}};

bool IsOneOf(const std::string& word, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool IsAxis(const std::string& word) { return IsOneOf(word, {"x", "y", "z"}); }

// The axis at the end of a word in one piece, as in gyroz, becomes a word of its own.
void SplitAxis(std::vector<std::string>* words) {
  std::string& first = words->front();
  const std::string stem = first.substr(0, first.size() - 1), axis = first.substr(first.size() - 1);
  if (!IsAxis(axis) || !IsOneOf(stem, {"gyro", "gyr", "gyroscope", "acc", "accel", "ref"})) return;
  first = stem;
  words->insert(words->begin() + 1, axis);
}

// <stem>_<axis>_<unit> with a unit of `units`.
std::string OfAnAxis(const std::vector<std::string>& words, const char* stem, const Units& units) {
  if (words.size() < 2 || !IsAxis(words[1])) return "";
  const auto unit = units.find(Joined(words, 2));
  return unit == units.end() ? "" : std::string(stem) + "_" + words[1] + "_" + unit->second;
}

std::string OfTheReference(std::vector<std::string> words) {
  words.erase(words.begin());
  if (words.size() == 1 && IsOneOf(words[0], {"qw", "qx", "qy", "qz"})) return "ref_" + words[0];
  if (words.size() == 2 && IsOneOf(words[0], {"q", "quat"}) &&
      (IsAxis(words[1]) || words[1] == "w"))
    return "ref_q" + words[1];
  if (!words.empty() && words[0] == "angle") words.erase(words.begin());
  std::string axis = "z";
  const bool stand = !words.empty() && IsOneOf(words[0], {"outer", "middle", "inner"});
  const bool any = stand || (!words.empty() && IsAxis(words[0]));
  if (any) {
    axis = words[0];
    words.erase(words.begin());
  }
  if (!kAngles.contains(Joined(words))) return "";
  return stand ? "ref_" + axis + "_deg" : "ref_angle_" + axis + "_deg";
}

// A name of the right words with a unit that is not the table's, or with none.
std::string OfAnotherUnit(const std::vector<std::string>& words) {
  const std::string& first = words.front();
  if (IsOneOf(first, {"gyro", "gyr", "gyroscope"})) return OfAnAxis(words, "gyro", kRates);
  if (IsOneOf(first, {"accel", "acc", "acceleration", "accelerometer"}))
    return OfAnAxis(words, "accel", kForces);
  if (IsOneOf(first, {"temp", "temperature"}))
    return kTemperatures.contains(Joined(words, 1)) ? "temp_degC" : "";
  if (IsOneOf(first, {"ref", "reference"})) return OfTheReference(words);
  return "";
}

std::string Mistyped(const std::vector<std::string>& words) {
  constexpr std::array<const char*, 5> kWhole = {"temp_degC", "ref_outer_deg", "ref_middle_deg",
                                                 "ref_inner_deg", "unit_tick_s"};
  for (const char* known : kWhole) {
    if (IsMistyped(words, known)) return known;
  }
  for (const char* stem : {"gyro", "accel", "ref_angle"}) {
    for (const char* axis : {"x", "y", "z"}) {
      const std::string unit = stem == std::string("gyro")    ? "_deg_s"
                               : stem == std::string("accel") ? "_m_s2"
                                                              : "_deg";
      const std::string known = std::string(stem) + "_" + axis + unit;
      // A mistyped axis is not to be guessed.
      if (words.size() > 1 && words[1] == axis && IsMistyped(words, known)) return known;
    }
  }
  return "";
}

}  // namespace

std::string NearestKey(std::string_view key) {
  constexpr std::size_t kLongest = 40;  // longer ones are sentences
  if (key.size() > kLongest || key.find(' ') != std::string_view::npos) return "";
  std::vector<std::string> known = {"site_latitude_deg",
                                    "site_heading_deg",
                                    "gyro_lsb_per_deg_s",
                                    "accel_lsb_per_g",
                                    "gyro_lsb_zero",
                                    "accel_lsb_zero",
                                    "gear_ratio",
                                    "stop_accuracy_deg",
                                    "sensor",
                                    "power_on",
                                    "ref_scale_uncertainty",
                                    "ref_eccentricity_deg",
                                    "ref_alignment_deg",
                                    "gyro_delay_s",
                                    "ref_delay_s",
                                    "segment",
                                    "defect"};
  StandGeometry geometry;
  for (const GeometryAngle& angle : AnglesOf(geometry)) known.emplace_back(angle.name);
  const std::vector<std::string> words = WordsOf(key);
  if (words.empty()) return "";
  if (std::ranges::find(known, key) != known.end()) return std::string(key);
  for (const std::string& one : known) {
    if (IsNearKey(words, one)) return one;
  }
  return "";
}

std::string NearestColumn(std::string_view column) {
  std::vector<std::string> words = WordsOf(column);
  if (words.empty()) return "";
  SplitAxis(&words);
  const std::string other_unit = OfAnotherUnit(words);
  return other_unit.empty() ? Mistyped(words) : other_unit;
}

bool MeansTime(std::string_view column) {
  constexpr std::array<std::string_view, 11> kTimes = {
      "t",       "time",     "times", "timestamp", "t_ms",       "time_s",
      "time_ms", "time_sec", "t_sec", "seconds",   "timestamp_s"};
  return std::ranges::find(kTimes, Joined(WordsOf(column))) != kTimes.end();
}

}  // namespace gyrobench::recording
