// Fields of a table's line as text, and names in its head that were meant to be one of the format's
// own.
#pragma once

#include <string>
#include <string_view>

namespace gyrobench::recording {

// The key that an unknown one of a table's head was most likely meant to be: written otherwise
// (Gear-Ratio), mistyped, cut short (site_latitude), or in another unit (mount_x_rad). Empty where
// it is no such thing.
std::string NearestKey(std::string_view key);

// The same of a column: gyro_z_deg_s for gyro_z_dps, temp_degC for temperature, ref_angle_z_deg for
// ref_z_deg. A further quantity (supply_v, humidity, temp_board_degC, gyro_supply_v) is none.
std::string NearestColumn(std::string_view column);

// A column by this name was meant to be t_s.
bool MeansTime(std::string_view column);

// Without blanks and line ends at both ends.
inline std::string_view Trim(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

// Trimmed, and without the double quotes that spreadsheets put around a field.
inline std::string_view Unquote(std::string_view text) {
  text = Trim(text);
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return text;
  return Trim(text.substr(1, text.size() - 2));
}

}  // namespace gyrobench::recording
