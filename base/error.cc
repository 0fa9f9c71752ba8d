#include "base/error.h"

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "base/text.h"

namespace haptometer::internal {
namespace {

// a source file's place below the root of the sources, wherever they were built
const char* BelowRoot(const char* file) {
  std::string_view rest = file;
  constexpr std::string_view kRoot = HAPTOMETER_SOURCES;
  if (rest.starts_with(kRoot)) rest.remove_prefix(kRoot.size());
  // relative paths of a build directory begin with ../
  while (rest.starts_with("../")) rest.remove_prefix(3);
  return rest.data();
}

}  // namespace

void CheckFailed(const char* file, int line, const char* expression, const std::string& detail) {
  std::fprintf(stderr, "%s:%d: check failed: %s (%s)\n", BelowRoot(file), line, expression,
               Printable(detail).c_str());
  std::abort();
}

}  // namespace haptometer::internal

namespace haptometer {

std::string Error::Text() const {
  std::string text = where.empty() ? what : where + ": " + what;
  if (!remedy.empty()) text += "; " + remedy;
  return Printable(text);
}

// documented exit statuses: 1 failed, 2 wrong usage, 3 no answer
int ExitStatus(Cause cause) {
  switch (cause) {
    case Cause::kFailed:
      return 1;
    case Cause::kUsage:
      return 2;
    case Cause::kCannotAnswer:
      return 3;
  }
  return 1;
}

namespace {
std::unexpected<Error> Make(Cause cause, std::string where, std::string what, std::string remedy) {
  return std::unexpected(Error{cause, std::move(where), std::move(what), std::move(remedy)});
}
}  // namespace

std::unexpected<Error> Failed(std::string where, std::string what, std::string remedy) {
  return Make(Cause::kFailed, std::move(where), std::move(what), std::move(remedy));
}

std::unexpected<Error> Usage(std::string where, std::string what, std::string remedy) {
  return Make(Cause::kUsage, std::move(where), std::move(what), std::move(remedy));
}

std::unexpected<Error> CannotAnswer(std::string where, std::string what, std::string remedy) {
  return Make(Cause::kCannotAnswer, std::move(where), std::move(what), std::move(remedy));
}

}  // namespace haptometer
