#pragma once

#include <fmt/core.h>

#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>

/// A script for gnuplot, which anybody's text can enter in one way only: as a Quoted.
///
/// gnuplot executes what it is given, so a title that ends its quote is a command. The types here
/// make that impossible: a Script takes words that are known when this program is compiled, numbers
/// and Quoted texts, and neither a std::string nor a std::string_view.
namespace haptometer::plot {

/// Words of gnuplot's language; only a literal of this program makes them.
class Words {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): a literal stands for itself
  consteval Words(const char* literal) : text_(literal) {}
  [[nodiscard]] constexpr std::string_view text() const { return text_; }

 private:
  std::string_view text_;
};

/// Any text as one word of a script that shows it as it is.
///
/// What is not printable is escaped (base/text.h), so that there is no line end in it; it
/// stands in single quotes, in which gnuplot replaces nothing (no backquote, no backslash, no
/// macro); a quote in it is added from double quotes, which hold nothing else. Of more than 1000
/// characters the first are shown.
class Quoted {
 public:
  explicit Quoted(std::string_view text);
  /// The name of a tick, which gnuplot takes for a format where there is a percent sign in it, and
  /// then writes into 50 bytes: of a longer one the beginning is shown.
  [[nodiscard]] static Quoted TickName(std::string_view text);

  [[nodiscard]] std::string_view word() const { return word_; }

 private:
  std::string word_;
};

template <typename T>
concept ScriptArgument = std::same_as<T, Words> || std::same_as<T, Quoted> ||
                         (std::is_arithmetic_v<T> && !std::same_as<T, char>);

class Script {
 public:
  /// Adds `words`, in which the arguments stand at `{}` as fmt writes them.
  template <ScriptArgument... Arguments>
  void Add(Words words, const Arguments&... arguments) {
    text_ += fmt::format(fmt::runtime(words.text()), Shown(arguments)...);
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  static std::string_view Shown(const Words& words) { return words.text(); }
  static std::string_view Shown(const Quoted& quoted) { return quoted.word(); }
  template <typename Number>
    requires std::is_arithmetic_v<Number>
  static Number Shown(const Number& number) {
    return number;
  }

  std::string text_;
};

}  // namespace haptometer::plot
