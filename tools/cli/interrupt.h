#pragma once

#include <atomic>

namespace haptometer::cli {

/// From now on SIGINT, SIGTERM and SIGHUP (a closed terminal) only set a flag, so that a verb can finish its file; a second
/// signal of the same kind ends the program at once. SIGPIPE is ignored.
void CatchInterrupts();

/// Set to true by the first signal; a recorder polls it.
[[nodiscard]] const std::atomic<bool>& Interrupted();

/// 130 after SIGINT, 143 after SIGTERM, 129 after SIGHUP, `otherwise` when no signal came.
[[nodiscard]] int InterruptedStatus(int otherwise);

}  // namespace haptometer::cli
