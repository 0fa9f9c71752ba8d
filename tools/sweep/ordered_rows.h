#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "base/error.h"

namespace haptometer::tools {

/// Rows that several threads make and one file takes in order.
struct RowWork {
  std::uint64_t first = 0;  ///< rows before it are there
  std::uint64_t count = 0;  ///< rows in all
  int threads = 1;          ///< >= 1
  /// Makes a row; called by several threads at once.
  std::function<std::string(std::uint64_t row)> make;
  /// Takes whole rows, in order, one call at a time; `done` are there then.
  std::function<Result<void>(std::string_view rows, std::uint64_t done)> write;
  const std::atomic<bool>* stop = nullptr;  ///< once true no further row is begun
};

/// Makes and writes the rows; returns how many are there in the end: all, unless it was stopped.
///
/// A thread takes as many rows at a time as last about 5 ms (one at first, 256 at most) and goes on
/// without waiting for slower ones, up to 16 384 rows ahead of the first that is missing. What is
/// written depends neither on `threads` nor on the clock. Errors: of `write`; then no more is made.
[[nodiscard]] Result<std::uint64_t> MakeRowsInOrder(const RowWork& work);

}  // namespace haptometer::tools
