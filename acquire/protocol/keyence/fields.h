#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace haptometer::acquire {

/// The fields of one line, between its commas: `a,b,,c` -> a, b, "", c. No allocation; the fields
/// point into the line.
class Fields {
 public:
  /// MS of fifteen amplifiers: the command, and two fields for each.
  static constexpr std::size_t kMost = 31;

  explicit Fields(std::string_view line);

  /// Whether the line has more than kMost fields, of which all but the first kMost are dropped.
  [[nodiscard]] bool too_many() const { return too_many_; }
  /// How many there are: at least 1, at most kMost.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::string_view operator[](std::size_t i) const { return fields_[i]; }
  /// Those behind the first.
  [[nodiscard]] std::span<const std::string_view> Rest() const {
    return std::span(fields_).subspan(1, size_ - 1);
  }

 private:
  std::array<std::string_view, kMost> fields_{};
  std::size_t size_ = 0;
  bool too_many_ = false;
};

}  // namespace haptometer::acquire
