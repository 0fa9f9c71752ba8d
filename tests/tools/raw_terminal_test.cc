#include "tools/cli/raw_terminal.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace haptometer::cli {
namespace {

using enum Key::Kind;

// the keys of a text that is whole, as kinds and characters
std::vector<Key> Keys(std::string bytes) {
  auto keys = TakeKeys(bytes, true);
  EXPECT_EQ(bytes, "");
  return keys;
}

TEST(RawTerminal, KeysAreCharactersAndAFewOthers) {
  EXPECT_EQ(Keys("a \r\n\x7f\b\x03"), (std::vector<Key>{{kText, "a"},
                                                        {kText, " "},
                                                        {kEnter},
                                                        {kEnter},
                                                        {kBackspace},
                                                        {kBackspace},
                                                        {kInterrupt}}));
  EXPECT_EQ(Keys("\u00fc\u20ac"), (std::vector<Key>{{kText, "\u00fc"}, {kText, "\u20ac"}}));
  // other control characters, and bytes that are no UTF-8
  EXPECT_EQ(Keys("\t\x01\x1a\xff\xc3"), std::vector<Key>{});
}

TEST(RawTerminal, SequencesOfKeysWithoutAUseAreNone) {
  EXPECT_EQ(Keys("\x1b[A\x1b[1;5C\x1bOP\x1b[15~q"), (std::vector<Key>{{kText, "q"}}));
  EXPECT_EQ(Keys("\x1b"), (std::vector<Key>{{kEscape}}));
  EXPECT_EQ(Keys("\x1bq"), std::vector<Key>{}) << "Alt and q";
}

TEST(RawTerminal, WhatMayBeTheBeginningOfASequenceWaits) {
  for (const std::string begin : {"\x1b", "\x1b[", "\x1b[1;", "\xe2\x82"}) {
    std::string bytes = "a" + begin;
    EXPECT_EQ(TakeKeys(bytes, false), (std::vector<Key>{{kText, "a"}}));
    EXPECT_EQ(bytes, begin);
  }
  std::string bytes = "\x1b[";
  bytes += "Bx";
  EXPECT_EQ(TakeKeys(bytes, false), (std::vector<Key>{{kText, "x"}}));
}

TEST(RawTerminal, LinesAreBrokenAtBlanks) {
  using Rows = std::vector<std::string>;
  EXPECT_EQ(WrappedTo("", 5), Rows{""});
  EXPECT_EQ(WrappedTo("ab cd", 5), Rows{"ab cd"});
  EXPECT_EQ(WrappedTo("ab cd ef", 5), (Rows{"ab", "cd ef"}));
  EXPECT_EQ(WrappedTo("abcdefg", 3), (Rows{"abc", "def", "g"}));
  EXPECT_EQ(WrappedTo("   abcdef", 5), (Rows{"   ab", "cdef"}));
  EXPECT_EQ(WrappedTo("\u00fc\u00fc\u00fc", 2), (Rows{"\u00fc\u00fc", "\u00fc"}));
}

}  // namespace
}  // namespace haptometer::cli
