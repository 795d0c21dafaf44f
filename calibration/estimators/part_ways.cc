#include "calibration/estimators/part_ways.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/robust.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr const char* kTurnedAtRest = "turned_at_rest";
constexpr double kSigmas = 10.0;
constexpr double kMadOfNormal = 0.6745;
constexpr double kDriftShare = 0.3;  // of what the offset is followed by from rest to rest
constexpr double kLeast_deg = 0.1, kLeastShare = 0.003, kLeastAtRest_deg_s = 5.0;
// Of the rotation of a row: less about the channel's axis says nothing of it.
constexpr double kAboutTheAxis = 0.7, kLeastDisagreeingTurn_deg = 5.0;
constexpr std::size_t kFewestTurns = 4;
constexpr double kLeastRatio = 1e-3;
constexpr double kMostApart = 0.25;  // of the turns

double RobustDeviation(const std::vector<double>& values) {
  const double middle = Median(values);
  std::vector<double> off;
  for (const double value : values) off.push_back(std::fabs(value - middle));
  return Median(std::move(off)) / kMadOfNormal;
}

class PartedFinder {
 public:
  PartedFinder(const std::vector<Row>& rows, std::size_t channel, double units_per_deg_s,
               const std::vector<Vector3>& gravity_g_s)
      : rows_(rows), gravity_g_s_(gravity_g_s), channel_(channel), units_(units_per_deg_s) {}

  PartedWays Find() {
    FindRests();
    FindTurns();
    for (const Defect* defect : {&rests_, &turns_}) {
      if (defect->count > 0) out_.defects.push_back(*defect);
    }
    return std::move(out_);
  }

 private:
  double Rate(const Row& row) const { return row.z[channel_] / units_ / row.duration_s(); }

  static void Count(const Row& row, std::string where, Defect* defect) {
    if (defect->count++ > 0) return;
    defect->first_t_s = row.begin_s;
    defect->where = std::move(where);
  }

