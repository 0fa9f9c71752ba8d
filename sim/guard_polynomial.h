#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/piecewise_linear.h"

namespace haptometer::sim {

/// Where in [from, 1] a polynomial, c0 + c1 u + c2 u^2 ..., first falls below zero; nothing if it
/// never does.
///
/// Decided by the signs of its Bernstein coefficients (Descartes' rule: none negative, no fall; one
/// change of sign, one root), halving what they leave open. So two crossings close together cannot
/// hide, and it always ends: 2^-52 is as far as places are told apart. Returned is the last place
/// at which the polynomial is not yet negative, or `from`.
///
/// Coefficients that are not finite count as no fall. Cost: degree^2 flops where the polynomial
/// stays clear of zero.
[[nodiscard]] std::optional<double> FirstFall(const Eigen::VectorXd& coefficients, double from);

/// Extends a range by what the polynomial comes to inside [from, to], its ends left out.
///
/// Its Bernstein coefficients bound it: parts that lie within the range, or in which the
/// coefficients only rise or only fall, hold nothing new; others are halved down to 2^-26, where an
/// extreme is flat to rounding.
void ExtendRange(const Eigen::VectorXd& coefficients, double from, double to, ValueRange& range);

/// The polynomial's value at u.
[[nodiscard]] double PolynomialValue(const Eigen::VectorXd& coefficients, double u);

/// Where in [0, to] the polynomial, negative at `to`, was last not negative; `to` if it never was.
[[nodiscard]] double LastAbove(const Eigen::VectorXd& coefficients, double to);

}  // namespace haptometer::sim
