#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer::cli {

/// A key of the terminal.
struct Key {
  enum class Kind : std::uint8_t { kText, kEnter, kBackspace, kEscape, kInterrupt };
  Kind kind = Kind::kText;
  std::string text{};  ///< kText: one printable character, UTF-8
  friend bool operator==(const Key&, const Key&) = default;
};

/// The keys that `bytes` begins with, which are removed from it. Keys without a use here (arrows,
/// function keys, other control characters) and bytes that are no UTF-8 give none. What may be the
/// beginning of a longer sequence stays in `bytes`, unless `is_all`: then an escape character alone
/// is the key Escape.
[[nodiscard]] std::vector<Key> TakeKeys(std::string& bytes, bool is_all);

/// Keys as they are typed, and a screen that is drawn as a whole: the terminal of standard input
/// and standard output, without echo and lines, on its alternate screen.
///
/// One at a time. The settings are restored by the destructor and by Restore(), and before the
/// process ends by SIGABRT, SIGBUS, SIGFPE, SIGILL or SIGSEGV. SIGINT, SIGTERM and SIGHUP set the
/// flag of Interrupted() (tools/cli/terminal.h), a second one too; Ctrl-C is a key.
class RawTerminal {
 public:
  /// Errors (Cause::kUsage): input or output is no terminal, or one that cannot place its cursor.
  [[nodiscard]] static Result<std::unique_ptr<RawTerminal>> Open();
  ~RawTerminal();
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;

  void Restore();

  /// The keys that were typed since the last call; waits for none, but up to 50 ms for the rest of
  /// a sequence. A terminal that was closed counts as SIGHUP.
  [[nodiscard]] std::vector<Key> Keys();

  /// Shows `lines` from the top, longer ones over several rows (WrappedTo), as many rows as fit.
  /// Every line is made printable (base/text.h).
  void Show(const std::vector<std::string>& lines);

  void Bell();

 private:
  RawTerminal() = default;
  void Write(std::string_view bytes);

  std::string typed_;  // bytes of a key that is not whole
  std::string shown_;  // what is on the screen
};

/// `line` in rows of at most `columns` (above 0) characters, broken at blanks where there are some.
[[nodiscard]] std::vector<std::string> WrappedTo(std::string_view line, std::size_t columns);

}  // namespace haptometer::cli
