#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/document/document.h"

namespace haptometer::tools {

/// What a verb answers to another program.
struct VerbAnswer {
  int status = 0;        ///< as the command's (docs/reference/common.md)
  std::string output{};  ///< what the command prints
  std::string errors{};  ///< and on standard error
  std::optional<document::Document> document{};
};

/// Does what `haptometer WORDS...` does, within the calling program: no process is started, nothing
/// is printed, and no signal is caught. `words` begin with the verb; `has_figures`: the document
/// has its figures, which cost time to compute.
///
/// Calls wait for each other: one verb runs at a time, on the caller's thread and on those that it
/// starts; `begins` is called when it is this one's turn. Memory exhausted is an error of the verb,
/// status 1.
[[nodiscard]] VerbAnswer CallVerb(
    const std::vector<std::string>& words, bool has_figures,
    const std::function<void()>& begins = [] {});

/// Does `work` while no verb runs: files that it reads are no inputs of a verb.
void BesideVerbs(const std::function<void()>& work);

/// Ends the verb that runs, as Ctrl-C does: at its next look at the signals. From any thread.
void InterruptVerb();

}  // namespace haptometer::tools
