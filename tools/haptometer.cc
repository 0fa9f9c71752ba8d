// The program: finds the verb and runs it. It is called as `haptometer VERB ...`, or by the
// verb's own name (acquire, analyze, fit-lra).
#include <fmt/core.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr int kHeapBytes = 64 << 20;
constexpr int kPresentBytes = 3 << 20;

// verbs that consist of parts, each with options of its own
struct Part {
  std::string_view verb;
  const char* name;
};
constexpr auto kParts = std::to_array<Part>(
    {{"session", "new"},    {"session", "run"},     {"session", "next"},    {"session", "redo"},
     {"session", "reject"}, {"session", "accept"},  {"session", "relabel"}, {"session", "floor"},
     {"session", "note"},   {"session", "skip"},    {"session", "status"},  {"session", "pack"},
     {"session", "verify"}, {"trial", "info"},      {"trial", "label"},     {"trial", "exclude"},
     {"trial", "include"},  {"trial", "plot"},      {"trial", "export"},    {"study", "compare"},
     {"study", "matching"}, {"study", "linearity"}, {"campaign", "plan"},   {"campaign", "run"},
     {"campaign", "merge"}, {"campaign", "status"}, {"campaign", "resume"}});
// verbs without options of their own
constexpr std::array<std::string_view, 3> kOnlyParts{"session", "trial", "campaign"};

const Verb* Find(std::string_view name) {
  const auto found = std::ranges::find(Verbs(), name, &Verb::name);
  return found == Verbs().end() ? nullptr : &*found;
}

void PrintHelp() {
  fmt::print("haptometer {}: vibration of tactile actuators by laser\n\nVerbs:\n",
             HAPTOMETER_VERSION);
  for (const Verb& verb : Verbs()) fmt::print("  {:<14} {}\n", verb.name, verb.summary);
  fmt::print("\nhaptometer help VERB shows a verb's options with examples.\n");
}

Error UnknownVerb(std::string_view word) {
  const std::string nearest = Nearest(word, Mapped<std::string>(Verbs(), &Verb::name));
  return {Cause::kUsage, std::string(word), "is not a verb",
          nearest.empty() ? "see haptometer --help" : fmt::format("did you mean {}?", nearest)};
}

// what is wrong with the words behind the verb of `haptometer help VERB PART`
std::optional<Error> WrongBehind(const Verb& verb, std::span<const char* const> words) {
  if (words.empty()) return std::nullopt;
  const std::string word = words.front();
  std::vector<std::string> parts;
  for (const Part& part : kParts) {
    if (part.verb == verb.name) parts.emplace_back(part.name);
  }
  if (std::ranges::find(parts, word) == parts.end()) {
    const std::string nearest = Nearest(word, parts);
    return Error{Cause::kUsage, word, fmt::format("is not a part of {}", verb.name),
                 nearest.empty() ? fmt::format("see haptometer help {}", verb.name)
                                 : fmt::format("did you mean {} {}?", verb.name, nearest)};
  }
  if (words.size() == 1) return std::nullopt;
  return Error{Cause::kUsage, words[1], "is one word too many",
               fmt::format("write haptometer help {} {}", verb.name, word)};
}

// `haptometer help trial info` is `haptometer trial info --help`.
int HelpOf(std::span<const char* const> names) {
  const std::string_view first = names.front();
  if (first == "help" && names.size() == 1) {
    PrintHelp();
    return 0;
  }
  if (first.starts_with("-")) {
    return cli::ReportError("", {Cause::kUsage, std::string(first),
                                 "is an option, and help takes a verb", "see haptometer help"});
  }
  const Verb* verb = Find(first);
  if (verb == nullptr) return cli::ReportError("", UnknownVerb(first));
  if (const auto error = WrongBehind(*verb, names.subspan(1))) {
    return cli::ReportError("", *error);
  }
  std::vector<const char*> words(names.begin(), names.end());
  words.push_back("--help");
  return verb->run(static_cast<int>(words.size()), words.data());
}

// A verb of parts alone: its name and summary.
int DescribeSummary(const Verb& verb) {
  const std::string name(verb.name);
  const std::array<const char*, 2> words{name.c_str(), "--describe-options"};
  cli::Options options({.name = verb.name, .summary = verb.summary, .examples = {}});
  return options.Parse(static_cast<int>(words.size()), words.data()).value_or(0);
}