  void FindRests() {
    std::vector<double> rates;
    std::vector<std::size_t> rests;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (!rows_[i].still || !rows_[i].usable[channel_]) continue;
      rests.push_back(i);
      rates.push_back(Rate(rows_[i]));
    }
    if (rates.size() < kFewestTurns) return;
    // A reference that stands for long may make more rests of turns than there are.
    const std::vector<double> usual = Crowd(rates, 2.0 * kLeastAtRest_deg_s);
    const double middle = Median(usual);
    const double most = std::max(kLeastAtRest_deg_s, kSigmas * RobustDeviation(usual));
    const std::vector<bool> away = AwayFromDrift(rates, middle, {most, kDriftShare});
    left_out_.assign(rows_.size(), false);
    for (std::size_t k = 0; k < rests.size(); ++k) {
      if (!away[k]) continue;
      left_out_[rests[k]] = true;
      out_.rows.push_back(rests[k]);
      Count(rows_[rests[k]],
            fmt::format("gyro {}: {:.3g} deg/s", "xyz"[channel_], rates[k] - middle), &rests_);
    }
  }

  // The rest before a turn, and that after it.
  std::vector<std::size_t> RestsAround(std::size_t turn) const {
    std::vector<std::size_t> rests;
    auto take = [&](std::size_t i) {
      if (rows_[i].still && rows_[i].usable[channel_] && !left_out_[i]) rests.push_back(i);
    };
    if (turn > 0) take(turn - 1);
    if (turn + 1 < rows_.size()) take(turn + 1);
    return rests;
  }
  std::optional<double> RateAtRest(std::size_t turn) const {
    const std::vector<std::size_t> rests = RestsAround(turn);
    if (rests.empty()) return std::nullopt;
    double sum = 0.0;
    for (const std::size_t i : rests) sum += Rate(rows_[i]);
    return sum / static_cast<double>(rests.size());
  }
  // The most that g-sensitivity adds to a turn and not to the rests around it.
  double ByGravity_deg(std::size_t turn) const {
    if (gravity_g_s_.empty()) return 0.0;
    const std::vector<std::size_t> rests = RestsAround(turn);
    double most_deg = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      double at_rest_g = 0.0;
      for (const std::size_t i : rests)
        at_rest_g += gravity_g_s_[i][c] / rows_[i].duration_s() / static_cast<double>(rests.size());
      const double more_g_s = gravity_g_s_[turn][c] - at_rest_g * rows_[turn].duration_s();
      most_deg += kGSensitivityOfDataSheet_deg_s_g * std::fabs(more_g_s);
    }
    return most_deg;
  }

  struct Turn {
    std::size_t row;
    double reference_deg, gyro_deg;
  };

  std::vector<Turn> Turns() const {
    std::vector<Turn> turns;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      if (row.still || !row.usable[channel_]) continue;
      const double own_deg = row.rotation_deg[channel_];
      double all_deg = 0.0;
      for (const double part : row.rotation_deg) all_deg += std::fabs(part);
      if (std::fabs(own_deg) < kAboutTheAxis * all_deg) continue;
      const std::optional<double> rest_deg_s = RateAtRest(i);
      if (!rest_deg_s) continue;
      const double gyro_deg = (Rate(row) - *rest_deg_s) * row.duration_s();
      if (std::max(std::fabs(own_deg), std::fabs(gyro_deg)) < kLeastDisagreeingTurn_deg) continue;
      turns.push_back({i, own_deg, gyro_deg});
    }
    return turns;
  }

  void FindTurns() {
    if (left_out_.empty()) left_out_.assign(rows_.size(), false);
    const std::vector<Turn> turns = Turns();
    if (turns.size() < kFewestTurns) return;
    std::vector<double> ratios, off;
    for (const Turn& turn : turns) {
      if (turn.reference_deg != 0.0) ratios.push_back(turn.gyro_deg / turn.reference_deg);
    }
    const double ratio = ratios.empty() ? 0.0 : Median(std::move(ratios));
    if (!(std::fabs(ratio) > kLeastRatio)) return;  // the gyro feels nothing of what turns
    for (const Turn& turn : turns) off.push_back(turn.gyro_deg / ratio - turn.reference_deg);
    // What an offset or its random walk is off by grows with the length of a turn.
    std::vector<double> lengths_s;
    for (const Turn& turn : turns) lengths_s.push_back(rows_[turn.row].duration_s());
    const double deviation = RobustDeviation(off), usual_s = Median(lengths_s);
    std::vector<std::size_t> apart;
    for (std::size_t k = 0; k < turns.size(); ++k) {
      const double longer = std::max(1.0, lengths_s[k] / usual_s);
      const double most = std::max({kLeast_deg * longer, kSigmas * deviation * longer,
                                    kLeastShare * std::fabs(turns[k].reference_deg)}) +
                          ByGravity_deg(turns[k].row);
      if (!(std::fabs(off[k]) > most)) continue;
      const Turn& turn = turns[k];
      apart.push_back(turn.row);
      Count(rows_[turn.row],
            fmt::format("gyro {}: {:.2f} deg by the gyro, {:.2f} deg by the reference",
                        "xyz"[channel_], turn.gyro_deg / ratio, turn.reference_deg),
            &turns_);
    }
    out_.too_many =
        static_cast<double>(apart.size()) > kMostApart * static_cast<double>(turns.size());
    if (!out_.too_many) out_.rows.insert(out_.rows.end(), apart.begin(), apart.end());
  }

  const std::vector<Row>& rows_;
  const std::vector<Vector3>& gravity_g_s_;
  std::size_t channel_;
  double units_;
  std::vector<bool> left_out_;  // by row
  Defect rests_{kTurnedAtRest, 0, kMissing, {}};
  Defect turns_{"turn_disagrees", 0, kMissing, {}};
  PartedWays out_;
};

}  // namespace

void AddDefects(const std::vector<Defect>& found, std::vector<Defect>* defects) {
  for (const Defect& defect : found) {
    // What is said of an axis is said once: scale factor and bias cut the rests into other pieces.
    const std::string axis = defect.where.substr(0, defect.where.find(':'));
    const bool known = std::ranges::any_of(*defects, [&](const Defect& one) {
      return one.kind == defect.kind && one.where.starts_with(axis + ":");
    });
    if (!known) defects->push_back(defect);
  }
}

std::string SaysOf(const Defect& defect, bool too_many) {
  const bool rest = defect.kind == kTurnedAtRest;
  const std::string how_often =
      fmt::format("{} {}{}", defect.count, rest ? "rest" : "turn", defect.count == 1 ? "" : "s");
  const std::string what =
      rest ? fmt::format("in {} by the reference the gyro turns", how_often)
           : fmt::format("in {} gyro and reference contradict each other", how_often);
  return fmt::format(
      "{}, first at {:.1f} s ({}): {}. Look for {}", what, defect.first_t_s, defect.where,
      !rest && too_many ? "too many to be left out, so that this result cannot be trusted"
                        : "left out",
      rest ? "a reference that stands still, or a table that is free"
           : "a slip of the table or its coupling, lost steps, or a reference that stood");
}

PartedWays FindPartedWays(const std::vector<Row>& rows, std::size_t channel, double units_per_deg_s,
                          const std::vector<Vector3>& gravity_g_s) {
  return PartedFinder(rows, channel, units_per_deg_s, gravity_g_s).Find();
}

}  // namespace gyrobench::calibration
