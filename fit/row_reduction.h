#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace haptometer::fit {

/// A linearised problem: rows of derivatives, and a residual a row.
struct LinearRows {
  std::span<const double> derivatives;  ///< (rows x columns), row-major
  std::size_t columns = 0;
  std::span<const double> residuals;  ///< (rows)
};

/// The same least-squares problem in as many rows as it has columns: a matrix T with
/// T'T = [J r]'[J r], J over the columns `used`, r last.
///
/// Rows are taken in by Householder reflections, a stretch at a time that stays in the cache, over
/// the columns alone that are not 0 there. The last columns come first, so that what each of many
/// records has for itself does not mix with the others' (T is no triangle then). As stable as a QR
/// decomposition of the whole. Cost: 2 rows x (columns touched)^2.
///
/// @returns (used + 1) x (used + 1), row-major
[[nodiscard]] std::vector<double> ReduceRows(const LinearRows& rows,
                                             const std::vector<std::size_t>& used);

}  // namespace haptometer::fit
