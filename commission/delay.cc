#include "commission/delay.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench::commission {
namespace {

// What is left of an encoder's way where it followed the move.
constexpr double kFollows = 0.02;
constexpr double kLeastWay_deg = 1.5;
constexpr std::size_t kFewest = 15;

// The way about the axis of the move, by the gyro.
struct Way {
  std::vector<Utime> utime;
  std::vector<double> angle_deg, rate_deg_s;
};

Way WayOf(std::span<const Devices::Rate> rates, const Vector3& rest_deg_s) {
  Vector3 sum = {};
  for (std::size_t i = 1; i < rates.size(); ++i) {
    const double duration_s = ToSeconds(rates[i].utime - rates[i - 1].utime);
    for (std::size_t a = 0; a < 3; ++a)
      sum[a] += (rates[i].rate_deg_s[a] - rest_deg_s[a]) * duration_s;
  }
  const double length = Length(sum);
  Way way;
  if (!(length > kLeastWay_deg)) return way;
  double angle_deg = 0.0;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    double rate_deg_s = 0.0;
    for (std::size_t a = 0; a < 3; ++a)
      rate_deg_s += (rates[i].rate_deg_s[a] - rest_deg_s[a]) * sum[a] / length;
    if (i > 0)
      angle_deg +=
          0.5 * (rate_deg_s + way.rate_deg_s.back()) * ToSeconds(rates[i].utime - way.utime.back());
    way.utime.push_back(rates[i].utime);
    way.angle_deg.push_back(angle_deg);
    way.rate_deg_s.push_back(rate_deg_s);
  }
  return way;
}

// The registers as one number, the first as the high word: proportional to the angle in either
// order as long as the low word does not go round, and read modulo 2^32 where it does.
std::uint32_t Number(const Words& words) {
  return static_cast<std::uint32_t>(words[0]) << 16 | words[1];
}

// Between neighbouring readings: a count, as the registers have it.
double SmallestStep(const std::vector<double>& counts) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < counts.size(); ++i) {
    const double step = std::fabs(counts[i] - counts[i - 1]);
    if (step > 0.0) smallest = std::min(smallest, step);
  }
  return smallest;
}

}  // namespace

void DelaySeen::Begin(std::size_t encoders) {
  angles_.assign(encoders, {});
  sums_.resize(encoders);
}

void DelaySeen::Add(std::size_t encoder, const Devices::Angle& angle) {
  angles_[encoder].push_back(angle);
}

void DelaySeen::End(std::span<const Devices::Rate> rates, const Vector3& rest_deg_s) {
  const Way way = WayOf(rates, rest_deg_s);
  if (way.utime.size() < kFewest) return;
  for (std::size_t j = 0; j < angles_.size(); ++j) {
    std::vector<Eigen::Vector3d> rows;
    std::vector<double> counts;
    for (const Devices::Angle& angle : angles_[j]) {
      const auto after = std::ranges::lower_bound(way.utime, angle.utime);
      if (after == way.utime.begin() || after == way.utime.end()) continue;
      const auto i = static_cast<std::size_t>(after - way.utime.begin());
      const double share =
          ToSeconds(angle.utime - way.utime[i - 1]) / ToSeconds(way.utime[i] - way.utime[i - 1]);
      const auto between = [&](const std::vector<double>& of) {
        return of[i - 1] + share * (of[i] - of[i - 1]);
      };
      rows.emplace_back(1.0, between(way.angle_deg), between(way.rate_deg_s));
      counts.push_back(static_cast<double>(
          static_cast<std::int32_t>(Number(angle.words) - Number(angles_[j].front().words))));
    }
    if (rows.size() < kFewest) continue;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < rows.size(); ++k) {
      normal += rows[k] * rows[k].transpose();
      right += rows[k] * counts[k];
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
    const Eigen::Vector3d fit = solver.solve(right);
    double square = 0.0;
    for (std::size_t k = 0; k < rows.size(); ++k)
      square += std::pow(counts[k] - rows[k].dot(fit), 2);
    const double rms = std::sqrt(square / static_cast<double>(rows.size() - 3));
    if (!(rms < kFollows * std::fabs(fit(1) * way.angle_deg.back()))) continue;
    const double error_s =
        rms * std::sqrt(solver.solve(Eigen::Vector3d::UnitZ())(2)) / std::fabs(fit(1));
    if (!(error_s > 0.0)) continue;
    const double weight = 1.0 / (error_s * error_s);
    sums_[j].rounding_s = std::max(
        sums_[j].rounding_s,
        0.5 * SmallestStep(counts) / std::fabs(fit(1) * *std::ranges::max_element(way.rate_deg_s)));
    sums_[j].weight += weight;
    sums_[j].weighted_s += weight * (-fit(2) / fit(1));
  }
}

std::vector<std::optional<Measurements::Delay>> DelaySeen::Found() const {
  std::vector<std::optional<Measurements::Delay>> out;
  for (const Sum& sum : sums_) {
    out.emplace_back();
    if (sum.weight > 0.0) {
      out.back() = {sum.weighted_s / sum.weight,
                    std::hypot(1.0 / std::sqrt(sum.weight), sum.rounding_s)};
    }
  }
  return out;
}

}  // namespace gyrobench::commission
