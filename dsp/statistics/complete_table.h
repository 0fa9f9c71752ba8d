#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/error.h"

namespace haptometer::dsp {

/// Subjects x conditions without a hole: value (s, c) is that of subject s in condition c.
class CompleteTable {
 public:
  CompleteTable(std::size_t subjects, std::size_t conditions)
      : subjects_(subjects), conditions_(conditions), values_(subjects * conditions) {}

  [[nodiscard]] std::size_t subjects() const { return subjects_; }
  [[nodiscard]] std::size_t conditions() const { return conditions_; }
  [[nodiscard]] double& At(std::size_t s, std::size_t c) {
    HAPTOMETER_CHECK(s < subjects_ && c < conditions_, "{}, {}", s, c);
    return values_[s * conditions_ + c];
  }
  [[nodiscard]] double At(std::size_t s, std::size_t c) const {
    HAPTOMETER_CHECK(s < subjects_ && c < conditions_, "{}, {}", s, c);
    return values_[s * conditions_ + c];
  }
  /// All values of subject `s`.
  [[nodiscard]] std::span<const double> Subject(std::size_t s) const {
    HAPTOMETER_CHECK(s < subjects_, "{}", s);
    return std::span(values_).subspan(s * conditions_, conditions_);
  }
  /// All values of condition `c`, a copy.
  [[nodiscard]] std::vector<double> Condition(std::size_t c) const {
    std::vector<double> column(subjects_);
    for (std::size_t s = 0; s < subjects_; ++s) column[s] = At(s, c);
    return column;
  }
  [[nodiscard]] std::span<const double> values() const { return values_; }

 private:
  std::size_t subjects_;
  std::size_t conditions_;
  std::vector<double> values_;  // subject by subject
};

}  // namespace haptometer::dsp
