#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "trial/record.h"

namespace haptometer::trial {

/// The stretches of a clocked source: rows follow each other on a grid, and a new stretch begins
/// where places on it are missing.
class UniformGrid {
 public:
  explicit UniformGrid(double rate_hz) : rate_hz_(rate_hz) {}

  /// The next `rows` rows; the first lies at `first_index` on the grid, at first_index / rate.
  void Append(std::int64_t first_index, std::size_t rows);

  [[nodiscard]] const std::vector<Stretch>& stretches() const { return stretches_; }

 private:
  double rate_hz_;
  std::size_t rows_ = 0;
  std::int64_t next_index_ = 0;
  std::vector<Stretch> stretches_;
};

}  // namespace haptometer::trial
