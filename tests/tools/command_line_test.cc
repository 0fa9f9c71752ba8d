// A command line that is printed can be pasted: the shell itself is the judge.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

// the words that a shell makes of `line`, each with a line's end
std::string WordsBy(const std::string& shell_name, const std::string& line) {
  setenv("LOOP", ("for w in " + line + "; do printf '%s\\n' \"$w\"; done").c_str(), 1);
  const std::string command = shell_name + " -c \"$LOOP\"";
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
  EXPECT_EQ(WordsBy("sh", CommandLine(words)), expected);
}

// the form is POSIX's since 2024, and dash does not have it yet
TEST(CommandLine, StaysOneLineWhateverTheWordsHold) {
  const std::vector<std::string> words{"a\nb", "\x1b[2J 'x'", "\xff.bin", "\u202e", "tab\t\\"};
  const std::string line = CommandLine(words);
  EXPECT_TRUE(IsPrintable(line)) << line;
  EXPECT_EQ(CommandLine({"a\nb"}), "$'a\\012b'");
  std::string expected;
  for (const std::string& word : words) expected += word + "\n";
  EXPECT_EQ(WordsBy("bash", line), expected);
}

}  // namespace
}  // namespace haptometer::cli
