#include "commission/wiring.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <map>
#include <numeric>
#include <string>

#include "base/error.h"
#include "commission/probe.h"
#include "tests/commission/plain_stand.h"

namespace gyrobench::commission {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

config::StandConfig Stand() {
  config::StandConfig stand;
  stand.axes = PlainAxes();
  return stand;
}

Wiring Found(const config::StandConfig& stand, const Wired& wired) {
  PlainStand devices(wired);
  return FindWiring(stand, Probe(stand.axes, devices));
}

std::vector<std::string> Names(const Wiring& wiring) {
  std::vector<std::string> names;
  for (const Finding& finding : wiring.findings) names.push_back(finding.what);
  return names;
}

std::map<std::string, std::string> Lines(const Wiring& wiring) {
  std::map<std::string, std::string> lines;
  for (const Finding& finding : wiring.findings) {
    for (const Correction& line : finding.corrections) lines[line.key] = line.value;
  }
  return lines;
}

TEST(Wiring, OfAStandThatIsAsItsFileSaysNothingIsFound) {
  EXPECT_THAT(Names(Found(Stand(), {})), IsEmpty());
}

// All orders, of drives and of encoders.
TEST(Wiring, ExchangedDrivesAndEncodersGetTheUnitsOfWhatTheyAreOn) {
  std::vector<std::size_t> order(3);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::vector<std::string> names = {"outer", "middle", "inner"};
  while (std::ranges::next_permutation(order).found) {
    for (const bool drives : {true, false}) {
      Wired wired;
      (drives ? wired.drive_axis : wired.encoder_axis) = order;
      const Wiring found = Found(Stand(), wired);
      EXPECT_THAT(Names(found), ElementsAre(drives ? "exchanged drives" : "exchanged encoders"));
      const auto lines = Lines(found);
      for (std::size_t i = 0; i < 3; ++i) {
        if (order[i] == i) continue;
        const std::string device = drives ? "drive" : "encoder";
        EXPECT_EQ(lines.at("axis." + names[order[i]] + "." + device + ".unit"),
                  std::to_string((drives ? 1 : 11) + static_cast<int>(i)));
      }
    }
  }
}

TEST(Wiring, OneThatIsReversedIsTheDriveWhereTheGyroSaysSoAndElseTheEncoder) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Wired drive, encoder;
    drive.turned_per_commanded[axis] = -1.0;
    encoder.counts_per_deg[axis] *= -1.0;
    EXPECT_THAT(Names(Found(Stand(), drive)), ElementsAre("reversed drive"));
    EXPECT_THAT(Names(Found(Stand(), encoder)), ElementsAre("reversed encoder"));
  }
}

