// A user's own table that is wrong in a common way: every command that reads it names the cause.
// The tables are of simple turns, summed up here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <tuple>

#include "tests/cli/child_process.h"
#include "tests/cli/gyro_z.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
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

// A turntable that goes on and on, its angle from -180 or 0, read `hz` times a second.
std::string WrappedAt(const char* head, double from_deg, double hz, double fastest_deg_s) {
  Turning on_and_on;
  on_and_on.period_s = 20.0;
  on_and_on.rates_deg_s = {fastest_deg_s / 3.0, fastest_deg_s / 1.5, fastest_deg_s};
  const int every = static_cast<int>(std::lround(1.0 / (hz * kStep_s)));
  return Table(
      head,
      [=](const Moment& now) {
        const double turns = std::floor((now.angle_deg - from_deg) / 360.0);
        return Row{now.gyro_lsb(), now.index % every == 0 ? now.angle_deg - 360.0 * turns : kNone};
      },
      on_and_on);
}

// The gyro says by how many turns the table went on between two readings.
TEST_F(WrongTable, AWrappedReferenceThatIsReadSeldomRunsOnAsTheGyroTurned) {
  for (const auto& [from_deg, hz, fastest_deg_s] :
       {std::tuple(-180.0, 2.0, 18.0), std::tuple(0.0, 2.0, 18.0), std::tuple(0.0, 2.0, 90.0),
        std::tuple(-180.0, 1.0, 150.0), std::tuple(-180.0, 4.0, 90.0)}) {
    SCOPED_TRACE(fastest_deg_s);
    const std::string table = Write(WrappedAt(kCounts, from_deg, hz, fastest_deg_s));
    const Finished analyze = Gyrobench({"analyze", table, "--json"});
    EXPECT_EQ(analyze.status, 0) << analyze.err;
    const json result = json::parse(analyze.out);
    ASSERT_EQ(result.at("scale").size(), 1U);
    EXPECT_NEAR(result.at("scale").at(0).at("scale_error").get<double>(), 1.0 / 1.01 - 1.0, 1e-3);
    EXPECT_THAT(result.at("remarks").dump(),
                HasSubstr("whole turns were added, as the gyro turned, so that it runs on"));
    EXPECT_EQ(Gyrobench({"trace", table}).status, 0);
  }
}

// By less than half a turn to the other side as well as by more to the right one.
TEST_F(WrongTable, AWrappedReferenceWhoseTurnsNothingTellsIsNamedAsThat) {
  const std::string table = Write(WrappedAt("t_s,gyro_z_lsb,ref_angle_z_deg", -180.0, 1.0, 500.0));
  ExpectCause(table, AllOf(HasSubstr("never leaves one turn"), HasSubstr("wrapped at 180 or 360"),
                           HasSubstr("Let the column run on"), Not(HasSubstr("mount"))));
}

// The reference turns by far more than the gyro says, and not even that is constant.
TEST_F(WrongTable, ATraceThatCannotBeSaysSoAtItsHeadInJsonAndInTheReport) {
  const std::string table = Write(Table("t_s,gyro_z_deg_s,ref_angle_z_deg", [](const Moment& now) {
    return Row{-0.017 * now.gyro_deg_s(), now.angle_deg};
  }));
  const auto says = HasSubstr("this result cannot be: the scale error of gyro z is -59");
  const Finished text = Gyrobench({"trace", table, "--report", folder_ / "report.html"});
  EXPECT_EQ(text.status, 1);
  EXPECT_THAT(
      Flat(text.out),
      testing::StartsWith("Gyro z: this result cannot be: the scale error of gyro z is -59"));
  EXPECT_THAT(Flat(text.out),
              AllOf(HasSubstr("Most likely the unit"), Not(HasSubstr("nothing beyond"))));
  EXPECT_THAT(text.err, says);
  const json trace = json::parse(Gyrobench({"trace", table, "--json"}).out);
  EXPECT_EQ(trace.at("channels").at(0).at("verdict"), "cannot_be");
  EXPECT_THAT(trace.at("channels").at(0).at("summary").get<std::string>(),
              HasSubstr("This result cannot be: the scale error of gyro z is -59"));
  std::ifstream in(folder_ / "report.html");
  const std::string page(std::istreambuf_iterator<char>(in), {});
  EXPECT_THAT(page, AllOf(HasSubstr("Cannot be"), HasSubstr("This result cannot be: the scale"),
                          Not(HasSubstr("Nothing beyond the baseline"))));
}

