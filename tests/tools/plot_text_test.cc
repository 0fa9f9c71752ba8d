// Text in pictures: gnuplot never executes any of it, and shows it as it is. What could be executed
// makes a file; a well-formed picture is one that the parser of this machine's Python takes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "base/text.h"
#include "tests/temporary_files.h"
#include "tools/plot/gnuplot.h"
#include "tools/plot/script.h"

namespace haptometer::plot {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

template <typename T>
concept Addable = requires(Script script, const T& value) { script.Add("{}", value); };

// the mechanism itself: no text enters a script but as a Quoted
static_assert(!Addable<std::string> && !Addable<std::string_view> && !Addable<const char*> &&
              !Addable<char> && !Addable<char[4]>);
static_assert(Addable<Quoted> && Addable<double> && Addable<std::size_t> && Addable<Words>);

class PlotText : public tests::TemporaryFiles {
 protected:
  void SetUp() override {
    TemporaryFiles::SetUp();
    canary_ = directory_ / "canary";
  }

  // what would make the canary if a part of it were executed
  [[nodiscard]] std::vector<std::string> Hostile() const {
    const std::string touch = "touch " + canary_;
    return {"x\n!" + touch + "\n",
            "x'\n!" + touch + "\n'",
            "x\r!" + touch + "\r",
            "`" + touch + "`",
            "'; system('" + touch + "') #",
            "\"; system(\"" + touch + "\") #",
            "'",
            "''",
            "'.system('" + touch + "').'",
            "\\",
            "x\\\n!" + touch,
            "EOD\n!" + touch,
            "@GPVAL_TERM ^2 _{e} ~a{.8-} &{x} {/Symbol a}",
            "%s %d %n %%",
            "<script>alert(1)</script> & \"q\" ]]> <!-- -->",
            std::string("nul\0nul", 7) + "\x1b[2J\x9b\xff\u202e\u0085\ufffe"};
  }

  // every text of a panel is `text`
  [[nodiscard]] static Panel PanelOf(const std::string& text) {
    return {.title = text,
            .x_label = text,
            .y_label = text,
            .series = {{.title = text, .x = {1, 2, 3}, .y = {1, 3, 2}}},
            .ticks = {{1, text}, {2, text}, {3, "c"}}};
  }

  // the texts of an SVG, a line each; nothing where it is not well-formed
  [[nodiscard]] std::string TextsOf(const std::string& svg) const {
    const std::string out = directory_ / "texts";
    const std::string command =
        "python3 -c 'import sys, xml.etree.ElementTree as t\n"
        "for e in t.parse(sys.argv[1]).iter(): print(e.text or \"\")' '" +
        File("drawn.svg", svg) + "' > '" + out + "'";
    EXPECT_EQ(std::system(command.c_str()), 0) << svg;
    return Content("texts");
  }

  std::string canary_;
};

TEST_F(PlotText, NothingIsExecutedAndEverythingIsShown) {
  for (const std::string& text : Hostile()) {
    const auto svg = DrawSvg({PanelOf(text)});
    ASSERT_TRUE(svg) << Printable(text) << ": " << svg.error().Text();
    EXPECT_FALSE(std::filesystem::exists(canary_)) << Printable(text);
    EXPECT_THAT(TextsOf(*svg), HasSubstr(Printable(text))) << Printable(text);
    EXPECT_THAT(*svg, Not(HasSubstr("<script")));
  }
}

TEST_F(PlotText, NothingIsExecutedInOtherPicturesAndOnTerminals) {
  std::string all;
  for (const std::string& text : Hostile()) all += text;
  const Panel panel = PanelOf(all);
  for (const char* const name : {"plot.png", "plot.pdf", "plot.svg"}) {
    const auto drawn = DrawPanels(directory_ / name, {panel});
    EXPECT_TRUE(drawn) << drawn.error().Text();
  }
  const Map map{
      .title = all, .x_label = all, .y_label = all, .value_label = all, .values = {{1, 2}, {3, 4}}};
  EXPECT_TRUE(DrawMap(directory_ / "map.svg", map));
  EXPECT_THAT(TextsOf(Content("map.svg")), HasSubstr("touch"));
  const auto text = DrawText(panel, 79, 14);
  ASSERT_TRUE(text) << text.error().Text();
  EXPECT_EQ(*text, PrintableLines(*text));
  EXPECT_FALSE(std::filesystem::exists(canary_));
}

// gnuplot opens a pipe to an output whose name begins with a bar
TEST_F(PlotText, APathIsAFileWhateverItsName) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(directory_);
  for (const char* const name :
       {"|touch canary; cat > x.svg", "a'b\"`touch canary`.svg", "-d.svg", "%s $HOME {x} .svg"}) {
    const auto drawn = DrawPanels(name, {PanelOf("fine")});
    EXPECT_TRUE(drawn) << drawn.error().Text();
    EXPECT_TRUE(std::filesystem::is_regular_file(directory_ / name)) << name;
  }
  EXPECT_EQ(DrawPanels("x\n!touch canary\n.svg", {PanelOf("fine")}).error().cause, Cause::kUsage);
  std::filesystem::current_path(before);
  EXPECT_FALSE(std::filesystem::exists(canary_));
}

