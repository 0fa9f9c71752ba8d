#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace haptometer::tools {

/// How two different names may be one, written in two ways.
enum class Likeness : std::uint8_t {
  kNone,
  kCaseOrBlanks,  ///< they differ by case or blanks alone
  kOneLetter,     ///< one letter is another, is missing or is too much: "cone", "cones"
};

/// "case or blanks", "one letter"; empty of kNone.
[[nodiscard]] std::string_view WordsOf(Likeness likeness);

/// kOneLetter is of names of 3 characters at least, without regard to case. A digit is
/// no letter ("s1", "s11"), nor is one that stands alone: "rig a", "rig b"; "padA", "padB".
[[nodiscard]] Likeness LikenessOf(std::string_view one, std::string_view other);

struct AlikeNames {
  std::string one;
  std::string other;
  Likeness likeness = Likeness::kNone;
};

/// The pairs of `names` that are alike, in their order. Cost: a comparison a pair.
[[nodiscard]] std::vector<AlikeNames> NamesAlike(const std::vector<std::string>& names);

}  // namespace haptometer::tools
