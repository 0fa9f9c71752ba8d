#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace haptometer::sim {

/// One value of a scene's key.
struct SweepValue {
  std::string literal;  ///< as a scene holds it, TOML: `225`, `"skin"`, `true`
  std::string text;     ///< as a table shows it: `225`, `skin`, `true`
};

/// A number, with as many digits as give it back exactly.
[[nodiscard]] SweepValue NumberValue(double number);
/// A whole number, `true` or `false`, as written.
[[nodiscard]] SweepValue PlainValue(std::string_view word);
[[nodiscard]] SweepValue TextValue(std::string_view text);

/// How the values of a range lie.
enum class Spacing : std::uint8_t { kLinear, kLogarithmic };

/// Numbers from `begin` to `end`.
struct SweepRange {
  double begin = 0;
  double end = 0;  ///< not `begin`; may be below it. Logarithmic: both above 0
  Spacing spacing = Spacing::kLinear;
  std::size_t count = 0;  ///< of a grid, 2 or more, both ends among them; 0: to be sampled
};

/// The value at `numerator`/`denominator` of the way; the ends are exact, and so are the values
/// between where their products with `denominator` are.
[[nodiscard]] double ValueAt(const SweepRange& range, double numerator, double denominator);

/// A key of a scene and the values that it takes.
struct SweepAxis {
  std::string key;  ///< "drive.frequency_hz"
  std::variant<SweepRange, std::vector<SweepValue>> values;
};

/// How many values a list or a grid has; 0 for a range that is to be sampled.
[[nodiscard]] std::size_t CountOf(const SweepAxis& axis);

/// Value `index` of a list or a grid.
[[nodiscard]] SweepValue ValueOf(const SweepAxis& axis, std::size_t index);

/// The axis in SI as the command line takes it: "100:400:301", "log:1:1000:4", "600,1200".
[[nodiscard]] std::string WordOf(const SweepAxis& axis);

/// 128 random bits that are a function of a counter and a key alone: no state, so the numbers of
/// one point of a sweep do not depend on which points are computed, where, or in which order.
///
/// Philox 4x32 with 10 rounds: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, Parallel Random
/// Numbers: As Easy as 1, 2, 3, SC11, 2011, sections 3.3 and 4.3. Cost: about 10 ns.
[[nodiscard]] std::array<std::uint32_t, 4> CounterRandom(
    const std::array<std::uint32_t, 4>& counter, std::uint64_t key);

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

/// The points of a sweep: every combination of the axes' values (the last axis runs fastest), or a
/// Latin hypercube over them.
///
/// Each point is computed from its number alone, so shards and threads need no common state.
class SweepPoints {
 public:
  /// Without `sampling` every range has a count; with it none has, and a list is dealt out evenly.
  /// At least one axis.
  explicit SweepPoints(std::vector<SweepAxis> axes,
                       const std::optional<LatinHypercube>& sampling = std::nullopt);

  /// How many; the largest 64-bit number where there are more than it tells.
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// The values of point `point` (from 0), one an axis. Cost: 0.1 us an axis, sampled 0.5 us.
  [[nodiscard]] std::vector<SweepValue> At(std::uint64_t point) const;

  [[nodiscard]] const std::vector<SweepAxis>& axes() const { return axes_; }
  [[nodiscard]] const std::optional<LatinHypercube>& sampling() const { return sampling_; }

 private:
  [[nodiscard]] SweepValue SampledValue(std::size_t axis, std::uint64_t point) const;

  std::vector<SweepAxis> axes_;
  std::optional<LatinHypercube> sampling_;
  std::uint64_t size_ = 1;
};

}  // namespace haptometer::sim
