#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tools/document/document.h"
#include "tools/session/attempt.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_plan.h"

/// What the words of `session` answer with (docs/reference/session.md).
namespace haptometer::tools {

/// What is done, what comes next, and all attempts. `found`: of CompareWithLog(), where it was
/// asked; trials that are missing or damaged do not count.
[[nodiscard]] document::Document StatusDocument(std::string_view verb, const SessionFolder& session,
                                                const Findings<FolderFinding>& found = {});

/// The verdict on an attempt, and what comes next.
[[nodiscard]] document::Document AttemptDocument(std::string_view verb,
                                                 const SessionFolder& session,
                                                 const AttemptOutcome& outcome);

/// What a new plan amounts to, and what should be known of it before the first trial. `spread`: the
/// relative standard deviation of the subjects' differences, where it is stated.
[[nodiscard]] document::Document PlanDocument(const std::string& folder, const SessionPlan& plan,
                                              std::optional<double> spread);

}  // namespace haptometer::tools
