#pragma once

#include <cstdint>

#include "base/finding.h"
#include "tools/document/document.h"
#include "tools/session/session_folder.h"

namespace haptometer::tools {

/// Where a trial of a session differs from the session's log, each of a file.
enum class HeaderFinding : std::uint8_t {
  kExcludedByUser,  ///< reason: by `trial exclude`; a study does not use it
  kOtherLabels,     ///< label, in_trial, in_log: by `trial label`
  kFileMissing,     ///< a finished attempt has no file, or none that can be read
};

/// The words of a kind.
[[nodiscard]] document::Sentence SentenceOf(HeaderFinding kind);

/// The differences of all finished attempts, in their order. Cost: reads the trials.
[[nodiscard]] Findings<HeaderFinding> CompareHeaders(const SessionFolder& session);

}  // namespace haptometer::tools
