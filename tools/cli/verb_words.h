#pragma once

#include <span>
#include <string_view>

namespace haptometer::cli {

/// One of the words of a verb that consists of parts, as `trial info`.
struct VerbWord {
  std::string_view name;
  int (*run)(int argc, const char* const* argv);  ///< argv[0] is the word
  std::string_view summary;
  std::string_view example;
};

/// Runs the word that argv[1] names; argv[0] is the verb. `--help` prints `summary` and the words,
/// with status 0; without a word the same is printed with status 2, and an unknown word is refused
/// with the nearest one. The return value is the program's exit status.
[[nodiscard]] int RunVerbWord(std::string_view verb, std::string_view summary,
                              std::span<const VerbWord> words, int argc, const char* const* argv);

}  // namespace haptometer::cli
