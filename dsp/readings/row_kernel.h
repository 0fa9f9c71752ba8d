#pragma once

// What row_kernel.cc, compiled once for each instruction set, tells of rows side by side.

#include <cstddef>

namespace haptometer::dsp {

/// Sums are kept in this many lanes, row n in lane n mod kRowLanes, and added in pairs: all
/// instruction sets give the same bytes.
inline constexpr std::size_t kRowLanes = 8;

/// The lanes' values added in pairs. Unnamed on purpose: a file compiled for one instruction set
/// must never hand its copy of a function to a file compiled for another.
namespace {
[[nodiscard]] inline double SumOfLanes(const double (&lanes)[kRowLanes]) {
  return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
         ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}
}  // namespace

/// Sum, least and most of some rows.
struct RowSum {
  double sum = 0;
  double least = 0;
  double most = 0;
};

/// How rows repeat each other.
struct RowRepeats {
  std::size_t equal = 0;    ///< rows from the third on that repeat the one before
  std::size_t triples = 0;  ///< of these, those whose row before repeats, too
  double least = 0;
  double most = 0;
};

/// The functions of one instruction set.
struct RowKernel {
  /// Whether `count` values are finite numbers.
  bool (*all_finite)(const double* rows, std::size_t count);
  /// Of one row and more, finite: sum of row - reference, and extremes.
  RowSum (*sum_from)(const double* rows, std::size_t count, double reference);
  /// The same with the sum of squares.
  RowSum (*sum_squares)(const double* rows, std::size_t count);
  /// Of two rows and more, finite.
  RowRepeats (*repeats)(const double* rows, std::size_t count);
  /// The largest |e| of `count` rows (CubicError, dsp/readings/faults.h), of which those that
  /// are no number count as 0; two rows before and after are read.
  double (*largest_error)(const double* rows, std::size_t count);
  /// The least change from row to row that is not 0, or infinity.
  double (*least_change)(const double* rows, std::size_t count);
};

extern const RowKernel kRowKernelBaseline;
#ifdef __x86_64__
extern const RowKernel kRowKernelAvx2;
extern const RowKernel kRowKernelAvx512;
#else
// no processor has these sets
inline constexpr const RowKernel& kRowKernelAvx2 = kRowKernelBaseline;
inline constexpr const RowKernel& kRowKernelAvx512 = kRowKernelBaseline;
#endif

/// The fastest one that this processor knows.
[[nodiscard]] const RowKernel& WidestRowKernel();

}  // namespace haptometer::dsp
