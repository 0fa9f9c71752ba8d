#pragma once

#include <atomic>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer::cli {

/// The text of an error of a lower room with its settings as options: "<columns>" is "--columns",
/// or behind another word than the dashes.
[[nodiscard]] std::string WithOptions(std::string_view text, std::string_view before = "--");

/// Prints "haptometer VERB: TEXT" (WithOptions) on stderr, in one line, and returns the exit status
/// of its cause. Without a verb: "haptometer: TEXT".
[[nodiscard]] int ReportError(std::string_view verb, const Error& error);

/// The exit status of two answers of which one program speaks: 1 (it failed) before 2 (asked
/// wrongly) before 3 (not answered) before 0. Any other status, an interruption, comes before all.
[[nodiscard]] int WorseStatus(int a, int b);

/// Reports each error. Returns the worst of their statuses, 0 of none.
[[nodiscard]] int ReportErrors(std::string_view verb, const std::vector<Error>& errors);

/// Keeps the numbers of standard input, output and error from files that are opened later, where a
/// caller closed them: written to, they fail.
void HoldStandardStreams();

/// The status that stands for a standard output that nobody reads any more, as after SIGPIPE.
inline constexpr int kUnreadStatus = 141;

/// Whether standard output is a pipe whose reader went away.
[[nodiscard]] bool IsUnread();

/// Standard output, flushed and looked at: what a verb leaves with instead of `status`. 1 with an
/// error on stderr where not all of it could be written; 141 without a word where its reader went
/// away and SIGPIPE, which ends a program before that, is ignored. `failure`: the errno of a write
/// that failed, where it is known.
[[nodiscard]] int StatusWithOutput(int status, int failure = 0);

/// A result on stdout. All of a verb's text and JSON goes this way, so that no control character
/// but line ends and tabs reaches a terminal; a name or a path in a line is made one line where the
/// line is made (base/text.h).
void Print(std::string_view text);

/// Text as it is on stderr. Where it cannot be written (a closed terminal) nobody reads it: no
/// error.
void PrintError(const std::string& text);

/// A remark on stderr, in one printable line: "VERB: TEXT".
void Remark(std::string_view verb, std::string_view text);

/// While one lives, a verb runs within another program (tools/verb_call.h): what is printed is
/// kept, no signal is caught, and no interruption has come yet. One at a time; not for threads.
class WithinProgram {
 public:
  WithinProgram();
  ~WithinProgram();
  WithinProgram(const WithinProgram&) = delete;
  WithinProgram& operator=(const WithinProgram&) = delete;

  [[nodiscard]] const std::string& output() const { return output_; }  ///< of Print()
  [[nodiscard]] const std::string& errors() const { return errors_; }  ///< of PrintError()

 private:
  friend void Print(std::string_view text);
  friend void PrintError(const std::string& text);
  std::string output_;
  std::string errors_;
};

[[nodiscard]] bool IsWithinProgram();

/// What leaves long work that is interrupted: where ending the process is not ours to do (within
/// another program), or where something half made is to be removed first. Caught by the program.
struct Interruption : std::exception {};

/// Throws Interruption where Interrupted(). On the verb's own thread only.
void LeaveIfInterrupted();

/// From now on SIGINT, SIGTERM and SIGHUP (a closed terminal) only set a flag, so that a verb can
/// finish its file. A second SIGINT or SIGTERM that comes 0.3 s after the first or later ends the
/// program at once; a second SIGHUP never does. SIGPIPE is ignored. Nothing of this within another
/// program.
void CatchInterrupts();

/// As if `signal` had come and been caught, where none has: for an output that nobody reads any
/// more (SIGPIPE).
void InterruptAsBy(int signal);

/// Set to true by the first signal; a recorder polls it.
[[nodiscard]] const std::atomic<bool>& Interrupted();

/// 130 after SIGINT, 143 after SIGTERM, 129 after SIGHUP, 141 for SIGPIPE, `otherwise` when no
/// signal came.
[[nodiscard]] int InterruptedStatus(int otherwise);

/// `words` as one line that a POSIX shell takes apart into the same words: what is not plain stands
/// in single quotes, and a word that is not printable (base/text.h) in $'...' with octal
/// escapes (POSIX.1-2024, 2.2.4), so the line is printable always.
[[nodiscard]] std::string CommandLine(const std::vector<std::string>& words);

}  // namespace haptometer::cli
