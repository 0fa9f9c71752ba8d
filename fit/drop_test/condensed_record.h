#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "fit/drop_test/ring_down_problem.h"
#include "fit/drop_test/ringing_model.h"

namespace haptometer::fit {

/// What stands for many samples in a least-squares problem: with F and y the parts and values of
/// all samples, each in units of its noise, the few rows have the same [F y]'[F y].
struct CondensedRow {
  PartNumbers parts{};
  double value_v = 0;
};

/// Whether the ringing swings long enough for kByDiscriminant to be had from the other parts
/// without loss: (q - d^2) t^2 above 100 at the last sample.
[[nodiscard]] bool CanBeCondensed(const RingDownSamples& record, const RingingRates& rates);

/// Condenses one record at any rates.
///
/// By the addition theorems (fit/drop_test/ringing_model.h) the parts of a block of samples are
/// those of any other block times a small matrix. One block's parts are made orthonormal by
/// reflections; each block's samples then leave their products with them, and the length of the
/// rest. What blocks leave is reduced as in fit/least_squares.h: as stable as a QR decomposition of
/// all rows of F. Samples with a weight, beside a hole, or in the coil's current's own decay are
/// rows by themselves.
class Condenser {
 public:
  /// The record must outlive it, unchanged.
  explicit Condenser(const RingDownSamples& record);

  /// Where CanBeCondensed. The last answer is kept: solvers ask for a point's derivatives after its
  /// residuals. Cost: 20 operations a sample.
  [[nodiscard]] const std::vector<CondensedRow>& At(const RingingRates& rates);

  /// Samples that are taken together: a block, or one alone.
  struct Stretch {
    std::size_t first = 0;
    bool is_block = false;
  };

 private:
  const RingDownSamples* record_;
  std::vector<Stretch> stretches_;
  std::optional<RingingRates> rates_;  // of the last answer
  std::vector<CondensedRow> last_;
};

}  // namespace haptometer::fit
