#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace haptometer {

/// The candidate with the smallest edit distance (Levenshtein) to `word`, for "did you mean";
/// empty when there is none or all are further away than half of the word.
[[nodiscard]] std::string Nearest(std::string_view word,
                                  const std::vector<std::string>& candidates);

}  // namespace haptometer
