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

// the no-break space, in UTF-8
constexpr std::string_view kNoBreakSpace = "\u00a0";

// without case, blanks and the zeros in front of numbers
std::string Folded(std::string_view name) {
  std::string folded;
  for (std::size_t at = 0; at < name.size(); ++at) {
    const bool follows_digit = !folded.empty() && IsDigit(folded.back());
    const bool leads = at + 1 < name.size() && IsDigit(name[at + 1]);
    if (name.substr(at).starts_with(kNoBreakSpace)) {
      ++at;
      continue;
    }
    if (name[at] == ' ' || (name[at] == '0' && leads && !follows_digit)) continue;
    folded += Lower(name[at]);
  }
  return folded;
}

// the letters of U+00C0 to U+017F without case and accent; a blank: not one of a to z
constexpr std::string_view kPlainLetters =
    "aaaaaa ceeeeiiii nooooo ouuuuy  aaaaaa ceeeeiiii nooooo ouuuuy y"
    "aaaaaaccccccccddddeeeeeeeeeegggggggghhhhiiiiiiiiii  jjkk llllll "
    " llnnnnnn   oooooo  rrrrrrsssssssstttt  uuuuuuuuuuuuwwyyyzzzzzz ";
static_assert(kPlainLetters.size() == 0x180 - 0xC0);

// the letters of Latin scripts without accents, whether these are part of a letter or follow it
std::string WithoutAccents(std::string_view name) {
  std::string plain;
  for (std::size_t at = 0; at < name.size(); ++at) {
    const auto byte = static_cast<unsigned char>(name[at]);
    // U+0080 to U+07FF is two bytes
    if ((byte & 0xE0U) != 0xC0U || at + 1 == name.size()) {
      plain += name[at];
      continue;
    }
    const unsigned code = (byte & 0x1FU) << 6U | (static_cast<unsigned char>(name[at + 1]) & 0x3FU);
    const bool is_mark = code >= 0x300 && code < 0x370;
    const char letter = code >= 0xC0 && code < 0x180 ? kPlainLetters[code - 0xC0] : ' ';
    if (letter != ' ') plain += letter;
    if (letter == ' ' && !is_mark) plain += name.substr(at, 2);
    ++at;
  }
  return plain;
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
  switch (likeness) {
    case Likeness::kSpelling:
      return "case, blanks or zeros in front";
    case Likeness::kAccents:
      return "case, accents or their encoding";
    case Likeness::kOneLetter:
      return "one letter";
    case Likeness::kNone:
      break;
  }
  return {};
}

Likeness LikenessOf(std::string_view one, std::string_view other) {
  if (one == other) return Likeness::kNone;
  if (Folded(one) == Folded(other)) return Likeness::kSpelling;
  if (Folded(WithoutAccents(one)) == Folded(WithoutAccents(other))) return Likeness::kAccents;
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
