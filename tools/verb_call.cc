#include "tools/verb_call.h"

#include <fmt/core.h>

#include <algorithm>
#include <csignal>
#include <exception>
#include <mutex>
#include <utility>

#include "base/input_file.h"
#include "base/mapped.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

// one verb at a time: what it prints, its inputs and interruptions are the process's
std::mutex running;

int Run(const std::vector<std::string>& words) {
  const auto verb = std::ranges::find(Verbs(), words.front(), &Verb::name);
  if (verb == Verbs().end()) {
    return cli::ReportError("", {Cause::kUsage, words.front(), "is not a verb", {}});
  }
  const auto arguments =
      Mapped<const char*>(words, [](const std::string& word) { return word.c_str(); });
  try {
    return verb->run(static_cast<int>(arguments.size()), arguments.data());
  } catch (const cli::Interruption&) {
    return cli::InterruptedStatus(0);
  } catch (const std::exception& error) {
    cli::Remark("haptometer", fmt::format("stopped: {}", error.what()));
    return ExitStatus(Cause::kFailed);
  }
}

}  // namespace

VerbAnswer CallVerb(const std::vector<std::string>& words, bool has_figures,
                    const std::function<void()>& begins) {
  HAPTOMETER_CHECK(!words.empty(), "no verb");
  const std::scoped_lock lock(running);
  ForgetInputs();
  cli::WithinProgram printed;
  begins();
  document::Receiver receiver(has_figures);
  VerbAnswer answer;
  answer.status = Run(words);
  answer.output = printed.output();
  answer.errors = printed.errors();
  answer.document = std::move(receiver).document();
  return answer;
}

void BesideVerbs(const std::function<void()>& work) {
  const std::scoped_lock lock(running);
  ForgetInputs();
  work();
}

void InterruptVerb() { cli::InterruptAsBy(SIGINT); }

}  // namespace haptometer::tools
