#pragma once

#include "fit/findings.h"
#include "tools/document/document.h"

namespace haptometer::fit {

/// What the findings of fits say.
[[nodiscard]] document::Sentence SentenceOf(FindingKind kind);

}  // namespace haptometer::fit
