#pragma once

#include "tools/cli/options.h"

namespace haptometer::tools {

inline constexpr cli::VerbText kSessionRunText{
    .name = "session run",
    .summary = "Record a session at a terminal: one key a trial, and its verdict on the screen.",
    .examples = {"haptometer session run day1", "haptometer session status day1",
                 "haptometer session next day1"}};

/// `session run`; argv[0] is the word. The return value is the program's exit status.
int RunSessionRun(int argc, const char* const* argv);

}  // namespace haptometer::tools
