#include "calibration/state/even_turns.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kShortestReach = 8;  // nodes before and after
constexpr std::size_t kFewest = 2 * kShortestReach;

// By the readings about a node alone: not where their noise makes more than a thousandth of the
// mean rate of six intervals, three on either side of it, by the readings at their ends.
bool ReadingsTell(const AngleSeries& series, std::size_t k, std::size_t begin, std::size_t end) {
  constexpr std::size_t kAbout = 4;
  constexpr double kPart = 2.0 / 6.0, kTold = 1e-3;
  const auto tells = [&](std::size_t from, std::size_t to) {
    const double noise_deg = kPart * series.error_deg * static_cast<double>(to - from);
    return kTold * std::fabs(series.read_deg[to] - series.read_deg[from]) > noise_deg;
  };
  const std::size_t from = k - std::min(k - begin, kAbout), to = std::min(k + kAbout, end - 1);
  return tells(from, k) || tells(k, to);
}

// Least squares of both angles of nodes [begin, end) on 1, x, ... x^(N - 1), with x the time from
// `t_s` in halves of the time that they take.
template <int N>
class Fit {
 public:
  Fit(const AngleSeries& series, double t_s, std::size_t begin, std::size_t end)
      : half_s_(0.5 * (series.t_s[end - 1] - series.t_s[begin])), begin_(begin) {
    Eigen::Matrix<double, N, N> normal = Eigen::Matrix<double, N, N>::Zero();
    Eigen::Matrix<double, N, 2> right = Eigen::Matrix<double, N, 2>::Zero();
    Eigen::Vector2d square = Eigen::Vector2d::Zero();
    for (std::size_t k = begin; k < end; ++k) {
      const Eigen::Matrix<double, N, 1> row = Row((series.t_s[k] - t_s) / half_s_);
      const Eigen::RowVector2d angles(series.read_deg[k] - series.read_deg[begin],
                                      series.felt_deg[k] - series.felt_deg[begin]);
      normal += row * row.transpose();
      right += row * angles;
      square += angles.cwiseAbs2().transpose();
    }
    coefficients_ = normal.ldlt().solve(right);
    const Eigen::Vector2d explained = coefficients_.cwiseProduct(right).colwise().sum();
    const double freedom = static_cast<double>(end - begin) - N;
    left_deg_ = ((square - explained).cwiseMax(0.0) / freedom).cwiseSqrt();
  }

  // Of a random walk of unit variance a second, over a time T, the polynomials below degree n leave
  // the mean square T n / (2 (4 n^2 - 1)), as its parts by Legendre polynomials add up.
  bool IsEven(const AngleSeries& series) const {
    constexpr double kErrors = 1.8, kWalks = 2.0, kOfWalk = N / (2.0 * (4.0 * N * N - 1.0));
    const double walk_deg = series.walk_deg_sqrt_s * std::sqrt(kOfWalk * 2.0 * half_s_);
    return left_deg_(0) < kErrors * series.error_deg && left_deg_(1) < kWalks * walk_deg;
  }
  EvenTurn Turn(const AngleSeries& series) const {
    EvenTurn turn = {series.read_deg[begin_] + coefficients_(0, 0), coefficients_(1, 0) / half_s_};
    if constexpr (N > 2) turn.acceleration_deg_s2 = 2.0 * coefficients_(2, 0) / (half_s_ * half_s_);
    return turn;
  }

 private:
  static Eigen::Matrix<double, N, 1> Row(double x) {
    Eigen::Matrix<double, N, 1> row;
    row(0) = 1.0;
    for (int j = 1; j < N; ++j) row(j) = x * row(j - 1);
    return row;
  }

  double half_s_;
  std::size_t begin_;
  Eigen::Matrix<double, N, 2> coefficients_;
  Eigen::Vector2d left_deg_;
};

}  // namespace

bool HasPartIn(const std::array<std::vector<double>, 3>& read_deg, std::size_t axis,
               std::size_t begin, std::size_t end) {
  constexpr double kSmallPart = 0.05;
  std::array<double, 3> turned_deg = {};
  for (std::size_t i = 0; i < turned_deg.size(); ++i) {
    const auto [least, most] =
        std::ranges::minmax(std::span(read_deg[i]).subspan(begin, end + 1 - begin));
    turned_deg[i] = most - least;
  }
  return turned_deg[axis] > kSmallPart * std::ranges::max(turned_deg);
}

std::optional<EvenTurn> FindEvenTurn(const AngleSeries& series, std::size_t before, double t_s,
                                     std::size_t begin, std::size_t end) {
  if (end < begin + kFewest || ReadingsTell(series, before, begin, end)) return std::nullopt;
  for (std::size_t reach = kLongestReach; reach >= kShortestReach; reach /= 2) {
    const std::size_t from = before - std::min(before - begin, reach);
    const std::size_t to = std::min(before + reach + 1, end);
    if (to < from + kFewest) break;
    if (const Fit<2> line(series, t_s, from, to); line.IsEven(series)) return line.Turn(series);
    // At the ends of what it goes through a cubic is the less exact.
    if (from + reach > before || to < before + reach + 1) continue;
    if (const Fit<4> cubic(series, t_s, from, to); cubic.IsEven(series)) return cubic.Turn(series);
  }
  return std::nullopt;
}

}  // namespace gyrobench::calibration
