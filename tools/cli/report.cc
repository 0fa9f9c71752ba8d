#include "tools/cli/report.h"

#include <fmt/core.h>

#include <cstdio>

#include "base/printable.h"

namespace haptometer::cli {

int ReportError(std::string_view verb, const Error& error) {
  const std::string_view blank = verb.empty() ? "" : " ";
  fmt::print(stderr, "haptometer{}{}: {}\n", blank, verb, error.Text());
  return ExitStatus(error.cause);
}

int WorseStatus(int a, int b) {
  const auto rank = [](int status) {
    if (status == 0) return 0;
    return status <= ExitStatus(Cause::kCannotAnswer) ? 4 - status : 4;
  };
  return rank(b) > rank(a) ? b : a;
}

void Print(std::string_view text) { fmt::print("{}", PrintableLines(text)); }

void Remark(std::string_view verb, std::string_view text) {
  fmt::print(stderr, "{}: {}\n", verb, Printable(text));
}

}  // namespace haptometer::cli
