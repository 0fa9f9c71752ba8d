#include "trial/uniform_grid.h"

namespace haptometer::trial {

void UniformGrid::Append(std::int64_t first_index, std::size_t rows) {
  if (stretches_.empty() || first_index != next_index_) {
    stretches_.push_back({.first_row = rows_,
                          .rows = 0,
                          .start_s = static_cast<double>(first_index) / rate_hz_,
                          .rate_hz = rate_hz_,
                          .time_uncertainty_s = 0});
  }
  stretches_.back().rows += rows;
  rows_ += rows;
  next_index_ = first_index + static_cast<std::int64_t>(rows);
}

}  // namespace haptometer::trial
