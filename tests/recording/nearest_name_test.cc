// Names that were meant to be the format's own are told from names of other quantities.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <string>
#include <utility>

#include "recording/table_words.h"

namespace gyrobench::recording {
namespace {

TEST(NearestColumn, IsShownForWhatPeopleWrite) {
  const std::pair<const char*, const char*> kNames[] = {{"gyro_z_dps", "gyro_z_deg_s"},
                                                        {"gyro_z", "gyro_z_deg_s"},
                                                        {"GyroX", "gyro_x_deg_s"},
                                                        {"gyroy_rads", "gyro_y_rad_s"},
                                                        {"Gyro_Z_LSB", "gyro_z_lsb"},
                                                        {"gyr_x_raw", "gyro_x_lsb"},
                                                        {"gyro_y_deg_per_s", "gyro_y_deg_s"},
                                                        {"gryo_z_deg_s", "gyro_z_deg_s"},
                                                        {"temperature", "temp_degC"},
                                                        {"temp", "temp_degC"},
                                                        {"Temp_degC", "temp_degC"},
                                                        {"temperature_degC", "temp_degC"},
                                                        {"temp_c", "temp_degC"},
                                                        {"tmep_degC", "temp_degC"},
                                                        {"temp_K", "temp_degC"},
                                                        {"ref_z_deg", "ref_angle_z_deg"},
                                                        {"ref_angle_deg", "ref_angle_z_deg"},
                                                        {"ref_inner", "ref_inner_deg"},
                                                        {"ref_outer_rad", "ref_outer_deg"},
                                                        {"reference_x_deg", "ref_angle_x_deg"},
                                                        {"ref_quat_w", "ref_qw"},
                                                        {"ref_q_x", "ref_qx"},
                                                        {"acc_x_g", "accel_x_g"},
                                                        {"accel_y", "accel_y_g"},
                                                        {"accel_z_ms2", "accel_z_m_s2"},
                                                        {"acceleration_z_m_s2", "accel_z_m_s2"},
                                                        {"unit_tik_s", "unit_tick_s"},
                                                        {"ref_iner_deg", "ref_inner_deg"}};
  for (const auto& [written, meant] : kNames) {
    EXPECT_EQ(NearestColumn(written), meant) << written;
  }
}

TEST(NearestColumn, IsNoneOfAnotherQuantity) {
  for (const char* name : {"supply_v",
                           "humidity",
                           "motor_current_a",
                           "fan",
                           "fan_rpm",
                           "current_a",
                           "constant",
                           "pressure_pa",
                           "temp_board_degC",
                           "temp2_degC",
                           "room_temp_degC",
                           "temp_degC_2",
                           "gyro_z_volt",
                           "gyro_supply_v",
                           "gyro_temp_degC",
                           "ref_temp_degC",
                           "accel_temp_degC",
                           "mag_x_ut",
                           "motor_rate_deg_s",
                           "x",
                           "time",
                           "copy_of_t",
                           "index",
                           "unit"}) {
    EXPECT_EQ(NearestColumn(name), "") << name;
  }
}

TEST(NearestKey, IsShownForWhatPeopleWrite) {
  const std::pair<const char*, const char*> kNames[] = {
      {"Site_Latitude_deg", "site_latitude_deg"},
      {"site_latitude", "site_latitude_deg"},
      {"site_lattitude_deg", "site_latitude_deg"},
      {"gyro_lsb_per_dps", "gyro_lsb_per_deg_s"},
      {"gear-ratio", "gear_ratio"},
      {"gear_ration", "gear_ratio"},
      {"power-on", "power_on"},
      {"sensr", "sensor"},
      {"mount_x_rad", "mount_x_deg"},
      {"gyro_lsb_offset", "gyro_lsb_zero"},
      {"ref_scale_uncertanty", "ref_scale_uncertainty"},
      {"stop_accuracy", "stop_accuracy_deg"}};
  for (const auto& [written, meant] : kNames) {
    EXPECT_EQ(NearestKey(written), meant) << written;
  }
}

// A key that the page has and this list forgot would show here: it would not be suggested.
TEST(NearestKey, KnowsEveryKeyOfThePage) {
  std::ifstream page(std::string(GYROBENCH_SOURCE_DIR) + "/docs/measurement-table.md");
  const std::regex name("`([a-z0-9_]+)`");
  std::string line;
  bool keys = false;
  int found = 0;
  while (std::getline(page, line)) {
    if (line.starts_with("| key |")) keys = true;
    if (line.empty()) keys = false;
    if (!keys || !line.starts_with("| `")) continue;
    const std::string cell = line.substr(0, line.find('|', 1));
    for (std::sregex_iterator match(cell.begin(), cell.end(), name), end; match != end; ++match) {
      const std::string key = (*match)[1];
      EXPECT_EQ(NearestKey(key), key);
      EXPECT_EQ(NearestKey(key + "x"), key);
      ++found;
    }
  }
  EXPECT_GT(found, 15);
}

TEST(NearestKey, IsNoneOfANote) {
  for (const char* key :
       {"operator", "procedure", "date", "corrected_by", "comment", "laboratory", "stand", "gyro",
        "a", "note", "site", "room_temperature_degC", "sensor_model", "filter", "version",
        "the axis was turned by hand until angle", "part parameter seed"}) {
    EXPECT_EQ(NearestKey(key), "") << key;
  }
}

}  // namespace
}  // namespace gyrobench::recording
