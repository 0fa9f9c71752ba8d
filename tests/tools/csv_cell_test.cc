// Text in cells: what a spreadsheet would calculate stands there as text, and comes back as it was.
// The signs are those of the OWASP page on CSV injection.
#include "tools/cli/csv_cell.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace haptometer::cli {
namespace {

using Cells = std::vector<std::string>;

TEST(CsvCell, PlainTextAndNumbersStayAsTheyAre) {
  for (const char* const text : {"", "stock", "s 10", "it's", "'quoted'", "-5", "+3", "-1.5e-3",
                                 "+2.25", "3-4", "a=b", "50 %", "µm", "x@y"}) {
    EXPECT_EQ(CellOf(text), text);
    EXPECT_EQ(CellsOf(CellOf(text)), Cells{text});
  }
}

TEST(CsvCell, NoTextBeginsLikeAFormula) {
  for (const char* const text : {"=1+1", "=cmd|' /C calc'!A0", "+A1", "-2+3", "@SUM(A1)", "-5 dB",
                                 "＝1", "＋A1", "－1", "＠x", "'=1", "''-x", "'-5"}) {
    const std::string cell = CellOf(text);
    EXPECT_TRUE(cell.starts_with('\'')) << cell;
    EXPECT_EQ(CellsOf(cell), Cells{text});
  }
  EXPECT_EQ(CellOf("=HYPERLINK(\"http://x\",\"y\")"),
            "\"'=HYPERLINK(\"\"http://x\"\",\"\"y\"\")\"");
  // a spreadsheet that separates by semicolons must not find a cell within
  EXPECT_EQ(CellOf("a;=1+1"), "\"a;=1+1\"");
}

TEST(CsvCell, WhatIsNotPrintableIsEscaped) {
  EXPECT_EQ(CellOf("a\nb,c"), "\"a\\nb,c\"");
  EXPECT_EQ(CellOf("\t=1"), "\\t=1");
  EXPECT_EQ(CellOf("\r=1"), "\\r=1");
}

TEST(CsvCell, ALineIsSplitOutsideOfQuotes) {
  EXPECT_EQ(CellsOf("a,b,,c"), (Cells{"a", "b", "", "c"}));
  EXPECT_EQ(CellsOf(""), Cells{""});
  EXPECT_EQ(CellsOf(" a , \"b, c\" ,\" d \",\"e\"\"f\"\r"), (Cells{"a", "b, c", " d ", "e\"f"}));
  EXPECT_EQ(CellsOf("\"\",\" \""), (Cells{"", " "}));
}

// the invariant: every printable text comes back, whatever it is made of
TEST(CsvCell, EveryTextComesBack) {
  std::mt19937 engine(20);
  const std::string_view letters = "'=+-@,;\" a1.";
  std::uniform_int_distribution<std::size_t> any(0, letters.size() - 1);
  for (int n = 0; n < 20000; ++n) {
    std::string a;
    std::string b;
    for (int i = 0; i < n % 7; ++i) a += letters[any(engine)];
    for (int i = 0; i < n % 5; ++i) b += letters[any(engine)];
    EXPECT_EQ(CellsOf(CellOf(a) + "," + CellOf(b)), (Cells{a, b})) << a << " and " << b;
  }
}

}  // namespace
}  // namespace haptometer::cli