// what a user's start-up file would draw or do
TEST_F(PlotText, StartUpFilesAreNotRead) {
  const std::string start = "system('touch " + canary_ + "')\nset title 'from the start-up file'\n";
  for (const char* const name : {".gnuplot", "gnuplotrc", ".gnuplotrc"}) {
    static_cast<void>(File(name, start));
  }
  std::filesystem::create_directory(directory_ / "gnuplot");
  std::ofstream(directory_ / "gnuplot" / "gnuplotrc") << start;
  const std::filesystem::path before = std::filesystem::current_path();
  const std::string home = std::getenv("HOME") != nullptr ? std::getenv("HOME") : "";
  for (const char* const name : {"HOME", "XDG_CONFIG_HOME", "GNUPLOT", "GNUPLOT_LIB"}) {
    setenv(name, directory_.c_str(), 1);
  }
  std::filesystem::current_path(directory_);
  const auto svg = DrawSvg({PanelOf("fine")});
  std::filesystem::current_path(before);
  setenv("HOME", home.c_str(), 1);
  for (const char* const name : {"XDG_CONFIG_HOME", "GNUPLOT", "GNUPLOT_LIB"}) unsetenv(name);
  ASSERT_TRUE(svg);
  EXPECT_FALSE(std::filesystem::exists(canary_));
}

// gnuplot writes a tick's name that holds a percent sign into 50 bytes and cuts characters in two
TEST_F(PlotText, LongTextsEndWithAMark) {
  std::string name = "50 % ";
  for (int i = 0; i < 40; ++i) name += "ä";
  const auto svg = DrawSvg({PanelOf(name)});
  ASSERT_TRUE(svg);
  EXPECT_THAT(TextsOf(*svg), HasSubstr("50 % ää"));
  EXPECT_THAT(TextsOf(*svg), HasSubstr("ä…"));
  EXPECT_LE(Quoted::TickName(name).word().size(), 49U + 1 + 2) << "a doubled sign, two quotes";
  EXPECT_EQ(Quoted(std::string(1000, 'x')).word(), "'" + std::string(1000, 'x') + "'");
  EXPECT_EQ(Quoted(std::string(1001, 'x')).word(), "'" + std::string(999, 'x') + "…'");
}

// gnuplot draws nothing of panels of which one has no point on its axes
TEST_F(PlotText, APanelWithoutPointsIsAnEmptyFrame) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const LogAxes axes : {LogAxes::kNone, LogAxes::kX, LogAxes::kY, LogAxes::kBoth}) {
    for (const double value : {nan, axes == LogAxes::kNone ? nan : -1.0}) {
      Panel empty{.title = "empty", .series = {{.x = {value, value}, .y = {value, value}}}};
      empty.log_axes = axes;
      const auto svg = DrawSvg({empty, PanelOf("full")});
      ASSERT_TRUE(svg);
      EXPECT_THAT(TextsOf(*svg), AllOf(HasSubstr("empty"), HasSubstr("full")));
    }
  }
}

}  // namespace
}  // namespace haptometer::plot
