#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// Polynomials orthonormal over evenly spaced samples (Gram's).
///
/// Each is x times the one before, made orthogonal to all before it twice over: by their recurrence
/// of three terms alone degrees above 2 sqrt(samples) lose their digits, with this all degrees
/// below `size` are orthonormal to 1e-13. Cost: 4 size degree^2 flops once; size x degree numbers.
class PolynomialBasis {
 public:
  /// Degrees 0 to `degree`, below `size`.
  PolynomialBasis(std::size_t size, std::size_t degree);

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Takes the polynomial nearest to them out of `size` values.
  void TakeOut(std::span<double> values) const;

  /// (size) sum of squares of what is left of a step from 0 to 1 at value k.
  [[nodiscard]] const std::vector<double>& step_norms() const { return step_norms_; }

 private:
  [[nodiscard]] std::span<const double> Of(std::size_t degree) const {
    return std::span(values_).subspan(degree * size_, size_);
  }

  std::size_t size_;
  std::vector<double> values_;  // one polynomial behind the other
  std::vector<double> step_norms_;
};

}  // namespace haptometer::dsp
