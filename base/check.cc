#include "base/check.h"

#include <cstdio>
#include <cstdlib>

#include "base/printable.h"

namespace haptometer::internal {

void CheckFailed(const char* file, int line, const char* expression, const std::string& detail) {
  std::fprintf(stderr, "%s:%d: check failed: %s (%s)\n", file, line, expression,
               Printable(detail).c_str());
  std::abort();
}

}  // namespace haptometer::internal