// All options of all verbs as one JSON list; hidden, because it is for pages, tests and packages.
int DescribeOptions() {
  int status = 0;
  std::string_view before = "[\n";
  const auto describe = [&](const Verb& verb, std::vector<const char*> words) {
    cli::Print(before);
    before = ",\n";
    if (words.empty() && std::ranges::count(kOnlyParts, verb.name) > 0) {
      status = cli::WorseStatus(status, DescribeSummary(verb));
      return;
    }
    words.insert(words.begin(), verb.name.data());
    words.push_back("--describe-options");
    status = cli::WorseStatus(status, verb.run(static_cast<int>(words.size()), words.data()));
  };
  for (const Verb& verb : Verbs()) {
    describe(verb, {});
    for (const Part& part : kParts) {
      if (part.verb == verb.name) describe(verb, {part.name});
    }
  }
  cli::Print("]\n");
  return status;
}

// Has pages come seldom and many at a time: the system takes 0.3 us for the first use of a page, a
// virtual machine up to 12 us, which was a quarter of the time of a short trial and of a long one.
void PrepareHeap() {
  // all memory of the main thread up to 32 MB comes from one heap, which keeps it; other threads
  // have heaps beside it, as many as there are cores: with one for all two threads of a sweep are
  // hardly faster than one
  mallopt(M_ARENA_MAX, static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 2 * kHeapBytes);
  mallopt(M_TOP_PAD, kHeapBytes);
  // a block that does not fit extends the heap, of which only used pages take memory
  void* const block = std::malloc(kPresentBytes);
  void* begin = block;
  std::size_t bytes = kHeapBytes;
  std::align(static_cast<std::size_t>(sysconf(_SC_PAGESIZE)), kPresentBytes, begin, bytes);
  // what a short trial takes at once, what a long one takes in large pages; advice that may fail
  (void)madvise(begin, kPresentBytes, MADV_POPULATE_WRITE);
  (void)madvise(static_cast<char*>(begin) + kPresentBytes, kHeapBytes - 2 * kPresentBytes,
                MADV_HUGEPAGE);
  std::free(block);
}

int Start(const Verb& verb, int argc, const char* const* argv) {
  PrepareHeap();
  return verb.run(argc, argv);
}

int Run(int argc, const char* const* argv) {
  const std::string_view path = argv[0];
  // a link named after a verb starts that verb
  if (const Verb* own = Find(path.substr(path.rfind('/') + 1))) return Start(*own, argc, argv);
  const std::string_view word = argc > 1 ? argv[1] : "--help";
  if (word == "help" && argc > 2) return HelpOf({argv + 2, argv + argc});
  // help on request has status 0; without a word it is a usage error
  if (word == "--help" || word == "-h" || word == "help") {
    PrintHelp();
    return argc > 1 ? 0 : 2;
  }
  if (word == "--version") {
    fmt::print("haptometer {}\n", HAPTOMETER_VERSION);
    return 0;
  }
  if (word == "--describe-options") return DescribeOptions();
  if (const Verb* verb = Find(word)) return Start(*verb, argc - 1, argv + 1);
  return cli::ReportError("", UnknownVerb(word));
}

}  // namespace
}  // namespace haptometer::tools

int main(int argc, char** argv) {
  using haptometer::cli::StatusWithOutput;
  haptometer::cli::HoldStandardStreams();
  // a limit on files (ulimit -f) is an error of the write, as a full disk is
  std::signal(SIGXFSZ, SIG_IGN);
  // No code of this program throws but where it is interrupted. Exceptions come from libraries
  // (memory exhausted) and from fmt, whose print fails where standard output fails.
  try {
    return StatusWithOutput(haptometer::tools::Run(argc, argv));
  } catch (const haptometer::cli::Interruption&) {
    return StatusWithOutput(haptometer::cli::InterruptedStatus(0));
  } catch (const std::exception& error) {
    const auto* const failed = dynamic_cast<const std::system_error*>(&error);
    if (std::ferror(stdout) != 0) {
      // a closed terminal has ended the run before its output fails
      return StatusWithOutput(haptometer::cli::InterruptedStatus(0),
                              failed ? failed->code().value() : 0);
    }
    haptometer::cli::Remark("haptometer", fmt::format("stopped: {}", error.what()));
    return 1;
  }
}
