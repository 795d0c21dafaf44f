#include "commission/probe.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "base/error.h"
#include "tests/commission/plain_stand.h"

namespace gyrobench::commission {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Probe, EveryTableEndsWhereItBeganAndNoneGoesFarther) {
  for (const double scale : {1.0, 0.1, 0.5, 2.0, 8.0, 19.0}) {
    Wired wired;
    wired.turned_per_commanded = {scale, -1.0, 1.0};
    PlainStand stand(wired);
    const Measurements measured = Probe(PlainAxes(), stand);
    EXPECT_LE(stand.farthest_deg(), kFarthest_deg) << scale;
    Vector3 sum = {};
    for (const Move& move : measured.moves) sum[move.drive] += move.commanded_deg;
    for (const double left_deg : sum) EXPECT_EQ(left_deg, 0.0);
    EXPECT_LE(ToSeconds(stand.Now() - 1'000'000'000), kProbe_s);
    EXPECT_TRUE(std::ranges::is_sorted(stand.progress()));
    EXPECT_LT(stand.progress().back(), 1.0);
  }
}

// A worm with play takes small moves for itself: what comes after it must not go far.
TEST(Probe, PlayMakesNoTableGoFarther) {
  for (const double play_deg : {0.3, 0.6, 1.0, 1.5, 3.0}) {
    Wired wired;
    wired.play_deg = play_deg;
    PlainStand stand(wired);
    try {
      Probe(PlainAxes(), stand);
    } catch (const DataError&) {  // it may give up
    }
    EXPECT_LE(stand.farthest_deg(), kFarthest_deg) << play_deg;
  }
}

TEST(Probe, AShaftThatSlipsOnceTakesNoTableFarther) {
  Wired wired;
  PlainStand stand(wired);
  int moves = 0;
  stand.on_move = [&] { stand.slip = ++moves == 3 ? 0.7 : 0.0; };
  EXPECT_NO_THROW(Probe(PlainAxes(), stand));
  EXPECT_LE(stand.farthest_deg(), kFarthest_deg);
}

// By the gyro, whose offset is not counted.
TEST(Probe, MeasuresTheAngleThatATableTurns) {
  Wired wired;
  wired.turned_per_commanded = {1.0, 0.25, 1.0};
  PlainStand stand(wired);
  for (const Move& move : Probe(PlainAxes(), stand).moves) {
    const double scale = wired.turned_per_commanded[move.drive];
    EXPECT_NEAR(Length(move.turned_deg), scale * std::abs(move.commanded_deg), 1e-3);
  }
}

TEST(Probe, ADriveThatTurnsNothingIsNamed) {
  Wired wired;
  wired.turned_per_commanded[1] = 0.0;
  PlainStand stand(wired);
  EXPECT_THAT([&] { Probe(PlainAxes(), stand); },
              ThrowsMessage<DataError>(HasSubstr("axis.middle: its drive was told")));
}

TEST(Probe, NothingMovesWhereTheLimitsLeaveNoRoom) {
  std::vector<config::AxisConfig> axes = PlainAxes();
  axes[2].max_deg = 5.0;
  PlainStand stand(Wired{});
  stand.on_move = [] { FAIL() << "it moved"; };
  EXPECT_THAT([&] { Probe(axes, stand); },
              ThrowsMessage<LimitError>(HasSubstr("axis.inner: its soft limits, -3600 .. 5 deg")));
}

}  // namespace
}  // namespace gyrobench::commission
