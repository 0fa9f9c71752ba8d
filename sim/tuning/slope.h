#pragma once

#include <array>
#include <cstddef>

#include "sim/tuning/interval.h"

namespace haptometer::sim {

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
