#pragma once

#include <cstdint>

namespace haptometer::sim {

/// Points spread evenly over every axis at once: each of the `samples` equal parts of each axis
/// holds one point.
///
/// M. D. McKay, R. J. Beckman, W. J. Conover, A Comparison of Three Methods for Selecting Values of
/// Input Variables in the Analysis of Output from a Computer Code, Technometrics 21, 1979. On each
/// axis the parts are dealt out by a permutation of its own, a Feistel network of random functions
/// (M. Luby, C. Rackoff, SIAM J. Comput. 17, 1988) whose values from `samples` on are walked past
/// (J. Black, P. Rogaway, Ciphers with Arbitrary Finite Domains, CT-RSA 2002). So a point is a
/// function of seed, `samples`, axis and its own number, and needs no table: it is the same in
/// every shard. With another `samples` it is another point, because the parts are others.
struct LatinHypercube {
  std::uint64_t samples = 1;  ///< 1 to 2^30
  std::uint64_t seed = 1;

  /// The part of `axis` that `point` (both from 0) lies in: 0 to samples - 1, each once over all
  /// points. Cost: about 0.2 us.
  [[nodiscard]] std::uint64_t PartOf(std::uint32_t axis, std::uint64_t point) const;

  /// Where in its part, at random, in steps of 2^-22: in (0, 1), ends excluded.
  [[nodiscard]] double PlaceInPart(std::uint32_t axis, std::uint64_t point) const;
};

}  // namespace haptometer::sim
