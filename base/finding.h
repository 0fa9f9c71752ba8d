#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace haptometer {

/// What a finding means for the answer.
enum class Severity : std::uint8_t {
  kRefusal,  ///< why there is no answer
  kDoubt,    ///< why an answer may be wrong
  kNote,     ///< what was assumed, left out or corrected
};

/// "refusal", "doubt", "note".
[[nodiscard]] constexpr std::string_view NameOf(Severity severity) {
  if (severity == Severity::kRefusal) return "refusal";
  return severity == Severity::kDoubt ? "doubt" : "note";
}

/// A number or name that a finding rests on. A number is in SI units and its name ends with the
/// unit ("needed_hz"), as the keys of results do; a count or a share has no ending.
struct FindingNumber {
  std::string_view name;
  std::variant<std::int64_t, double, std::string> value;

  FindingNumber(std::string_view of, double number) : name(of), value(number) {}
  FindingNumber(std::string_view of, std::integral auto count)
      : name(of), value(static_cast<std::int64_t>(count)) {}
  FindingNumber(std::string_view of, std::string text) : name(of), value(std::move(text)) {}
};

/// A finding of one room: its kind by the room's enum, without words. The sentence of each kind
/// stands in tools.
template <typename Kind>
struct FindingOf {
  Severity severity = Severity::kNote;
  Kind kind{};
  std::vector<FindingNumber> numbers{};
  std::string subject{};  ///< the file, channel or record that it is of; empty: the whole
};

/// Findings in the order in which they were made.
template <typename Kind>
class Findings {
 public:
  void Add(FindingOf<Kind> finding) { list_.push_back(std::move(finding)); }
  void Append(const Findings& others) {
    list_.insert(list_.end(), others.list_.begin(), others.list_.end());
  }
  void Refuse(Kind kind, std::initializer_list<FindingNumber> numbers = {}) {
    Add({Severity::kRefusal, kind, numbers});
  }
  void Doubt(Kind kind, std::initializer_list<FindingNumber> numbers = {}) {
    Add({Severity::kDoubt, kind, numbers});
  }
  void Note(Kind kind, std::initializer_list<FindingNumber> numbers = {}) {
    Add({Severity::kNote, kind, numbers});
  }

  [[nodiscard]] const std::vector<FindingOf<Kind>>& list() const { return list_; }
  [[nodiscard]] bool Has(Kind kind) const {
    return std::ranges::find(list_, kind, &FindingOf<Kind>::kind) != list_.end();
  }

 private:
  std::vector<FindingOf<Kind>> list_;
};

}  // namespace haptometer
