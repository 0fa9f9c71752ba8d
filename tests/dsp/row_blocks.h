#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "dsp/readings/row_block.h"

namespace haptometer::dsp {

/// Calls `visit` with blocks of `block_rows` rows of a channel, `margin` rows held on either side.
template <typename Visit>
void ForEachBlock(std::span<const double> values, std::span<const trial::SampleStatus> statuses,
                  std::size_t block_rows, std::size_t margin, const Visit& visit) {
  for (std::size_t row = 0; row < values.size(); row += block_rows) {
    RowBlock block;
    block.first_row = row;
    block.end_row = row + std::min(block_rows, values.size() - row);
    block.record_rows = values.size();
    block.held_first = row - std::min(row, margin);
    const std::size_t end = std::min(block.end_row + margin, values.size());
    block.held_values = values.subspan(block.held_first, end - block.held_first);
    block.held_statuses = statuses.subspan(block.held_first, end - block.held_first);
    block.all_ok = AllOk(block.held_statuses) && AllFinite(block.held_values);
    visit(block);
  }
}

}  // namespace haptometer::dsp