TEST_F(WrongTable, AReferenceInRadiansIsNamedByEveryCommand) {
  for (const char* head : {kCounts, "t_s,gyro_z_deg_s,ref_angle_z_deg"}) {
    const bool counts = head == kCounts;
    const std::string table = Write(Table(head, [&](const Moment& now) {
      return Row{counts ? now.gyro_lsb() : now.gyro_deg_s(), now.angle_deg / 57.29578};
    }));
    ExpectCause(table, AllOf(HasSubstr("Most likely the unit of the reference"),
                             HasSubstr("are in radians. Multiply them by 57.29578")));
  }
}

TEST_F(WrongTable, AThousandthOfTheUnitIsNamedWithTheColumn) {
  const auto turns = [&](const char* head, double factor) {
    return Write(Table(head, [=](const Moment& now) {
      return Row{factor * now.gyro_deg_s(), now.angle_deg};
    }));
  };
  ExpectCause(turns("t_s,gyro_z_deg_s,ref_angle_z_deg", 1000.0),
              HasSubstr("the values of gyro_z_deg_s are in mdeg/s. Divide them by 1000"));
  ExpectCause(turns("t_s,gyro_z_rad_s,ref_angle_z_deg", 1000.0 / 57.29578),
              HasSubstr("the values of gyro_z_rad_s are in mrad/s. Divide them by 1000"));
  ExpectCause(
      turns("t_s,gyro_z_rad_s,ref_angle_z_deg", 1000.0),
      AllOf(HasSubstr("gyro_z_rad_s are in mdeg/s"), HasSubstr("Name the column gyro_z_deg_s")));
  Turning slow;  // below what no reference of a table turns by
  slow.rates_deg_s = {1.0, -2.0, 3.0, -1.0, 2.0, -3.0};
  const std::string reference = Write(Table(
      "t_s,gyro_z_deg_s,ref_angle_z_deg",
      [](const Moment& now) {
        return Row{now.gyro_deg_s(), 1000.0 * now.angle_deg};
      },
      slow));
  ExpectCause(reference, HasSubstr("in thousandths of a degree"));
}

TEST_F(WrongTable, AnAccelerometerInAnotherUnitIsRemarkedOn) {
  constexpr const char* kInG = "t_s,gyro_z_deg_s,ref_angle_z_deg,accel_x_g,accel_y_g,accel_z_g";
  constexpr const char* kInMetres =
      "t_s,gyro_z_deg_s,ref_angle_z_deg,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2";
  for (const auto& [head, factor, says] :
       {std::tuple(kInG, 1000.0, "in mg, and not in g"),
        std::tuple(kInG, 9.80665, "name them accel_x_m_s2"),
        std::tuple(kInMetres, 1.0, "name them accel_x_g"), std::tuple(kInG, 1.0, "")}) {
    SCOPED_TRACE(says);
    const std::string table = Write(Table(head, [&, f = factor](const Moment& now) {
      return Row{now.gyro_deg_s(), now.angle_deg, 0.02 * f * now.noise, 0.3 * f, 0.954 * f};
    }));
    for (const char* command : {"analyze", "trace"}) {
      const std::string text = Flat(Gyrobench({command, table}).out);
      if (*says != '\0') {
        EXPECT_THAT(text, AllOf(HasSubstr("the accelerometer shows"), HasSubstr(says))) << command;
      } else {
        EXPECT_THAT(text, Not(HasSubstr("the accelerometer shows"))) << command;
      }
    }
  }
}

using Quaternion = std::array<double, 4>;  // w, x, y, z

