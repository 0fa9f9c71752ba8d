#pragma once

#include <cstddef>
#include <vector>

#include "dsp/statistics/repeated_measures.h"

namespace haptometer::dsp {

/// A table of `values`, subject by subject.
inline CompleteTable TableOf(std::size_t subjects, std::size_t conditions,
                             const std::vector<double>& values) {
  CompleteTable table(subjects, conditions);
  for (std::size_t i = 0; i < values.size(); ++i) {
    table.At(i / conditions, i % conditions) = values[i];
  }
  return table;
}

}  // namespace haptometer::dsp
