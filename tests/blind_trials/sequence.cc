#include "tests/blind_trials/sequence.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobench::blind_trials {
namespace {

constexpr std::size_t kOuter = 0, kMiddle = 1, kInner = 2;
constexpr double kRest_s = 2.0;
constexpr double kAcceleration_deg_s2 = 80.0;
constexpr double kPoseRate_deg_s = 40.0;
// A drive begins at a whole microsecond, and not before it has ended.
constexpr double kSlack_s = 2e-6;

struct Leg {
  double rate_deg_s = 0.0, angle_deg = 0.0;
};
const std::vector<Leg> kLegs = {{2.5, 36}, {5, 72},   {8, 90},   {12, 135},
                                {18, 180}, {25, 270}, {32, 360}, {40, 360}};

class Planner {
 public:
  explicit Planner(std::mt19937_64& random) : random_(random) {}

  void Rest(double duration_s) { Pass(duration_s, "rest"); }

  void TurnTo(std::size_t axis, double target_deg, double rate_deg_s,
              double acceleration_deg_s2 = kAcceleration_deg_s2) {
    plan_.turns.push_back({now_s_, axis, target_deg, rate_deg_s, acceleration_deg_s2});
    const double way_deg = std::abs(target_deg - angle_deg_[axis]);
    const double ramp_s = rate_deg_s / acceleration_deg_s2;
    const double turn_s = way_deg >= rate_deg_s * ramp_s
                              ? way_deg / rate_deg_s + ramp_s
                              : 2.0 * std::sqrt(way_deg / acceleration_deg_s2);
    angle_deg_[axis] = target_deg;
    Pass(std::ceil((turn_s + kSlack_s) * 1e6) * 1e-6, "turn");
  }
  void Turn(std::size_t axis, double angle_deg, double rate_deg_s) {
    TurnTo(axis, angle_deg_[axis] + angle_deg, rate_deg_s);
    Rest(kRest_s);
  }
  void Pose(double middle_deg, double inner_deg) {
    if (angle_deg_[kMiddle] != middle_deg)
      Turn(kMiddle, middle_deg - angle_deg_[kMiddle], kPoseRate_deg_s);
    if (angle_deg_[kInner] != inner_deg)
      Turn(kInner, inner_deg - angle_deg_[kInner], kPoseRate_deg_s);
  }
  // Each leg there and back, or back and there.
  void Legs(std::size_t axis, std::vector<Leg> legs) {
    std::shuffle(legs.begin(), legs.end(), random_);
    for (const Leg& leg : legs) {
      const double sign = random_() % 2 == 0 ? 1.0 : -1.0;
      Turn(axis, sign * leg.angle_deg, leg.rate_deg_s);
      Turn(axis, -sign * leg.angle_deg, leg.rate_deg_s);
    }
  }
  // Each leg one way, and the next back.
  void LegsOneWay(std::size_t axis, const std::vector<Leg>& legs) {
    double sign = random_() % 2 == 0 ? 1.0 : -1.0;
    for (const Leg& leg : legs) {
      Turn(axis, sign * leg.angle_deg, leg.rate_deg_s);
      sign = -sign;
    }
  }
  // Near to a sine: ramps of a third of the half period each.
  void Swing(std::size_t axis, double amplitude_deg, double frequency_hz, double duration_s) {
    const double half_s = 0.5 / frequency_hz;
    const double rate = 3.0 * amplitude_deg / half_s;
    const double acceleration = 9.0 * amplitude_deg / (half_s * half_s);
    const double middle_deg = angle_deg_[axis];
    const int midpoints = static_cast<int>(std::lround(duration_s / half_s)) - 1;
    double side = 1.0;
    for (int i = 0; i < midpoints; ++i, side = -side) {
      TurnTo(axis, middle_deg + side * amplitude_deg, rate, acceleration);
    }
    TurnTo(axis, middle_deg, rate, acceleration);
    Rest(kRest_s);
  }
  void FanOn() { plan_.fans.push_back({.at_s = now_s_}); }
  void FanOff() { plan_.fans.back().duration_s = now_s_ - plan_.fans.back().at_s; }
  void FillUpTo(double end_s) {
    if (now_s_ < end_s) Rest(end_s - now_s_);
  }
  double now_s() const { return now_s_; }

  Sequence Take() {
    plan_.duration_s = now_s_;
    return std::move(plan_);
  }

