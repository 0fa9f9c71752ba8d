#include "tools/cli/verb_words.h"

#include <fmt/core.h>

#include <algorithm>
#include <string>

#include "base/error.h"
#include "base/mapped.h"
#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

void PrintHelp(std::string_view verb, std::string_view summary, std::span<const VerbWord> words) {
  const std::size_t width = std::ranges::max(words, {}, [](const VerbWord& word) {
                              return word.name.size();
                            }).name.size();
  Print(fmt::format("{}\n\n", summary));
  for (const VerbWord& word : words) {
    Print(fmt::format("  haptometer {} {:<{}} {}\n", verb, word.name, width + 1, word.summary));
  }
  Print("\nExamples:\n");
  for (const VerbWord& word : words) Print(fmt::format("  {}\n", word.example));
}

}  // namespace

int RunVerbWord(std::string_view verb, std::string_view summary, std::span<const VerbWord> words,
                int argc, const char* const* argv) {
  // without a word the help is printed, with status 2
  const std::string_view name = argc > 1 ? argv[1] : "--help";
  const auto word = std::ranges::find(words, name, &VerbWord::name);
  if (word != words.end()) return word->run(argc - 1, argv + 1);
  if (name == "--help" || name == "-h" || name == "--help-all") {
    PrintHelp(verb, summary, words);
    return argc > 1 ? 0 : 2;
  }
  // the most similar word, for typing errors
  const std::string nearest = Nearest(name, Mapped<std::string>(words, &VerbWord::name));
  return ReportError(
      verb, {Cause::kUsage, std::string(name), fmt::format("is not something {} can do", verb),
             nearest.empty() ? fmt::format("see haptometer {} --help", verb)
                             : fmt::format("did you mean {} {}?", verb, nearest)});
}

}  // namespace haptometer::cli
