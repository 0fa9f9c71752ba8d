#include "sim/tuning/compass_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace haptometer::sim {

namespace {

using Function = std::function<double(const std::vector<double>&)>;

// the next of all combinations of digits below `base`, as an odometer; false after the last
bool Advance(std::vector<int>& digits, int base) {
  for (int& digit : digits) {
    if (++digit < base) return true;
    digit = 0;
  }
  return false;
}

// the best of the neighbours one step away, or `here`
CubePoint BestNeighbour(const Function& function, const CubePoint& here, double step) {
  CubePoint best = here;
  std::vector<int> digits(here.place.size(), 0);
  std::vector<double> place(here.place.size());
  do {
    for (std::size_t k = 0; k < place.size(); ++k) {
      place[k] = std::clamp(here.place[k] + (digits[k] - 1) * step, 0.0, 1.0);
    }
    const double value = function(place);
    if (value > best.value) best = {.place = place, .value = value};
  } while (Advance(digits, 3));
  return best;
}

}  // namespace

CubePoint ClimbWithinCube(const Function& function, std::vector<double> start) {
  constexpr int kFirstHalving = 4;
  constexpr int kLastHalving = 40;
  constexpr int kMostMoves = 1000;
  // what the rounding of a function of some ten operations may feign
  constexpr double kGain = 16 * std::numeric_limits<double>::epsilon();
  CubePoint here{.place = std::move(start)};
  here.value = function(here.place);
  for (int halving = kFirstHalving; halving <= kLastHalving; ++halving) {
    const double step = std::ldexp(1, -halving);
    for (int move = 0; move < kMostMoves; ++move) {
      CubePoint next = BestNeighbour(function, here, step);
      if (!(next.value - here.value > kGain * std::abs(here.value))) break;
      here = std::move(next);
    }
  }
  return here;
}

}  // namespace haptometer::sim
