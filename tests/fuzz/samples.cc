#include "tests/fuzz/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/recording/record_builder.h"
#include "tests/recording/sinks.h"

namespace gyrobench::testing {
namespace {

constexpr int kRows = 110;
constexpr double kInterval_s = 0.03;
constexpr double kRate_deg_s = 30.0;

// Rest, a turn at 30 deg/s, rest.
double Angle(int row) { return kRate_deg_s * std::clamp(row * kInterval_s - 1.2, 0.0, 0.9); }
double Rate(int row) { return (Angle(row + 1) - Angle(row - 1)) / (2.0 * kInterval_s); }
double Noise(int row) { return 0.05 * ((row * 37 % 11) - 5); }

std::string StandAngles() {
  std::string text =
      "# sensor = 7\n# site_latitude_deg = 55.75\n# gyro_lsb_per_deg_s = 131\n# power_on = A\n"
      "# segment = 0 1.2 rest first\n# defect = samples_lost 2 1.5 message 4\n"
      "t_s,gyro_x_lsb,gyro_y_lsb,gyro_z_lsb,accel_x_g,accel_y_g,accel_z_g,temp_degC,ref_outer_deg,"
      "ref_inner_deg,unit_tick_s,supply_v\n";
  for (int i = 0; i < kRows; ++i) {
    text += fmt::format("{:.3f},{},{},{},{:.3f},0,1,{:.2f},", i * kInterval_s, i % 5 - 2, i % 7,
                        std::lround(131.0 * Rate(i)) + i % 9, 0.01 * Noise(i), 25 + 0.01 * i);
    text += i % 2 == 0 ? fmt::format("0,{:.3f},", Angle(i)) : ",,";
    text += fmt::format("{:.4f},{}\n", 1.0001 * i * kInterval_s, i % 3 == 0 ? "" : "5.01");
  }
  return text;
}

std::string SensorAngle() {
  std::string text = "t_s,ref_angle_z_deg,gyro_x_deg_s,gyro_z_deg_s,accel_z_m_s2\n";
  for (int i = 0; i < kRows; ++i) {
    text += fmt::format("{:.3f},{:.2f},{:.2f},{:.2f},9.81\n", i * kInterval_s, Angle(i), Noise(i),
                        Rate(i) + Noise(i));
  }
  return text;
}

std::string Orientation() {
  std::string text = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,ref_qw,ref_qx,ref_qy,ref_qz\n";
  for (int i = 0; i < kRows; ++i) {
    const double half_rad = 0.5 * Angle(i) * std::numbers::pi / 180.0;
    text +=
        fmt::format("{:.3f},{:.5f},0,{:.5f},{:.7f},0,0,{:.7f}\n", i * kInterval_s, 0.001 * Noise(i),
                    Rate(i) * std::numbers::pi / 180.0, std::cos(half_rad), std::sin(half_rad));
  }
  return text;
}

std::string NoReference() {
  std::string text =
      "# accel_lsb_per_g = 16384\nt_s,gyro_x_lsb,gyro_y_lsb,gyro_z_lsb,accel_x_lsb,accel_y_lsb,"
      "accel_z_lsb,temp_degC\n";
  for (int i = 0; i < kRows; ++i) {
    text += fmt::format("{:.3f},{},{},{},{},3,16384,21.5\n", i * kInterval_s, i % 5, -i % 7, i % 3,
                        i % 11);
  }
  return text;
}

}  // namespace

std::vector<NamedBytes> SampleTables() {
  return {{"stand_angles", StandAngles()},
          {"sensor_angle", SensorAngle()},
          {"orientation", Orientation()},
          {"no_reference", NoReference()}};
}

SampleRecord MakeSampleRecord(const std::filesystem::path& scratch) {
  recording::RecordPlan plan;
  plan.blocks = 45;
  recording::BuildRecord(scratch, plan);
  return {recording::ReadFile(scratch / "events.lcmlog"),
          recording::ReadFile(scratch / "run.json")};
}

}  // namespace gyrobench::testing
