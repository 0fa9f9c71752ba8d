#pragma once

#include <string>

#include "base/error.h"
#include "tools/fit/plan_drop_test.h"

namespace haptometer::tools {

/// The card for people, to be printed and taken to the bench.
[[nodiscard]] std::string TestCardText(const TestCard& card);

/// The same as one JSON document (docs/reference/fit-lra.md).
[[nodiscard]] std::string TestCardJson(const TestCard& card);

/// Why a wish is not reached and what would do it, as an error's `what` and `remedy`.
[[nodiscard]] Error UnreachedWish(const AnsweredWish& answered, const TestCard& card);

}  // namespace haptometer::tools
