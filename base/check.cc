#include "base/check.h"

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "base/printable.h"

namespace haptometer::internal {
namespace {

// a source file's place below the root of the sources, wherever they were built
const char* BelowRoot(const char* file) {
  std::string_view rest = file;
  constexpr std::string_view kRoot = HAPTOMETER_SOURCES;
  if (rest.starts_with(kRoot)) rest.remove_prefix(kRoot.size());
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
