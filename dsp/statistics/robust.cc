#include "dsp/statistics/robust.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// Box and Muller: the same on every standard library
double NormalDraw(std::mt19937& engine) {
  constexpr double kRange = 4294967296.0;  // of the engine
  const double u = (static_cast<double>(engine()) + 0.5) / kRange;
  const double v = static_cast<double>(engine()) / kRange;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

double MedianSize(const CompleteTable& left) {
  std::vector<double> sizes(left.values().size());
  std::ranges::transform(left.values(), sizes.begin(), [](double x) { return std::abs(x); });
  return Median(std::move(sizes));
}

// the mean of it over polished tables of standard normal values
double MedianSizeOfNormal(std::size_t subjects, std::size_t conditions) {
  constexpr std::size_t kCells = 6000;
  constexpr std::size_t kLeastTables = 20;
  const std::size_t tables = std::max(kLeastTables, kCells / (subjects * conditions));
  std::mt19937 engine(1);
  double sum = 0;
  for (std::size_t k = 0; k < tables; ++k) {
    CompleteTable table(subjects, conditions);
    for (std::size_t s = 0; s < subjects; ++s) {
      for (std::size_t c = 0; c < conditions; ++c) table.At(s, c) = NormalDraw(engine);
    }
    sum += MedianSize(MedianPolish(table));
  }
  return sum / static_cast<double>(tables);
}

}  // namespace

double Median(std::vector<double> values) {
  HAPTOMETER_CHECK(!values.empty(), "no values");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  const double below = *std::max_element(values.begin(), middle);
  return below + (*middle - below) / 2;
}

std::optional<double> RobustWithinDeviation(std::span<const std::vector<double>> cells) {
  std::vector<double> deviations;
  deviations.reserve(cells.size());
  for (const std::vector<double>& cell : cells) {
    if (cell.size() < 2) continue;
    const auto df = static_cast<double>(cell.size() - 1);
    deviations.push_back(StandardDeviation(cell) / std::sqrt(ChiSquareQuantile(0.5, df) / df));
  }
  if (deviations.empty()) return std::nullopt;
  const double median = Median(std::move(deviations));
  return median > 0 ? std::optional(median) : std::nullopt;
}

CompleteTable MedianPolish(const CompleteTable& table) {
  constexpr int kSweeps = 20;
  CompleteTable left = table;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t c = 0; c < left.conditions(); ++c) {
      const double effect = Median(left.Condition(c));
      for (std::size_t s = 0; s < left.subjects(); ++s) left.At(s, c) -= effect;
    }
    for (std::size_t s = 0; s < left.subjects(); ++s) {
      const auto values = left.Subject(s);
      const double effect = Median({values.begin(), values.end()});
      for (std::size_t c = 0; c < left.conditions(); ++c) left.At(s, c) -= effect;
    }
  }
  return left;
}

double DeviationOfPolished(const CompleteTable& left) {
  HAPTOMETER_CHECK(left.subjects() > 1 && left.conditions() > 1, "{} x {}", left.subjects(),
                   left.conditions());
  return MedianSize(left) / MedianSizeOfNormal(left.subjects(), left.conditions());
}

}  // namespace haptometer::dsp
