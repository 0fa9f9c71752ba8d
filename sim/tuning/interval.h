#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace haptometer::sim {

/// A closed interval that holds the true result of the arithmetic done with it.
///
/// Each operation rounds to nearest and then moves both ends outwards by |x| 2^-52 + 2^-1074, which
/// is at least one unit in the last place and so more than the half unit that rounding may have
/// cost. The rounding mode is never touched. Operands must be finite; a divisor that holds 0 gives
/// (-inf, inf), a product or quotient with it is not defined.
struct Interval {
  double lower = 0;
  double upper = 0;

  /// The number itself.
  [[nodiscard]] static Interval Of(double value) { return {value, value}; }
  [[nodiscard]] double width() const { return upper - lower; }
  [[nodiscard]] double middle() const { return lower + (upper - lower) / 2; }
  /// Largest |x| of the interval.
  [[nodiscard]] double magnitude() const { return std::max(std::abs(lower), std::abs(upper)); }
};

/// [lower, upper] moved outwards past what rounding may have cost.
[[nodiscard]] inline Interval Outward(double lower, double upper) {
  constexpr double kUlp = std::numeric_limits<double>::epsilon();
  constexpr double kLeast = std::numeric_limits<double>::denorm_min();
  return {lower - std::abs(lower) * kUlp - kLeast, upper + std::abs(upper) * kUlp + kLeast};
}

[[nodiscard]] inline Interval operator+(Interval a, Interval b) {
  return Outward(a.lower + b.lower, a.upper + b.upper);
}
[[nodiscard]] inline Interval operator-(Interval a, Interval b) {
  return Outward(a.lower - b.upper, a.upper - b.lower);
}
[[nodiscard]] inline Interval operator*(Interval a, Interval b) {
  const double p = a.lower * b.lower, q = a.lower * b.upper;
  const double r = a.upper * b.lower, s = a.upper * b.upper;
  return Outward(std::min(std::min(p, q), std::min(r, s)),
                 std::max(std::max(p, q), std::max(r, s)));
}
[[nodiscard]] inline Interval operator/(Interval a, Interval b) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (b.lower <= 0 && b.upper >= 0) return {-kInfinite, kInfinite};
  return a * Outward(1 / b.upper, 1 / b.lower);
}

/// x^2 over the interval: never negative, unlike x * x.
[[nodiscard]] inline Interval Square(Interval x) {
  const double most = x.magnitude();
  const double least =
      x.lower <= 0 && x.upper >= 0 ? 0 : std::min(std::abs(x.lower), std::abs(x.upper));
  const Interval square = Outward(least * least, most * most);
  return {std::max(0.0, square.lower), square.upper};
}

/// sqrt(x); the interval must not reach below 0.
[[nodiscard]] inline Interval SquareRoot(Interval x) {
  const Interval root = Outward(std::sqrt(x.lower), std::sqrt(x.upper));
  return {std::max(0.0, root.lower), root.upper};
}

/// max(0, x): exact.
[[nodiscard]] inline Interval AboveZero(Interval x) {
  return {std::max(0.0, x.lower), std::max(0.0, x.upper)};
}

/// Slopes of max(0, x) over the interval: 0, 1, or all between where it holds the bend.
[[nodiscard]] inline Interval RiseAboveZero(Interval x) {
  return {x.lower > 0 ? 1.0 : 0.0, x.upper > 0 ? 1.0 : 0.0};
}

/// A number with its derivatives by N variables (forward differentiation). T is double, or Interval
/// for bounds of value and derivatives over a box.
template <typename T, std::size_t N>
struct Slope {
  T value{};
  std::array<T, N> by{};
};

/// Variable number `place` with the value `value`.
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> Variable(T value, std::size_t place, T one) {
  Slope<T, N> slope{.value = value};
  slope.by[place] = one;
  return slope;
}

template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> operator+(Slope<T, N> a, const Slope<T, N>& b) {
  a.value = a.value + b.value;
  for (std::size_t k = 0; k < N; ++k) a.by[k] = a.by[k] + b.by[k];
  return a;
}
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> operator+(Slope<T, N> a, T b) {
  a.value = a.value + b;
  return a;
}
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> operator*(Slope<T, N> a, T b) {
  a.value = a.value * b;
  for (T& derivative : a.by) derivative = derivative * b;
  return a;
}
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> operator*(const Slope<T, N>& a, const Slope<T, N>& b) {
  Slope<T, N> product{.value = a.value * b.value};
  for (std::size_t k = 0; k < N; ++k) product.by[k] = a.by[k] * b.value + a.value * b.by[k];
  return product;
}
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> operator/(const Slope<T, N>& a, const Slope<T, N>& b) {
  Slope<T, N> quotient{.value = a.value / b.value};
  for (std::size_t k = 0; k < N; ++k) {
    quotient.by[k] = (a.by[k] - quotient.value * b.by[k]) / b.value;
  }
  return quotient;
}
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> Square(const Slope<T, N>& a) {
  Slope<T, N> square{.value = Square(a.value)};
  for (std::size_t k = 0; k < N; ++k) square.by[k] = (a.value + a.value) * a.by[k];
  return square;
}
/// The value must be positive.
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> SquareRoot(const Slope<T, N>& a) {
  Slope<T, N> root{.value = SquareRoot(a.value)};
  for (std::size_t k = 0; k < N; ++k) root.by[k] = a.by[k] / (root.value + root.value);
  return root;
}

/// max(0, a); the derivative's factor is the interval of all slopes that the bend takes.
template <typename T, std::size_t N>
[[nodiscard]] Slope<T, N> AboveZero(const Slope<T, N>& a) {
  Slope<T, N> above{.value = AboveZero(a.value)};
  const T rise = RiseAboveZero(a.value);
  for (std::size_t k = 0; k < N; ++k) above.by[k] = rise * a.by[k];
  return above;
}

}  // namespace haptometer::sim
