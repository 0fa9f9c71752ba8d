#pragma once

#include "tools/document/document.h"
#include "tools/fit/plan_drop_test.h"

namespace haptometer::tools {

/// What the card's findings say.
[[nodiscard]] document::Sentence SentenceOf(PlanFinding kind);

/// The card as a document (docs/reference/plan-drop-test.md), to be printed and taken to the bench.
[[nodiscard]] document::Document PlanDocument(const TestCard& card);

}  // namespace haptometer::tools
