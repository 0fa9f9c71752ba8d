#include "tools/cli/report.h"

#include <fmt/core.h>

#include <cstdio>

namespace haptometer::cli {

int ReportError(std::string_view verb, const Error& error) {
  const std::string_view blank = verb.empty() ? "" : " ";
  fmt::print(stderr, "haptometer{}{}: {}\n", blank, verb, error.Text());
  return ExitStatus(error.cause);
}

void Remark(std::string_view verb, std::string_view text) {
  fmt::print(stderr, "{}: {}\n", verb, text);
}

}  // namespace haptometer::cli