// Every way in which a sensor can sit square on its table.
TEST(Wiring, TheMountingIsFoundWhateverItIs) {
  const std::vector<double> quarters = {0.0, 90.0, 180.0, 270.0};
  for (const double x : quarters) {
    for (const double y : {0.0, 90.0}) {
      for (const double z : quarters) {
        const auto turned = [](double deg, const Eigen::Vector3d& axis) {
          return Eigen::AngleAxisd(deg * kRadPerDeg, axis);
        };
        Wired wired;
        wired.mount = (turned(z, Eigen::Vector3d::UnitZ()) * turned(y, Eigen::Vector3d::UnitY()) *
                       turned(x, Eigen::Vector3d::UnitX()))
                          .toRotationMatrix();
        const Wiring found = Found(Stand(), wired);
        if (wired.mount.isIdentity(1e-9)) continue;
        ASSERT_THAT(Names(found), ElementsAre("mounting")) << x << ' ' << y << ' ' << z;
        // A stand file with these lines is right.
        config::StandConfig corrected = Stand();
        for (auto& [name, value_deg, limit_deg] : AnglesOf(corrected.geometry)) {
          const auto lines = Lines(found);
          const auto line = lines.find(std::string("geometry.") + name);
          if (line != lines.end()) *value_deg = std::stod(line->second);
        }
        EXPECT_THAT(Names(Found(corrected, wired)), IsEmpty()) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(Wiring, ScalesAreToldApartByTheGyro) {
  Wired wired;
  wired.turned_per_commanded[0] = 2.0;
  wired.counts_per_deg[1] /= 16.0;
  wired.pulses_per_turn[2] = 5000;
  const auto lines = Lines(Found(Stand(), wired));
  EXPECT_THAT(lines, ElementsAre(Pair("axis.inner.drive.pulses_per_turn", "5000"),
                                 Pair("axis.middle.encoder.counts_per_turn", "8192"),
                                 Pair("axis.middle.encoder.range_counts", "33554432"),
                                 Pair("axis.outer.gear_ratio", "20")));
}

TEST(Wiring, WordsInTheOtherOrderAreSeenInEachEncoder) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Wired wired;
    wired.low_word_first[axis] = true;
    const Wiring found = Found(Stand(), wired);
    ASSERT_THAT(Names(found), ElementsAre("word order"));
    EXPECT_EQ(found.findings[0].corrections.at(0).value, "\"low_first\"");
  }
}

// Whichever way its counts go.
TEST(Wiring, PlayIsNoOtherNumberOfCounts) {
  for (const double sense : {1.0, -1.0}) {
    Wired wired;
    wired.play_deg = 0.5;
    wired.turned_per_commanded[0] = wired.turned_per_commanded[1] = sense;
    wired.counts_per_deg[2] *= sense;
    const std::vector<std::string> names = Names(Found(Stand(), wired));
    EXPECT_THAT(names, testing::Not(testing::Contains("counts per turn"))) << sense;
    EXPECT_THAT(names, testing::Contains("play"));
  }
}

// 12 bits a turn: a count is 0.09 deg, of moves of 4.5 deg.
TEST(Wiring, ACoarseEncoderIsNotTakenForOneThatSlips) {
  config::StandConfig stand = Stand();
  Wired wired;
  for (std::size_t i = 0; i < 3; ++i) {
    stand.axes[i].encoder.map.counts_per_turn = 4096;
    stand.axes[i].encoder.map.range_counts = 65536;
    stand.axes[i].encoder.map.words = 1;
    wired.counts_per_deg[i] = 4096.0 / 360.0;
    wired.low_word_first[i] = true;  // one register: the low word
  }
  EXPECT_THAT(Names(Found(stand, wired)), IsEmpty());
  wired.counts_per_deg[1] *= -1.0;
  wired.turned_per_commanded[2] = 0.5;
  EXPECT_THAT(Names(Found(stand, wired)), ElementsAre("reversed encoder", "gear ratio"));
}

// The gyro's scale is known to 3 %: what differs from it by less is no other count.
TEST(Wiring, AGyroThatIsAFewPercentOffMakesNoFinding) {
  const config::StandConfig stand = Stand();
  for (const double of_gyro : {0.97, 1.03}) {
    PlainStand devices({});
    Measurements measured = Probe(stand.axes, devices);
    for (Move& move : measured.moves) {
      for (double& turned_deg : move.turned_deg) turned_deg *= of_gyro;
    }
    EXPECT_THAT(Names(FindWiring(stand, measured)), IsEmpty()) << of_gyro;
  }
}

TEST(Wiring, WhatNoLineMendsIsSaidWithWhatToDo) {
  Wired play, loose;
  play.play_deg = 0.4;
  loose.loose = 0.2;
  const Wiring of_play = Found(Stand(), play), of_loose = Found(Stand(), loose);
  EXPECT_THAT(Names(of_play), ElementsAre("play", "play", "play"));
  EXPECT_THAT(of_play.findings[0].reason, HasSubstr("a play of 0.40 deg"));
  EXPECT_THAT(Names(of_loose), ElementsAre("slipping encoder"));
  EXPECT_THAT(of_loose.findings[0].reason, HasSubstr("tighten its coupling"));
  EXPECT_THAT(Lines(of_play), IsEmpty());
  EXPECT_THAT(Lines(of_loose), IsEmpty());
}

TEST(Wiring, TheDelayOfAllEncodersIsOneLineOfEach) {
  Wired wired;
  wired.delay_s = 0.02;
  const auto lines = Lines(Found(Stand(), wired));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_NEAR(std::stod(lines.at("axis.outer.encoder.delay_s")), 0.02, 2e-3);
}

// Gravity tells a sensor that lies on its back from axes that turn the other way.
TEST(Wiring, ReversedAxesAreNoMountingThatGravityContradicts) {
  Wired wired;
  for (const std::size_t axis : {std::size_t{0}, std::size_t{2}}) {
    wired.turned_per_commanded[axis] = -1.0;
    wired.counts_per_deg[axis] *= -1.0;
  }
  const Wiring found = Found(Stand(), wired);
  EXPECT_THAT(
      Lines(found),
      ElementsAre(Pair("axis.inner.drive.sign", "-1"), Pair("axis.inner.encoder.sign", "-1"),
                  Pair("axis.outer.drive.sign", "-1"), Pair("axis.outer.encoder.sign", "-1")));
}

// A middle axis that turns the other way is one that does not under a sensor half a turn off.
TEST(Wiring, WhatExplainsTheSameIsSaidAsWell) {
  config::StandConfig stand = Stand();
  stand.geometry.mount_deg = {0.0, 0.0, 90.0};
  Wired wired;
  wired.turned_per_commanded[1] = -1.0;
  const Wiring found = Found(stand, wired);
  ASSERT_EQ(found.findings.size(), 2u);
  EXPECT_THAT(found.findings.back().reason, HasSubstr("As likely, by all that was felt: "));
}

TEST(Wiring, AStandOnItsSideIsJudgedWithoutGravity) {
  PlainStand devices({});
  const config::StandConfig stand = Stand();
  Measurements measured = Probe(stand.axes, devices);
  measured.specific_force_g = {1.0, 0.0, 0.0};
  EXPECT_THAT(Names(FindWiring(stand, measured)), IsEmpty());
}

TEST(Wiring, ARatioThatIsNoWholeNumberIsWrittenAsItIs) {
  for (const double ratio : {50.5, 36.75, 26.85}) {
    Wired wired;
    wired.turned_per_commanded[0] = 40.0 / ratio;
    const auto lines = Lines(Found(Stand(), wired));
    EXPECT_NEAR(std::stod(lines.at("axis.outer.gear_ratio")), ratio, 1e-3 * ratio);
  }
}

// Encoder and drive differ by less than the gyro's scale is known to.
TEST(Wiring, WhatTheGyroCannotTellApartGetsNoLine) {
  Wired ratio, counts;
  ratio.turned_per_commanded[0] = 1.04;
  counts.counts_per_deg[0] *= 1.04;
  for (const Wired& wired : {ratio, counts}) {
    const Wiring found = Found(Stand(), wired);
    EXPECT_THAT(Names(found), ElementsAre("gear ratio or counts per turn"));
    EXPECT_THAT(Lines(found), IsEmpty());
  }
}

TEST(Wiring, AnOffsetIsThatOfTheCorrectedEncoder) {
  Wired wired;
  wired.counts_at_mark = {0, 32768, 0};  // a quarter of a turn
  wired.counts_per_deg[1] *= -1.0;
  const auto lines = Lines(Found(Stand(), wired));
  EXPECT_EQ(lines.at("axis.middle.encoder.sign"), "-1");
  EXPECT_EQ(std::stod(lines.at("axis.middle.encoder.offset_deg")), 90.0);
  config::StandConfig corrected = Stand();
  corrected.axes[1].encoder.sign = -1;
  corrected.axes[1].encoder.offset_deg = 90.0;
  EXPECT_THAT(Names(Found(corrected, wired)), IsEmpty());
}

// Its value goes to and fro by a count, which in the other order of its words is many degrees.
TEST(Wiring, AnEncoderThatFlickersStandsStill) {
  Wired wired;
  wired.counts_per_deg[2] = 0.0;
  wired.flickers = true;
  const Wiring found = Found(Stand(), wired);
  EXPECT_THAT(Names(found), ElementsAre("encoder that stands still"));
  EXPECT_THAT(Lines(found), IsEmpty());
}

// Two drives that are reversed look, to the gyro, like a mounting that is half a turn off: the
// encoders tell which it is.
TEST(Wiring, TheSimplerOfTwoExplanationsIsGiven) {
  Wired reversed;
  reversed.turned_per_commanded = {-1.0, -1.0, 1.0};
  EXPECT_THAT(Names(Found(Stand(), reversed)), ElementsAre("reversed drive"));
  Wired turned;
  turned.mount = Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_THAT(Names(Found(Stand(), turned)), ElementsAre("mounting"));
}

// A stand with one axis: what cannot be told is not invented.
TEST(Wiring, OfOneAxisTheSenseIsToldByDriveAndEncoder) {
  config::StandConfig stand = Stand();
  stand.axes.erase(stand.axes.begin(), stand.axes.begin() + 2);
  Wired wired{.drive_axis = {2}, .encoder_axis = {2}};
  EXPECT_THAT(Names(Found(stand, wired)), IsEmpty());
  wired.counts_per_deg[0] *= -1.0;
  EXPECT_THAT(Names(Found(stand, wired)), ElementsAre("reversed encoder"));
  // A turn about the one axis is felt by nobody.
  Wired upside_down{.drive_axis = {2}, .encoder_axis = {2}};
  upside_down.mount = (Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitX()) *
                       Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))
                          .toRotationMatrix();
  EXPECT_THAT(Lines(Found(stand, upside_down)), ElementsAre(Pair("geometry.mount_x_deg", "180")));
}

}  // namespace
}  // namespace gyrobench::commission
