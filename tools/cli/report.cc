#include "tools/cli/report.h"

#include <fmt/core.h>

#include <cstdio>

namespace haptometer::cli {

int ReportError(std::string_view verb, const Error& error) {
  fmt::print(stderr, "haptometer {}: {}\n", verb, error.Text());
  return ExitStatus(error.cause);
}

void Remark(std::string_view verb, std::string_view text) {
  fmt::print(stderr, "{}: {}\n", verb, text);
}

}  // namespace haptometer::cli
