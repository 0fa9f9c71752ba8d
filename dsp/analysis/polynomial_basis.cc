#include "dsp/analysis/polynomial_basis.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

// subtracts the projection of `values` on a unit vector
void TakeOutOne(std::span<const double> unit, std::span<double> values) {
  double share = 0;
  for (std::size_t i = 0; i < values.size(); ++i) share += values[i] * unit[i];
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= share * unit[i];
}

void Normalize(std::span<double> values) {
  double square = 0;
  for (const double value : values) square += value * value;
  const double norm = std::sqrt(square);
  for (double& value : values) value /= norm;
}

}  // namespace

PolynomialBasis::PolynomialBasis(std::size_t size, std::size_t degree)
    : size_(size), values_(size * (degree + 1)), step_norms_(size) {
  HAPTOMETER_CHECK(degree < size, "degree {} over {} samples", degree, size);
  const auto n = static_cast<double>(size);
  // squared norm of a step at k, less the part that the polynomials hold
  for (std::size_t k = 0; k < size; ++k) step_norms_[k] = n - static_cast<double>(k);
  for (std::size_t d = 0; d <= degree; ++d) {
    const std::span now = std::span(values_).subspan(d * size, size);
    for (std::size_t i = 0; i < size; ++i) {
      // x times the polynomial before, made orthogonal to all before it (Gram-Schmidt)
      const double x = (2 * static_cast<double>(i) + 1) / n - 1;
      now[i] = d == 0 ? 1 : x * Of(d - 1)[i];
    }
    // a second pass removes the rounding of the first
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t before = 0; before < d; ++before) TakeOutOne(Of(before), now);
    }
    Normalize(now);
    // projection of the step at k on this polynomial: the sum of its values from k on
    double sum = 0;
    for (std::size_t k = size; k-- > 0;) {
      sum += now[k];
      step_norms_[k] -= sum * sum;
    }
  }
}

void PolynomialBasis::TakeOut(std::span<double> values) const {
  HAPTOMETER_CHECK(values.size() == size_, "{} values, {} samples", values.size(), size_);
  for (std::size_t begin = 0; begin < values_.size(); begin += size_) {
    TakeOutOne(std::span(values_).subspan(begin, size_), values);
  }
}

}  // namespace haptometer::dsp
