#include "dsp/analysis/window_faults.h"

#include <algorithm>
#include <numbers>

namespace haptometer::dsp {

// clipped rows in a part; rows that are not listed count as inside, so the number is an upper bound
std::size_t ClippedRows(const Faults& faults, std::size_t first_row, std::size_t rows) {
  std::size_t listed = 0;
  std::size_t inside = 0;
  for (const Fault& fault : faults.list) {
    if (fault.kind != FaultKind::kClipped) continue;
    listed += fault.rows;
    const std::size_t begin = std::max(fault.first_row, first_row);
    const std::size_t end = std::min(fault.first_row + fault.rows, first_row + rows);
    if (end > begin) inside += end - begin;
  }
  return std::min(rows, inside + (faults.Rows(FaultKind::kClipped) - listed));
}

double FaultPower(const Faults& faults, FaultKind kind, const UsedPart& part, const BandPass& band,
                  double rate_hz) {
  const double turn = 2 * std::numbers::pi;
  double energy = 0;
  for (const Fault& fault : faults.list) {
    if (fault.kind != kind || fault.first_row + fault.rows <= part.first_row ||
        fault.first_row >= part.first_row + part.rows) {
      continue;
    }
    // a spike of area A has the density 2 A^2 over the band, a step of height h 2 h^2 / (2 pi f)^2
    const double area = fault.size * static_cast<double>(fault.rows) / rate_hz;
    energy += kind == FaultKind::kSpike ? 2 * (band.upper_hz - band.lower_hz) * area * area
                                        : 2 * fault.size * fault.size / (turn * turn) *
                                              (1 / band.lower_hz - 1 / band.upper_hz);
  }
  // energy over the duration of the part
  return energy * rate_hz / static_cast<double>(part.rows);
}

}  // namespace haptometer::dsp
