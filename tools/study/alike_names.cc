#include "tools/study/alike_names.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::tools {
namespace {

bool IsLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool IsUpper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
char Lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// without case, blanks and the zeros in front of numbers
std::string Folded(std::string_view name) {
  std::string folded;
  for (std::size_t at = 0; at < name.size(); ++at) {
    const bool follows_digit = !folded.empty() && IsDigit(folded.back());
    const bool leads = at + 1 < name.size() && IsDigit(name[at + 1]);
    if (name[at] == ' ' || (name[at] == '0' && leads && !follows_digit)) continue;
    folded += Lower(name[at]);
  }
  return folded;
}

// whether the letter is a word of its own: "a" in "rig a", "B" in "padB"
bool IsAlone(std::string_view name, std::size_t at) {
  const bool follows =
      at > 0 && IsLetter(name[at - 1]) && (IsUpper(name[at - 1]) || !IsUpper(name[at]));
  return !follows && (at + 1 == name.size() || !IsLetter(name[at + 1]));
}

bool DifferByOneLetter(std::string_view longer, std::string_view shorter) {
  if (shorter.size() < 3 || longer.size() - shorter.size() > 1) return false;
  const auto is_same = [](char a, char b) { return Lower(a) == Lower(b); };
  // all but one character: what both begin with, and what both end with
  const auto begin = std::ranges::mismatch(longer, shorter, is_same);
  const auto at = static_cast<std::size_t>(begin.in1 - longer.begin());
  if (at == longer.size()) return false;
  const std::string_view rest = longer.substr(at + 1);
  const std::string_view other = shorter.substr(at + (longer.size() == shorter.size() ? 1 : 0));
  if (!std::ranges::equal(rest, other, is_same)) return false;
  if (!IsLetter(longer[at]) || IsAlone(longer, at)) return false;
  // a letter that was put in place of another
  return longer.size() > shorter.size() || (IsLetter(shorter[at]) && !IsAlone(shorter, at));
}

}  // namespace

std::string_view WordsOf(Likeness likeness) {
  if (likeness == Likeness::kNone) return {};
  return likeness == Likeness::kOneLetter ? "one letter" : "case, blanks or zeros in front";
}

Likeness LikenessOf(std::string_view one, std::string_view other) {
  if (one == other) return Likeness::kNone;
  if (Folded(one) == Folded(other)) return Likeness::kSpelling;
  const bool is_longer = one.size() >= other.size();
  return DifferByOneLetter(is_longer ? one : other, is_longer ? other : one) ? Likeness::kOneLetter
                                                                             : Likeness::kNone;
}

std::string_view StudyLabelLike(std::string_view label) {
  static constexpr std::array<std::string_view, 3> kLabels{"subject", "condition", "repeat"};
  if (std::ranges::count(kLabels, label) > 0) return {};
  const auto like = std::ranges::find_if(kLabels, [label](std::string_view known) {
    return LikenessOf(label, known) != Likeness::kNone;
  });
  return like == kLabels.end() ? std::string_view() : *like;
}

void RemarkOnLabels(std::string_view verb, const std::map<std::string, std::string>& labels) {
  for (const auto& [label, value] : labels) {
    const std::string_view meant = StudyLabelLike(label);
    if (meant.empty()) continue;
    cli::Remark(verb,
                fmt::format("doubt: the label {} is kept, and no study reads it: was {} meant?",
                            Printable(label), meant));
  }
}

std::vector<AlikeNames> NamesAlike(const std::vector<std::string>& names) {
  std::vector<AlikeNames> alike;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = i + 1; j < names.size(); ++j) {
      const Likeness likeness = LikenessOf(names[i], names[j]);
      if (likeness != Likeness::kNone) alike.push_back({names[i], names[j], likeness});
    }
  }
  return alike;
}

}  // namespace haptometer::tools
