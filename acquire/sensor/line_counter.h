#pragma once

#include <cstdint>
#include <optional>

namespace haptometer::acquire {

/// Lines that are missing, by the number that each line carries.
///
/// The number goes from 0 to turn - 1 and begins again. A damaged line carries none, but was there.
/// Whole turns cannot be seen: turn lines lost in a row look like none.
class LineCounter {
 public:
  /// `turn` >= 1.
  explicit LineCounter(std::int32_t turn) : turn_(turn) {}

  /// How many lines are missing directly before the one numbered `number` (0 <= number < turn);
  /// none before the first.
  [[nodiscard]] std::int64_t LostBefore(std::int32_t number);

  /// A line came whose number cannot be read.
  void CountDamaged() { ++damaged_; }

 private:
  std::int32_t turn_;
  std::optional<std::int32_t> last_;
  std::int64_t damaged_ = 0;  ///< since the last number
};

}  // namespace haptometer::acquire
