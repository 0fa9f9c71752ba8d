#pragma once

#include <fmt/core.h>

#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/clock.h"
#include "base/error.h"

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

/// A file that exists in memory only, as long as this object does.
class MemoryFile {
 public:
  /// With `content`, at its start.
  explicit MemoryFile(std::string_view content = {});
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Under which a program that we start can open it.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] std::string Content() const;

 private:
  int descriptor_;
};

/// Runs a program with `input` on its standard input and nothing else, and waits for its end: at
/// most `longest_ns`, then it is killed. Returns whether it ended with status 0. Of `words` the
/// first is the program, looked for in PATH. Errors (Cause::kFailed, without a place): it is not
/// installed, does not start, or did not end in time.
[[nodiscard]] Result<bool> RunWithin(const std::vector<std::string>& words,
                                     const std::string& input, MonotonicNs longest_ns);

}  // namespace haptometer::plot
