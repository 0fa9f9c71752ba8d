#include "base/result.h"

#include <utility>

#include "base/printable.h"

namespace haptometer {

std::string Error::Text() const {
  std::string text = where.empty() ? what : where + ": " + what;
  if (!remedy.empty()) text += "; " + remedy;
  return Printable(text);
}

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
