#include "tools/reproduce/scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptometer::tools {
namespace {

constexpr int kSteps = 1000;

double PlaceOf(int step, double low, double high) {
  const double part = static_cast<double>(step) / kSteps;
  return low + (high - low) * part;
}

}  // namespace

double LargestAt(const std::function<double(double)>& function, double low, double high) {
  int best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (int step = 0; step <= kSteps; ++step) {
    const double value = function(PlaceOf(step, low, high));
    if (value > most) {
      most = value;
      best = step;
    }
  }
  double a = PlaceOf(std::max(best - 1, 0), low, high);
  double b = PlaceOf(std::min(best + 1, kSteps), low, high);
  constexpr double kShorter = 1 / std::numbers::phi;
  while (b - a > 1e-9 * (high - low)) {
    const double left = b - kShorter * (b - a);
    const double right = a + kShorter * (b - a);
    if (function(left) > function(right)) {
      b = right;
    } else {
      a = left;
    }
  }
  return (a + b) / 2;
}

std::optional<double> CrossingOf(const std::function<double(double)>& function, double low,
                                 double high) {
  const bool sign = function(high) > 0;
  for (int step = kSteps - 1; step >= 0; --step) {
    double a = PlaceOf(step, low, high);
    if ((function(a) > 0) == sign) continue;
    double b = PlaceOf(step + 1, low, high);
    for (double middle = (a + b) / 2; middle > a && middle < b; middle = (a + b) / 2) {
      ((function(middle) > 0) == sign ? b : a) = middle;
    }
    return b;
  }
  return std::nullopt;
}

}  // namespace haptometer::tools
