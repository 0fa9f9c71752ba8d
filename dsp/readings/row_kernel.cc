// Compiled once for each instruction set (dsp/CMakeLists.txt), which names the kernel it makes.
// Here nothing may be shared with other files: everything is in unnamed namespaces.
#include "dsp/readings/row_kernel.h"

#include <experimental/simd>

namespace haptometer::dsp {
namespace {

using Lanes = std::experimental::native_simd<double>;
using std::experimental::element_aligned;
constexpr std::size_t kRegisters = kRowLanes / Lanes::size();
static_assert(kRowLanes % Lanes::size() == 0);

Lanes Load(const double* rows) {
  Lanes lanes;
  lanes.copy_from(rows, element_aligned);
  return lanes;
}

// kRowLanes values in as many registers as they take
struct Row {
  Lanes part[kRegisters];

  explicit Row(double value) {
    for (Lanes& lanes : part) lanes = value;
  }
  void Store(double (&to)[kRowLanes]) const {
    for (std::size_t k = 0; k < kRegisters; ++k) {
      part[k].copy_to(to + k * Lanes::size(), element_aligned);
    }
  }
};

// least and greatest value so far, lane by lane
struct Extent {
  Row least;
  Row most;

  explicit Extent(double first) : least(first), most(first) {}
  void Take(std::size_t register_at, const Lanes& value) {
    Lanes& low = least.part[register_at];
    Lanes& high = most.part[register_at];
    where(value < low, low) = value;
    where(value > high, high) = value;
  }
  // combines all lanes and the `count` rows that fill no register
  template <typename Result>
  void Finish(const double* rest, std::size_t count, Result& result) const {
    double low[kRowLanes];
    double high[kRowLanes];
    least.Store(low);
    most.Store(high);
    result.least = low[0];
    result.most = high[0];
    for (const double value : low) result.least = value < result.least ? value : result.least;
    for (const double value : high) result.most = value > result.most ? value : result.most;
    for (std::size_t k = 0; k < count; ++k) {
      result.least = rest[k] < result.least ? rest[k] : result.least;
      result.most = rest[k] > result.most ? rest[k] : result.most;
    }
  }
};

// 0 x is 0, or NaN where x is NaN or infinite
bool AllFinite(const double* rows, std::size_t count) {
  Row sums(0);
  std::size_t k = 0;
  for (; k + kRowLanes <= count; k += kRowLanes) {
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const Lanes value = Load(rows + k + r * Lanes::size());
      sums.part[r] += 0.0 * value;
    }
  }
  double lanes[kRowLanes];
  sums.Store(lanes);
  double sum = SumOfLanes(lanes);
  for (; k < count; ++k) sum += 0.0 * rows[k];
  return sum == 0;
}

// sum of term(x) with extremes; the order of the sum does not depend on the instruction set
template <typename Term>
RowSum SumOf(const double* rows, std::size_t count, const Term& term) {
  Row sums(0);
  Extent extent(rows[0]);
  std::size_t k = 0;
  for (; k + kRowLanes <= count; k += kRowLanes) {
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const Lanes value = Load(rows + k + r * Lanes::size());
      sums.part[r] += term(value);
      extent.Take(r, value);
    }
  }
  RowSum result;
  extent.Finish(rows + k, count - k, result);
  double lanes[kRowLanes];
  sums.Store(lanes);
  // remaining rows continue lane by lane
  for (std::size_t lane = 0; k < count; ++k, ++lane) lanes[lane] += term(rows[k]);
  result.sum = SumOfLanes(lanes);
  return result;
}

// about `reference`, so that an offset costs no digits
RowSum SumFrom(const double* rows, std::size_t count, double reference) {
  return SumOf(rows, count, [reference](const auto& x) { return x - reference; });
}

RowSum SumSquares(const double* rows, std::size_t count) {
  return SumOf(rows, count, [](const auto& x) { return x * x; });
}

// pairs and triples of equal neighbours with extremes, counted from the third row
RowRepeats Repeats(const double* rows, std::size_t count) {
  Row equal(0);
  Row triples(0);
  Extent extent(rows[0]);
  std::size_t k = 2;
  for (; k + kRowLanes <= count; k += kRowLanes) {
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const double* at = rows + k + r * Lanes::size();
      const Lanes value = Load(at);
      const Lanes before = Load(at - 1);
      const auto repeats = value == before;
      where(repeats, equal.part[r]) += 1.0;
      where(repeats && before == Load(at - 2), triples.part[r]) += 1.0;
      extent.Take(r, value);
    }
  }
  RowRepeats result;
  extent.Finish(rows + k, count - k, result);
  result.least = rows[1] < result.least ? rows[1] : result.least;
  result.most = rows[1] > result.most ? rows[1] : result.most;
  double lanes[kRowLanes];
  equal.Store(lanes);
  result.equal = static_cast<std::size_t>(SumOfLanes(lanes));
  triples.Store(lanes);
  result.triples = static_cast<std::size_t>(SumOfLanes(lanes));
  for (; k < count; ++k) {
    const bool repeats = rows[k] == rows[k - 1];
    result.equal += repeats ? 1 : 0;
    result.triples += repeats && rows[k - 1] == rows[k - 2] ? 1 : 0;
  }
  return result;
}

// e = x[0] - (4 (x[-1] + x[1]) - (x[-2] + x[2])) / 6, in the same order of operations as CubicError
double ErrorAt(const double* x) { return x[0] - (4 * (x[-1] + x[1]) - (x[-2] + x[2])) / 6; }

double LargestError(const double* rows, std::size_t count) {
  Row most(0);
  std::size_t k = 0;
  for (; k + kRowLanes <= count; k += kRowLanes) {
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const double* x = rows + k + r * Lanes::size();
      const Lanes near = Load(x - 1) + Load(x + 1);
      const Lanes far = Load(x - 2) + Load(x + 2);
      const Lanes error = abs(Load(x) - (4 * near - far) / 6);
      where(error > most.part[r], most.part[r]) = error;
    }
  }
  double lanes[kRowLanes];
  most.Store(lanes);
  double largest = 0;
  for (const double lane : lanes) largest = lane > largest ? lane : largest;
  for (; k < count; ++k) {
    const double error = __builtin_fabs(ErrorAt(rows + k));
    largest = error > largest ? error : largest;
  }
  return largest;
}

// the least change above zero between neighbours; infinite where there is none
double LeastChange(const double* rows, std::size_t count) {
  constexpr double kInfinity = __builtin_inf();
  Row least(kInfinity);
  std::size_t k = 1;
  for (; k + kRowLanes <= count; k += kRowLanes) {
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const double* x = rows + k + r * Lanes::size();
      const Lanes change = abs(Load(x) - Load(x - 1));
      where(change > 0 && change < least.part[r], least.part[r]) = change;
    }
  }
  double lanes[kRowLanes];
  least.Store(lanes);
  double result = kInfinity;
  for (const double lane : lanes) result = lane < result ? lane : result;
  for (; k < count; ++k) {
    const double change = __builtin_fabs(rows[k] - rows[k - 1]);
    result = change > 0 && change < result ? change : result;
  }
  return result;
}

}  // namespace

const RowKernel HAPTOMETER_KERNEL = {AllFinite, SumFrom,      SumSquares,
                                     Repeats,   LargestError, LeastChange};

}  // namespace haptometer::dsp
