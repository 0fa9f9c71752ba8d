// A command line that is printed can be pasted: the shell itself is the judge.
#include "tools/cli/command_line.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

namespace haptometer::cli {
namespace {

// the words that sh makes of `line`, each with a line's end
std::string WordsBySh(const std::string& line) {
  const std::string command = "for w in " + line + "; do printf '%s\\n' \"$w\"; done";
  std::FILE* shell = popen(command.c_str(), "r");
  std::string words;
  std::array<char, 256> part{};
  while (std::fgets(part.data(), part.size(), shell) != nullptr) words += part.data();
  EXPECT_EQ(pclose(shell), 0);
  return words;
}

TEST(CommandLine, OfPlainWordsIsWhatWasTyped) {
  EXPECT_EQ(CommandLine({"acquire", "--port", "/dev/ttyUSB0", "--format", "+00.0000,mm,CR"}),
            "acquire --port /dev/ttyUSB0 --format +00.0000,mm,CR");
  EXPECT_EQ(CommandLine({}), "");
}

TEST(CommandLine, IsTakenApartIntoTheSameWords) {
  const std::vector<std::string> words{
      "acquire", "--trigger", "rising 0.1mm", "",  "it's", "$HOME", "a;b", "*",
      "~",       "\"x\"",     "a\\b",         "#", "(",    "&&",    "''"};
  std::string expected;
  for (const std::string& word : words) expected += word + "\n";
  EXPECT_EQ(WordsBySh(CommandLine(words)), expected);
}

}  // namespace
}  // namespace haptometer::cli
