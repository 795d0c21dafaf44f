// A user's own table that is wrong in a common way: every command that reads it names the cause.
// The tables are of simple turns, summed up here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <sstream>

#include "tests/cli/child_process.h"
#include "tests/cli/gyro_z.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kStep_s = 0.01;

// What was true at one time. `noise`: of unit variance.
struct Moment {
  int index = 0;
  double t_s = 0.0, rate_deg_s = 0.0, angle_deg = 0.0, noise = 0.0;
  // Of a sensor that scales by itself, 1 % off, and of one that counts.
  double gyro_deg_s() const { return 1.01 * rate_deg_s + 0.3 + 0.02 * noise; }
  double gyro_lsb() const { return std::round(131.0 * gyro_deg_s()); }
};

struct Turning {
  double period_s = 5.0, rest_s = 2.0;
  std::vector<double> rates_deg_s = {6.0, -12.0, 18.0, -6.0, 12.0, -18.0};
  double duration_s = 240.0;
};

using Row = std::vector<double>;

// A table with one row each kStep_s. NaN: an empty field.
std::string Table(const std::string& head, const std::function<Row(const Moment&)>& row,
                  const Turning& turning = {}) {
  std::ostringstream table;
  table.precision(10);
  table << head << '\n';
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Moment now;
  double before_deg_s = 0.0;
  for (now.index = 0; now.index * kStep_s < turning.duration_s; ++now.index) {
    now.t_s = now.index * kStep_s;
    const auto turn = static_cast<std::size_t>(now.t_s / turning.period_s + 1e-9);
    const bool rests = now.t_s - static_cast<double>(turn) * turning.period_s < turning.rest_s;
    now.rate_deg_s = rests ? 0.0 : turning.rates_deg_s[turn % turning.rates_deg_s.size()];
    now.angle_deg += 0.5 * (now.rate_deg_s + before_deg_s) * kStep_s;
    before_deg_s = now.rate_deg_s;
    now.noise = normal(random);
    table << now.t_s;
    for (const double value : row(now)) {
      table << ',';
      if (std::isfinite(value)) table << value;
    }
    table << '\n';
  }
  return table.str();
}

class WrongTable : public testing::Test {
 protected:
  std::string Write(const std::string& text) { return folder_.Write("wrong.csv", text); }
  // What each of the two says on stderr; both fail.
  void ExpectCause(const std::string& table, const testing::Matcher<const std::string&>& cause) {
    for (const char* command : {"analyze", "trace"}) {
      SCOPED_TRACE(command);
      const Finished finished = Gyrobench({command, table});
      EXPECT_EQ(finished.status, 1);
      EXPECT_THAT(finished.err, cause);
    }
  }
  TemporaryFolder folder_;
};

constexpr const char* kCounts = "# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb,ref_angle_z_deg";

double Unsigned16(double count) { return count < 0.0 ? count + 65536.0 : count; }

TEST_F(WrongTable, CountsOfASignedWordWrittenUnsignedAreNamedByEveryCommand) {
  const std::string table = Write(Table(kCounts, [](const Moment& now) {
    return Row{Unsigned16(now.gyro_lsb()), now.angle_deg};
  }));
  const auto cause =
      AllOf(HasSubstr("wrong.csv: the gyro's counts are those of a signed 16-bit word that was "
                      "written as an unsigned one"),
            HasSubstr("Take 65536 off every count above 32767"), Not(HasSubstr("mounting")));
  ExpectCause(table, cause);
  const auto calibration = folder_.Write("cal.json", ToJson(GyroZ()).dump());
  const Finished apply = Gyrobench({"apply", calibration, table, "-o", folder_ / "out.csv"});
  EXPECT_EQ(apply.status, 1);
  EXPECT_THAT(apply.err, cause);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.csv"));
  // Poses held by hand.
  const std::string held = folder_.Write(
      "wrong.csv",
      Table("# gyro_lsb_per_deg_s = 131\nt_s,gyro_x_lsb,gyro_y_lsb,gyro_z_lsb,accel_x_g,accel_y_g,"
            "accel_z_g",
            [](const Moment& now) {
              const double count = Unsigned16(now.gyro_lsb());
              return Row{count, count, count, 0.0, 0.0, 1.0};
            }));
  const Finished hold = Gyrobench({"hold", held});
  EXPECT_EQ(hold.status, 1);
  EXPECT_THAT(hold.err, cause);
}

// Its zero is in the middle of its range.
TEST_F(WrongTable, CountsOfAConverterThatIsUnsignedItselfAreNot) {
  Turning fast;
  fast.rates_deg_s = {60.0, -60.0, 100.0, -100.0};
  const std::string table = Write(Table(
      kCounts,
      [](const Moment& now) {
        return Row{now.gyro_lsb() + 32768.0, now.angle_deg};
      },
      fast));
  const Finished analyze = Gyrobench({"analyze", table});
  EXPECT_EQ(analyze.status, 0) << analyze.err;
  EXPECT_THAT(analyze.out, HasSubstr("unsigned converter"));
}

}  // namespace
}  // namespace gyrobench::cli
