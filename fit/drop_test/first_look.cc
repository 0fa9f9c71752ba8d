#include "fit/drop_test/first_look.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "base/median.h"

namespace haptometer::fit {
namespace {

using Complex = std::complex<double>;

// e^(-2 pi j n / period) as a product of two from tables: 64 first ones, and every 64th
class Turn {
 public:
  Turn(std::size_t count, double period_samples) {
    const auto at = [period_samples](std::size_t n) {
      return std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(n) / period_samples);
    };
    for (std::size_t n = 0; n < kFirst; ++n) first_.push_back(at(n));
    for (std::size_t n = 0; n <= count / kFirst; ++n) further_.push_back(at(n * kFirst));
  }

  [[nodiscard]] Complex At(std::size_t n) const {
    return further_[n / kFirst] * first_[n % kFirst];
  }

 private:
  static constexpr std::size_t kFirst = 64;
  std::vector<Complex> first_;
  std::vector<Complex> further_;
};

}  // namespace

std::vector<double> Filled(const std::vector<double>& values) {
  std::vector<double> filled = values;
  std::size_t last = values.size();
  for (std::size_t n = 0; n < values.size(); ++n) {
    if (!std::isfinite(values[n])) continue;
    const double from = last == values.size() ? values[n] : values[last];
    const std::size_t first = last == values.size() ? 0 : last + 1;
    for (std::size_t k = first; k < n; ++k) {
      filled[k] = from + (values[n] - from) * static_cast<double>(k + 1 - first) /
                             static_cast<double>(n + 1 - first);
    }
    last = n;
  }
  // behind the last sample: its value
  for (std::size_t k = last + 1; k < values.size(); ++k) filled[k] = values[last];
  return filled;
}

std::vector<double> FollowingAmplitude(const std::vector<double>& values, double middle_v,
                                       double period_samples) {
  const auto period = static_cast<std::size_t>(std::ceil(period_samples));
  // running sum of v e^(-j w t): the sum over any period is a difference of two
  const Turn turn(values.size(), period_samples);
  std::vector<Complex> turned(values.size() + 1);
  for (std::size_t n = 0; n < values.size(); ++n) {
    turned[n + 1] = turned[n] + (values[n] - middle_v) * turn.At(n);
  }
  std::vector<double> amplitudes;
  amplitudes.reserve(values.size());
  for (std::size_t n = 0; n + period < turned.size(); ++n) {
    amplitudes.push_back(std::abs(turned[n + period] - turned[n]));
  }
  return amplitudes;
}

double NoiseOfSamples(const std::vector<double>& values) {
  HAPTOMETER_CHECK(values.size() > 3, "{} values", values.size());
  std::vector<double> differences;
  differences.reserve(values.size() - 3);
  for (std::size_t n = 3; n < values.size(); ++n) {
    differences.push_back(
        std::abs(values[n] - 3 * values[n - 1] + 3 * values[n - 2] - values[n - 3]));
  }
  return kDeviationsPerMedian * Median(std::move(differences)) / std::sqrt(20.0);
}

namespace {

constexpr Eigen::Index kSlowParts = 5;  // 1, x, ... x^4, x from -1 to 1 over the record
constexpr std::array kMainsHz{50.0, 60.0};
constexpr Eigen::Index kAllParts = kSlowParts + 2 * Eigen::Index{kMainsHz.size()};
using PartValues = Eigen::Matrix<double, 1, kAllParts>;

// what may last, at a share of 0 to 1 of the record's length
PartValues PartsAt(double share, double length_s) {
  PartValues parts;
  double power = 1;
  for (Eigen::Index k = 0; k < kSlowParts; ++k) {
    parts[k] = power;
    power *= 2 * share - 1;
  }
  for (std::size_t k = 0; k < kMainsHz.size(); ++k) {
    const double angle = 2 * std::numbers::pi * kMainsHz[k] * share * length_s;
    const Eigen::Index first = kSlowParts + 2 * static_cast<Eigen::Index>(k);
    parts[first] = std::cos(angle);
    parts[first + 1] = std::sin(angle);
  }
  return parts;
}

// means of consecutive blocks
Eigen::VectorXd MeansOf(const std::vector<double>& values, std::size_t block) {
  const auto count = static_cast<Eigen::Index>(values.size() / block);
  Eigen::VectorXd means(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const Eigen::Map<const Eigen::VectorXd> one(values.data() + static_cast<std::size_t>(n) * block,
                                                static_cast<Eigen::Index>(block));
    means[n] = one.mean();
  }
  return means;
}

// median of the mean squares of equal stretches
double TypicalPower(const Eigen::VectorXd& values) {
  constexpr Eigen::Index kStretches = 16;
  const Eigen::Index length = values.size() / kStretches;
  std::vector<double> powers;
  powers.reserve(kStretches);
  for (Eigen::Index k = 0; k < kStretches; ++k) {
    powers.push_back(values.segment(k * length, length).squaredNorm());
  }
  return Median(std::move(powers)) / static_cast<double>(length);
}

}  // namespace

std::optional<std::vector<double>> WithoutWhatLasts(const std::vector<double>& values,
                                                    double step_s) {
  constexpr Eigen::Index kLeastBlocks = 64;
  constexpr double kBlocks = 256;  // at least, where there are as many samples
  constexpr double kBlock_s = 1e-3;
  constexpr double kMostLeft = 0.8;  // of the typical power
  const std::vector<double> filled = Filled(values);
  if (filled.size() < std::size_t{kLeastBlocks} || !std::isfinite(filled.front())) return {};
  const double length_s = static_cast<double>(values.size()) * step_s;
  const double wanted = std::min(kBlock_s, length_s / kBlocks) / step_s;
  const std::size_t block = std::max<std::size_t>(static_cast<std::size_t>(wanted), 1);
  const Eigen::VectorXd means = MeansOf(filled, block);
  const Eigen::Index count = means.size();
  const double blocks_a_record = static_cast<double>(values.size()) / static_cast<double>(block);
  Eigen::Matrix<double, Eigen::Dynamic, kAllParts> parts(count, kAllParts);
  for (Eigen::Index n = 0; n < count; ++n) {
    parts.row(n) = PartsAt((static_cast<double>(n) + 0.5) / blocks_a_record, length_s);
  }
  // slow parts, then hum with them; each is kept where it leaves much less
  const bool tells_mains = length_s * (kMainsHz.back() - kMainsHz.front()) >= 1;
  double typical = TypicalPower(means.array() - Median({means.begin(), means.end()}));
  Eigen::VectorXd taken;
  for (const Eigen::Index tried : {kSlowParts, kAllParts}) {
    if (tried == kAllParts && !tells_mains) continue;
    const auto columns = parts.leftCols(tried);
    const Eigen::VectorXd fitted = columns.householderQr().solve(means);
    const double left = TypicalPower(means - columns * fitted);
    if (left >= kMostLeft * typical) continue;
    typical = left;
    taken = fitted;
  }
  if (taken.size() == 0) return std::nullopt;
  const double mean = means.mean();
  std::vector<double> rest = values;
  for (std::size_t n = 0; n < rest.size(); ++n) {
    const double share = (static_cast<double>(n) + 0.5) / static_cast<double>(rest.size());
    rest[n] += mean - PartsAt(share, length_s).head(taken.size()).dot(taken.transpose());
  }
  return rest;
}

}  // namespace haptometer::fit
