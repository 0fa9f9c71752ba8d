#pragma once

#include <Eigen/Core>
#include <optional>

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

/// Where in [0, to] the polynomial, negative at `to`, was last not negative; `to` if it never was.
[[nodiscard]] double LastAbove(const Eigen::VectorXd& coefficients, double to);

}  // namespace haptometer::sim
