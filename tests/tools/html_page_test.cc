#include "tools/report/html_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace haptometer::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

plot::Panel Ramp() { return {"a ramp", "time / s", "distance / um", {{"", {}, {0, 1}, {0, 1}}}}; }

TEST(HtmlPage, WritesOutWhatMeansSomethingToHtml) {
  HtmlPage page("a<b", "x & \"y\"");
  page.Paragraph("<script>alert(1)</script>");
  page.Table({"key", "value"}, {{"<i>", "&amp;"}});
  const std::string html = page.Html();
  EXPECT_THAT(html, HasSubstr("<title>a&lt;b</title>"));
  EXPECT_THAT(html, HasSubstr("x &amp; &quot;y&quot;"));
  EXPECT_THAT(html, Not(HasSubstr("<script>")));
  EXPECT_THAT(html, HasSubstr("<th scope=\"row\">&lt;i&gt;</th><td>&amp;amp;</td>"));
}

TEST(HtmlPage, WhatIsNotPrintableIsEscaped) {
  HtmlPage page("latin\xe9\x1b.bin", "\xc3\xa9 \xc3");
  EXPECT_THAT(page.Html(), HasSubstr("<title>latin\\xe9\\x1b.bin</title>"));
  EXPECT_THAT(page.Html(), HasSubstr("\xc3\xa9 \\xc3</p>"));
}

TEST(HtmlPage, NumbersItsFiguresAndNeedsNothingFromElsewhere) {
  HtmlPage page("two", "");
  ASSERT_TRUE(page.Figure("first", {Ramp()}));
  ASSERT_TRUE(page.Figure("second", {Ramp()}));
  const std::string html = page.Html();
  EXPECT_THAT(html, HasSubstr("Figure 1. first"));
  EXPECT_THAT(html, HasSubstr("Figure 2. second"));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_THAT(html, Not(HasSubstr("<?xml")));
}

TEST(CheckReportPath, AsksForAPage) {
  EXPECT_FALSE(CheckReportPath("report.pdf"));
  EXPECT_FALSE(CheckReportPath("/no/such/directory/report.html"));
  EXPECT_TRUE(CheckReportPath(::testing::TempDir() + "/report.html"));
}

}  // namespace
}  // namespace haptometer::report