Quaternion Product(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

// Turns about x, y and z one after the other; the quaternion rotates sensor vectors into the world.
std::string Orientations(const std::function<Quaternion(const Quaternion&)>& written) {
  Quaternion q = {1.0, 0.0, 0.0, 0.0};
  return Table("t_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,ref_qw,ref_qx,ref_qy,ref_qz",
               [=](const Moment& now) mutable {
                 const auto axis = static_cast<std::size_t>(now.t_s / 5.0 + 1e-9) % 3;
                 Row row = {0.1, 0.2, 0.3};
                 for (double& rate : row) rate += 0.01 * now.noise;
                 row[axis] += 1.01 * now.rate_deg_s;
                 // Half of the step before the reading, half of it after.
                 Quaternion half = {1.0, 0.0, 0.0, 0.0};
                 const double angle = 0.5 * now.rate_deg_s * kStep_s / 57.29578;
                 half[0] = std::cos(0.5 * angle);
                 half[1 + axis] = std::sin(0.5 * angle);
                 q = Product(q, half);
                 const Quaternion now_written = written(q);
                 q = Product(q, half);
                 row.insert(row.end(), now_written.begin(), now_written.end());
                 return row;
               });
}

TEST_F(WrongTable, TheConventionOfAQuaternionThatMakesItAgreeIsNamed) {
  const auto expect = [&](const std::function<Quaternion(const Quaternion&)>& written,
                          const testing::Matcher<const std::string&>& cause) {
    ExpectCause(Write(Orientations(written)), cause);
  };
  const auto none = Not(testing::AnyOf(HasSubstr("hardly feels"), HasSubstr("stand for each other"),
                                       HasSubstr("reference stands")));
  expect(
      [](const Quaternion& q) {
        return Quaternion{q[0], -q[1], -q[2], -q[3]};
      },
      AllOf(HasSubstr("Most likely the quaternion of the reference is the inverse one"),
            HasSubstr("Change the sign of ref_qx, ref_qy and ref_qz"), none));
  expect(
      [](const Quaternion& q) {
        return Quaternion{q[1], q[2], q[3], q[0]};
      },
      AllOf(HasSubstr("Most likely the quaternion of the reference is in the order x, y, z, w"),
            Not(HasSubstr("inverse")), none));
  expect(
      [](const Quaternion& q) {
        return Quaternion{q[3], q[0], q[1], q[2]};
      },
      AllOf(HasSubstr("in the order w, x, y, z, under columns that are named x, y, z, w"),
            Not(HasSubstr("inverse")), none));
  expect(
      [](const Quaternion& q) {
        return Quaternion{-q[1], -q[2], -q[3], q[0]};
      },
      AllOf(HasSubstr("in the order x, y, z, w, and the inverse one"), none));
  const std::string right = Write(Orientations([](const Quaternion& q) { return q; }));
  EXPECT_EQ(Gyrobench({"analyze", right}).status, 0);
}

TEST_F(WrongTable, AGyroThatTurnsWithoutAReferenceIsNotTakenToBeAtRest) {
  ExpectCause(
      Write(Table("t_s,gyro_z_deg_s", [](const Moment& now) { return Row{now.gyro_deg_s()}; })),
      AllOf(HasSubstr("there is no reference, and gyro z turns"), HasSubstr("first from 2."),
            HasSubstr("without a reference only a sensor at rest can be analysed")));
  ExpectCause(Write(Table("# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb",
                          [](const Moment& now) { return Row{131.0 * 200.0 + now.noise}; })),
              AllOf(HasSubstr("gyro z stands at 200 deg/s"), HasSubstr("gyro_lsb_zero")));
  // A sensor at rest whose offset is negative, as an unsigned word has it.
  ExpectCause(Write(Table("# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb",
                          [](const Moment& now) {
                            return Row{std::round(65536.0 - 262.0 + 3.0 * now.noise)};
                          })),
              HasSubstr("signed 16-bit word that was written as an unsigned one"));
}

// An offset that warms up by 10 deg/s and jumps by 0.5, as parts do.
TEST_F(WrongTable, AnOffsetThatMovesAsPartsDoIsAtRest) {
  const std::string table = Write(Table("t_s,gyro_z_deg_s", [](const Moment& now) {
    return Row{25.0 + 10.0 * now.t_s / 240.0 + (now.t_s > 100.0 ? 0.5 : 0.0) + 0.1 * now.noise};
  }));
  const Finished analyze = Gyrobench({"analyze", table});
  EXPECT_EQ(analyze.status, 0) << analyze.err;
}

TEST_F(WrongTable, DecimalCommasAreNamedWithTheLineThatHasThem) {
  std::string commas = "# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb,ref_angle_z_deg\n",
              quoted = commas;
  for (int i = 0; i < 500; ++i) {
    commas += "0," + std::to_string(1000 + i) + ",-393,5,12,25\n";
    quoted += "\"0," + std::to_string(1000 + i) + "\",\"-393,5\",\"12,25\"\n";
  }
  const auto says = AllOf(HasSubstr("wrong.csv:3: found '"), HasSubstr("has 6 fields"),
                          HasSubstr("the header has 3 columns"), HasSubstr("decimal commas"),
                          HasSubstr("Accepted are numbers with a point"));
  for (const std::string& text : {commas, quoted}) {
    const std::string table = Write(text);
    ExpectCause(table, says);
    const auto calibration = folder_.Write("cal.json", ToJson(GyroZ()).dump());
    const Finished apply = Gyrobench({"apply", calibration, table, "-o", folder_ / "out.csv"});
    EXPECT_EQ(apply.status, 1);
    EXPECT_THAT(apply.err, says);
  }
}

}  // namespace
}  // namespace gyrobench::cli
