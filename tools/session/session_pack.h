#pragma once

#include "tools/cli/options.h"

namespace haptometer::tools {

inline constexpr cli::VerbText kSessionPackText{
    .name = "session pack",
    .summary = "Pack a session with the results of its study and all hashes into one archive.",
    .examples = {"haptometer session pack day1 -o day1.zip", "haptometer session verify day1.zip",
                 "haptometer session pack day1 -o day1.zip --json"}};

inline constexpr cli::VerbText kSessionVerifyText{
    .name = "session verify",
    .summary = "Name each byte of an archive that has changed, and compute its study again.",
    .examples = {"haptometer session verify day1.zip", "haptometer session verify day1.zip --json",
                 "haptometer session pack day1 -o day1.zip"}};

/// `session pack` and `session verify`; argv[0] is the word. The return value is the program's exit
/// status.
int RunSessionPack(int argc, const char* const* argv);
int RunSessionVerify(int argc, const char* const* argv);

}  // namespace haptometer::tools