 private:
  void Pass(double duration_s, const char* kind) {
    plan_.segments.push_back({now_s_, now_s_ + duration_s, kind, kind});
    now_s_ += duration_s;
  }

  std::mt19937_64& random_;
  Sequence plan_;
  double now_s_ = 0.0;
  std::array<double, 3> angle_deg_ = {};
};

std::vector<Leg> LegsAt(std::initializer_list<double> rates_deg_s) {
  std::vector<Leg> legs;
  for (const Leg& leg : kLegs) {
    if (std::find(rates_deg_s.begin(), rates_deg_s.end(), leg.rate_deg_s) != rates_deg_s.end())
      legs.push_back(leg);
  }
  return legs;
}

void PlanThermalHistory(Planner& plan) {
  plan.Pose(0, 0);
  plan.FanOn();
  plan.Rest(60);
  plan.LegsOneWay(kInner, LegsAt({18, 32}));
  plan.Rest(60);
  plan.FanOff();
  plan.Rest(60);
  plan.LegsOneWay(kInner, LegsAt({12, 40}));
  plan.Rest(120);
}

void PlanFull(Planner& plan) {
  const double end_s = plan.now_s() + 2262.0;
  plan.Rest(900);
  for (const double middle_deg : {0.0, 90.0, 180.0}) {
    plan.Pose(middle_deg, 0);
    plan.Legs(kInner, kLegs);
  }
  for (const double inner_deg : {90.0, 0.0}) {
    plan.Pose(90, inner_deg);
    plan.Legs(kOuter, LegsAt({12, 25, 40}));
  }
  plan.Legs(kMiddle, LegsAt({8, 18, 32}));
  PlanThermalHistory(plan);
  plan.Pose(90, 0);
  plan.Swing(kInner, 10, 0.2, 15);
  for (const double frequency_hz : {0.4, 0.6, 0.8}) plan.Swing(kInner, 5, frequency_hz, 15);
  plan.Pose(0, 0);
  plan.FillUpTo(end_s);
}

void PoseAndRest(Planner& plan, double middle_deg, double inner_deg) {
  plan.Pose(middle_deg, inner_deg);
  plan.Rest(20);
}

void PlanElsewhere(Planner& plan) {
  plan.Rest(120);
  for (const auto& [middle_deg, inner_deg] :
       {std::pair{0.0, 0.0}, {35.0, 20.0}, {70.0, -50.0}, {115.0, 130.0}, {150.0, 65.0}}) {
    plan.Pose(middle_deg, inner_deg);
    plan.Legs(kInner, {{3.7, 40}, {15, 110}, {29, 200}});
    plan.Legs(kOuter, {{10, 90}, {22, 150}, {38, 300}});
    plan.Legs(kMiddle, {{7, 25}, {20, 30}});
  }
  plan.Rest(60);
}

void PlanPoor(SequenceKind kind, Planner& plan) {
  plan.Rest(300);
  for (int i = 0; i < 12; ++i) {
    switch (kind) {
      case SequenceKind::kOneWay:
        plan.Turn(kInner, 360, 20);
        break;
      case SequenceKind::kBothWays:
        plan.Legs(kInner, {{20, 360}});
        break;
      case SequenceKind::kThreeSpeeds:
        plan.Legs(kInner, LegsAt({8, 18, 40}));
        break;
      case SequenceKind::kUpAndDown:
        plan.Pose(i % 2 == 0 ? 0 : 180, 0);
        plan.Legs(kInner, LegsAt({8, 18}));
        break;
      case SequenceKind::kSixPoses:
        for (const double middle_deg : {0.0, 90.0, 180.0, 270.0}) PoseAndRest(plan, middle_deg, 0);
        for (const double middle_deg : {270.0, 90.0}) PoseAndRest(plan, middle_deg, 90);
        break;
      case SequenceKind::kWarmUpOnly:
      case SequenceKind::kFull:
      case SequenceKind::kElsewhere:
        plan.Rest(60);
        break;
    }
  }
  plan.Rest(60);
}

}  // namespace

Sequence MakeSequence(SequenceKind kind, std::mt19937_64& random, int repeats) {
  Planner plan(random);
  for (int i = 0; i < repeats; ++i) {
    if (kind == SequenceKind::kFull) {
      PlanFull(plan);
    } else if (kind == SequenceKind::kElsewhere) {
      PlanElsewhere(plan);
    } else {
      PlanPoor(kind, plan);
    }
  }
  return plan.Take();
}

}  // namespace gyrobench::blind_trials
