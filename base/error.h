#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <expected>
#include <string>
#include <utility>

namespace haptometer::internal {

/// Prints `FILE:LINE: check failed: EXPRESSION (DETAIL)` on stderr and aborts.
[[noreturn]] void CheckFailed(const char* file, int line, const char* expression,
                              const std::string& detail);

/// The same with the detail as a format and its values. Out of line and by value, so that a check
/// that holds costs a comparison: no text is made, and no number has to be in memory.
template <typename... Values>
[[noreturn, gnu::cold, gnu::noinline]] void CheckFailedWith(const char* file, int line,
                                                            const char* expression,
                                                            fmt::format_string<Values...> format,
                                                            Values... values) {
  CheckFailed(file, line, expression, fmt::vformat(format, fmt::make_format_args(values...)));
}

}  // namespace haptometer::internal

/// Guards against a programmer's error; always on. The further arguments are an fmt format and its
/// values, printed when the condition is false:
///   HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz);
/// Anything that a user, file or device can cause is a Result (base/error.h), never a check.
#define HAPTOMETER_CHECK(condition, ...)                                                    \
  do {                                                                                      \
    if (!(condition)) {                                                                     \
      ::haptometer::internal::CheckFailedWith(__FILE__, __LINE__, #condition, __VA_ARGS__); \
    }                                                                                       \
  } while (false)

namespace haptometer {

/// Whose doing an error is; decides the program's exit status.
enum class Cause : std::uint8_t {
  kFailed,        ///< the program could not finish what it had begun (disk full, lost device): 1
  kUsage,         ///< the question is put wrongly (option, unit, key of a file): 2
  kCannotAnswer,  ///< the file or device does not hold the answer, or is not there: 3
};

/// An error of the outside world in one sentence: what happened, where, and what to do next.
///
/// Text() joins the three as "WHERE: WHAT; REMEDY" in one printable line (base/text.h),
/// whatever a path or a cell in it holds. Programmers' errors abort (base/error.h); numerical
/// outcomes such as "did not converge" are fields of results, never an Error.
struct Error {
  Cause cause = Cause::kFailed;
  std::string where;   ///< file, port, option or key; empty when `what` says it
  std::string what;    ///< "is empty", "does not open: No such file or directory"
  std::string remedy;  ///< "give a trial.bin or a CSV with a header line"; may be empty

  [[nodiscard]] std::string Text() const;
};

/// The program's exit status for `cause`: 1, 2 or 3.
[[nodiscard]] int ExitStatus(Cause cause);

/// A value, or the error that stands in its place; functions that give one are [[nodiscard]].
/// g++ 12 has no and_then(): test, then use, or HAPTOMETER_TRY and HAPTOMETER_LET.
template <typename T>
using Result = std::expected<T, Error>;

/// Shorthands for the `return` of a function that gives a Result.
[[nodiscard]] std::unexpected<Error> Failed(std::string where, std::string what,
                                            std::string remedy = {});
[[nodiscard]] std::unexpected<Error> Usage(std::string where, std::string what,
                                           std::string remedy = {});
[[nodiscard]] std::unexpected<Error> CannotAnswer(std::string where, std::string what,
                                                  std::string remedy = {});

}  // namespace haptometer

/// In a function that gives a Result: returns the error of a Result, where it holds one.
///   HAPTOMETER_TRY(sink->Sync());
#define HAPTOMETER_TRY(...)                                                                   \
  do {                                                                                        \
    if (auto tried = (__VA_ARGS__); !tried) return std::unexpected(std::move(tried.error())); \
  } while (false)

/// The same; the value, where there is one, is put into what is declared or named:
///   HAPTOMETER_LET(const auto text, ReadInputFile(path));
#define HAPTOMETER_LET(declaration, ...) \
  HAPTOMETER_LET_BY(HAPTOMETER_JOINED(result_of_line_, __LINE__), declaration, __VA_ARGS__)
#define HAPTOMETER_LET_BY(result, declaration, ...)               \
  auto result = (__VA_ARGS__);                                    \
  if (!result) return std::unexpected(std::move(result.error())); \
  declaration = *std::move(result) /* NOLINT(bugprone-macro-parentheses): a declaration */
#define HAPTOMETER_JOINED(a, b) HAPTOMETER_JOINED_NOW(a, b)
#define HAPTOMETER_JOINED_NOW(a, b) a##b
