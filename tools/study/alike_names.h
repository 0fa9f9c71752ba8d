#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace haptometer::tools {

/// How two different names may be one, written in two ways.
enum class Likeness : std::uint8_t {
  kNone,
  kSpelling,   ///< they differ by case, blanks or zeros in front alone
  kAccents,    ///< and by accents on Latin letters, or how these are encoded
  kOneLetter,  ///< one letter is another, is missing or is too much: "cone", "cones"
};

/// "case, blanks or zeros in front", "case, accents or their encoding", "one letter"; empty of
/// kNone.
[[nodiscard]] std::string_view WordsOf(Likeness likeness);

/// kOneLetter is of names of 3 characters at least, without regard to case. A digit is
/// no letter ("s1", "s11"), nor is one that stands alone: "rig a", "rig b"; "padA", "padB".
[[nodiscard]] Likeness LikenessOf(std::string_view one, std::string_view other);

/// "subject" for "subjct" and "Subject": the label that a study sorts trials by (subject,
/// condition, repeat) and that `label` may be meant for; empty where it is one of them, or like
/// none.
[[nodiscard]] std::string_view StudyLabelLike(std::string_view label);

/// Remarks on each of `labels` that a study would not find, by what it is like.
void RemarkOnLabels(std::string_view verb, const std::map<std::string, std::string>& labels);

struct AlikeNames {
  std::string one;
  std::string other;
  Likeness likeness = Likeness::kNone;
};

/// The pairs of `names` that are alike, in their order. Cost: a comparison a pair.
[[nodiscard]] std::vector<AlikeNames> NamesAlike(const std::vector<std::string>& names);

}  // namespace haptometer::tools
