#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

/// The settings of an IL amplifier by name: what a user writes, and what the codes mean.
namespace haptometer::acquire::il_setting {

/// A code for a data number.
struct Write {
  std::string key;  ///< "sampling"
  int number = 0;   ///< of the data
  int code = 0;
  std::optional<int> only_where{};  ///< written only where the data holds this code now

  friend bool operator==(const Write&, const Write&) = default;
};

/// Reads KEY=VALUE; what has to be written, in order:
///   sampling=default|0.33ms|1ms|2ms|5ms              data 132
///   averaging=1|2|4|...|4096|difference|high-pass    data 133
///   hold=sample|peak|bottom|peak-to-peak|auto-peak|auto-bottom    data 136
///   high-pass=0.1Hz|0.2Hz|...|100Hz                  data 159, and 133 to the high-pass filter
///   high-pass=off                                    data 133 to no averaging, where it is the
///   filter
/// A space and a dash are the same. Errors (Cause::kUsage): no such key or value, with those that
/// exist.
[[nodiscard]] Result<std::vector<Write>> Parse(std::string_view text);

/// `code` of data `number` in the words of Parse(): "0.33ms"; the code itself where it has none.
[[nodiscard]] std::string Describe(int number, int code);

}  // namespace haptometer::acquire::il_setting
