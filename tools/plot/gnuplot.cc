#include "tools/plot/gnuplot.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>

#include "base/clock.h"
#include "base/text.h"
#include "base/typeset.h"
#include "tools/cli/output_file.h"
#include "tools/plot/script.h"

namespace haptometer::plot {
namespace {

// points of a curve: least and greatest of 2000 slices, finer than 900 pixels
constexpr std::size_t kMostPoints = 4000;
// viridis (van der Walt and Smith, 2015): perceptually uniform, also in grey
constexpr Words kPalette = "0 '#440154', 1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725'";
constexpr std::size_t kMostCells = 1000;  // of a map, along each axis
// limits of the run time: far above any drawing, so that a hung gnuplot ends
constexpr MonotonicNs kLongestTextNs = 5 * kNsPerS;
constexpr MonotonicNs kLongestPanelsNs = 120 * kNsPerS;

struct Terminal {
  std::string_view ending;
  Words words;  // of "set terminal"; {0} is the height in pixels, {1} in inches
};

constexpr Terminal kTerminals[] = {
    {".svg", "svg size 900,{0} dynamic background '#ffffff' font 'Helvetica,13'"},
    {".png", "pngcairo size 900,{0} font 'Helvetica,11'"},
    {".pdf", "pdfcairo size 9in,{1}in font 'Helvetica,11'"},
};

const Terminal* TerminalOf(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  const auto found = std::ranges::find(kTerminals, ending, &Terminal::ending);
  return found == std::end(kTerminals) ? nullptr : found;
}

// an empty line interrupts the curve: gnuplot draws no line across it
void AddPoint(double x, double y, Script* script) {
  if (std::isfinite(y)) {
    script->Add("{:.9g} {:.9g}\n", x, y);
  } else {
    script->Add("\n");
  }
}

// each point with half the length of its error bar
void AddErrorRows(const Series& series, Script* script) {
  HAPTOMETER_CHECK(series.y_error.size() == series.y.size(), "{} error bars, {} y",
                   series.y_error.size(), series.y.size());
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    if (!std::isfinite(series.y[i]) || !std::isfinite(series.y_error[i])) continue;
    script->Add("{:.9g} {:.9g} {:.9g}\n", series.x[i], series.y[i], series.y_error[i]);
  }
}

// a data block of the script: no temporary file, and no user's text within it
void AddDataBlock(std::size_t panel, std::size_t number, const Series& series, Script* script) {
  HAPTOMETER_CHECK(series.x.size() == series.y.size(), "{} x, {} y", series.x.size(),
                   series.y.size());
  script->Add("$data_{}_{} << EOD\n", panel, number);
  if (!series.y_error.empty()) {
    AddErrorRows(series, script);
  } else {
    std::vector<double> x;
    std::vector<double> y;
    // an envelope of the least and greatest values retains peaks
    AppendEnvelope(series.x, series.y, kMostPoints / 2, &x, &y);
    for (std::size_t i = 0; i < y.size(); ++i) AddPoint(x[i], y[i], script);
  }
  script->Add("EOD\n");
}

Words LogWords(LogAxes axes) {
  constexpr std::array<Words, 4> kWords{"unset logscale", "unset logscale; set logscale x",
                                        "unset logscale; set logscale y", "set logscale xy"};
  return kWords.at(static_cast<std::size_t>(axes));
}

// whether a point lies on the axes, of which logarithmic ones hold positive values alone
bool HasPoints(const Panel& panel) {
  const bool both = panel.log_axes == LogAxes::kBoth;
  const auto lies_on = [](double value, bool is_logarithmic) {
    return std::isfinite(value) && (value > 0 || !is_logarithmic);
  };
  return std::ranges::any_of(panel.series, [&](const Series& series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (lies_on(series.x[i], both || panel.log_axes == LogAxes::kX) &&
          lies_on(series.y[i], both || panel.log_axes == LogAxes::kY)) {
        return true;
      }
    }
    return false;
  });
}

// gnuplot finds no range without a point: from 0 to 1 where none is stated
Panel EmptyFrame(Panel panel) {
  panel.log_axes = LogAxes::kNone;
  for (auto* range : {&panel.x_range, &panel.y_range}) {
    if (!(range->first < range->second)) *range = {0, 1};
  }
  return panel;
}

// from 0 to 5 % beyond the last point, so that no point lies on the frame
void AddRangeOfX(const Panel& panel, Script* script) {
  if (panel.x_range.first < panel.x_range.second) {
    return script->Add("set xrange [{:.9g}:{:.9g}]\n", panel.x_range.first, panel.x_range.second);
  }
  if (!panel.x_from_zero) return script->Add("set xrange [*:*]\n");
  double last = 0;
  for (const Series& series : panel.series) {
    for (const double x : series.x) last = std::max(last, x);
  }
  script->Add("set xrange [0:{:.9g}]\n", 1.05 * last);
}

// Of an axis, x or y: on a logarithmic one of less than three decades 1, 2 and 5 of each, of less
// than one also what lies between, because gnuplot would name the decades alone, of which it may
// hold one.
void AddNumbersOn(Words axis, bool is_logarithmic, const Panel& panel,
                  std::vector<double> Series::* values, Script* script) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  // range of the positive values, the only ones on a logarithmic axis
  for (const Series& series : panel.series) {
    for (const double value : series.*values) {
      if (!(value > 0)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  // three decades or more: the automatic numbers suffice
  if (!is_logarithmic || !(most < 1000 * least)) return script->Add("set {}tics autofreq\n", axis);
  script->Add("set {}tics (", axis);
  Words separator = "";
  const int last = static_cast<int>(std::ceil(std::log10(most)));
  for (int decade = static_cast<int>(std::floor(std::log10(least))); decade <= last; ++decade) {
    for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0}) {
      const bool is_coarse = step == 1 || step == 2 || step == 5;
      if (!is_coarse && most > 10 * least) continue;
      script->Add("{}{:.9g}", separator, step * std::pow(10.0, decade));
      separator = ", ";
    }
  }
  script->Add(")\n");
}

// names of conditions instead of numbers
void AddTicks(const std::vector<Tick>& ticks, Script* script) {
  double least = 1;  // between two of them
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    const double distance = ticks[i].x - ticks[i - 1].x;
    least = i == 1 ? distance : std::min(least, distance);
  }
  // free space at both ends: 0.7 of the least distance
  const double further = 0.7 * least;
  script->Add("set xtics (");
  Words separator = "";
  for (const Tick& tick : ticks) {
    script->Add("{}{} {:.9g}", separator, Quoted::TickName(tick.name), tick.x);
    separator = ", ";
  }
  script->Add(")\nset xrange [{:.9g}:{:.9g}]\n", ticks.front().x - further,
              ticks.back().x + further);
}

// every setting of the axes is written, so that no panel inherits from the one before
void AddAxes(const Panel& panel, Script* script) {
  if (panel.y_range.first < panel.y_range.second) {
    script->Add("set yrange [{:.9g}:{:.9g}]\n", panel.y_range.first, panel.y_range.second);
  } else {
    script->Add(panel.y_from_zero ? Words("set yrange [0:*]\n") : Words("set yrange [*:*]\n"));
  }
  script->Add(panel.has_margins
                  ? Words("set offsets graph 0.08, graph 0.08, graph 0.08, graph 0.08\n")
                  : Words("unset offsets\n"));
  const bool both = panel.log_axes == LogAxes::kBoth;
  AddNumbersOn("y", both || panel.log_axes == LogAxes::kY, panel, &Series::y, script);
  if (!panel.ticks.empty()) return AddTicks(panel.ticks, script);
  AddNumbersOn("x", both || panel.log_axes == LogAxes::kX, panel, &Series::x, script);
  AddRangeOfX(panel, script);
}

Words MarkWords(Mark mark) {
  constexpr std::array<Words, 5> kWords{"lines", "points", "linespoints", "boxes fill solid 0.35",
                                        "yerrorbars"};
  return kWords.at(static_cast<std::size_t>(mark));
}

void AddStyle(const Style& style, Script* script) {
  script->Add(" with {} lw {} lc rgb '#{:06x}'", MarkWords(style.mark), style.width,
              style.colour.rgb);
  if (style.mark == Mark::kLines && style.dash > 1) script->Add(" dt {}", style.dash);
  if (style.mark != Mark::kLines && style.mark != Mark::kBoxes) {
    script->Add(" pt {} ps {}", style.point, style.size);
  }
}

// rectangles behind the curves, a paler colour each
void AddShades(const Panel& panel, Script* script) {
  script->Add("unset object\n");
  for (const Shade& shade : panel.shades) {
    for (const auto& [from, to] : shade.intervals) {
      script->Add(
          "set object rectangle from first {:.9g}, graph 0 to first {:.9g}, graph 1 behind "
          "fillcolor "
          "rgb '#{:06x}' fillstyle solid 0.25 noborder\n",
          from, to, shade.colour.rgb);
    }
  }
}

// the entries of shades in the key
void AddShadeNames(const Panel& panel, Words separator, Script* script) {
  for (const Shade& shade : panel.shades) {
    if (shade.title.empty() || shade.intervals.empty()) continue;
    script->Add("{} keyentry with boxes fillcolor rgb '#{:06x}' fillstyle solid 0.25 title {}",
                separator, shade.colour.rgb, Quoted(shade.title));
    separator = ",";
  }
}

// words with the signs of units
Quoted Label(std::string_view text) { return Quoted(Typeset(text)); }

void AddPanel(std::size_t number, const Panel& panel, Script* script) {
  script->Add("set title {}\nset xlabel {}\nset ylabel {}\n{}\n", Label(panel.title),
              Label(panel.x_label), Label(panel.y_label), LogWords(panel.log_axes));
  AddAxes(panel, script);
  AddShades(panel, script);
  Words separator = "plot";
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    script->Add("{} $data_{}_{} using {}", separator, number, i,
                series.y_error.empty() ? Words("1:2") : Words("1:2:3"));
    AddStyle(series.style, script);
    if (series.title.empty()) {
      script->Add(" notitle");
    } else {
      script->Add(" title {}", Label(series.title));
    }
    separator = ",";
  }
  AddShadeNames(panel, separator, script);
  script->Add("\n");
}

// equal scales need a square panel, which leaves room for the key on its right
Words ShapeWords(const Panel& panel) {
  return panel.equal_axes ? Words("set size ratio -1\nset key rmargin top vertical\n")
                          : Words("set size noratio\nset key tmargin right horizontal\n");
}

// output of the drawing: a file of this program, never one that a user names
void AddOutput(const MemoryFile& drawing, const Terminal& terminal, std::size_t height,
               Script* script) {
  script->Add("set encoding utf8\nset terminal ");
  script->Add(terminal.words, height, static_cast<double>(height) / 100);
  // noenhanced: _ and ^ in names are characters, not subscripts
  script->Add("\nset termoption noenhanced\nset output {}\n", Quoted(drawing.path()));
}

Script PanelsScript(const MemoryFile& drawing, const Terminal& terminal,
                    const std::vector<Panel>& panels) {
  const bool square = std::ranges::any_of(panels, &Panel::equal_axes);
  Script script;
  // pixels per panel: 560 for equal axes, 320 for curves
  AddOutput(drawing, terminal, (square ? 560 : 320) * panels.size(), &script);
  script.Add(
      "set grid lc rgb '#e0e0e0'\nset autoscale xfix\n"
      "set boxwidth 0.6\nset format '%.10g'\n");
  // all data blocks before the first plot
  for (std::size_t p = 0; p < panels.size(); ++p) {
    for (std::size_t s = 0; s < panels[p].series.size(); ++s) {
      AddDataBlock(p, s, panels[p].series[s], &script);
    }
  }
  script.Add("set multiplot layout {},1\n", panels.size());
  // panels below each other begin and end at the same place
  if (!square && panels.size() > 1) script.Add("set lmargin 11\nset rmargin 3\n");
  for (std::size_t p = 0; p < panels.size(); ++p) {
    script.Add(ShapeWords(panels[p]));
    if (HasPoints(panels[p])) {
      AddPanel(p, panels[p], &script);
    } else {
      AddPanel(p, EmptyFrame(panels[p]), &script);
    }
  }
  script.Add("unset multiplot\nunset output\n");
  return script;
}

// the least run of cells that leaves at most kMostCells of `size`
std::size_t RunOf(std::size_t size) { return (size + kMostCells - 1) / kMostCells; }

// the greatest value of a run of columns and rows
double GreatestOf(const Map& map, std::size_t column, std::size_t columns, std::size_t row,
                  std::size_t rows) {
  double greatest = -std::numeric_limits<double>::infinity();
  for (std::size_t c = column; c < std::min(column + columns, map.values.size()); ++c) {
    for (std::size_t r = row; r < std::min(row + rows, map.values[c].size()); ++r) {
      greatest = std::max(greatest, map.values[c][r]);
    }
  }
  return greatest;
}

// an image of at most 1000 x 1000 cells, each the greatest value of its part of the map
Script MapScript(const MemoryFile& drawing, const Terminal& terminal, const Map& map) {
  constexpr std::size_t kHeight = 480;
  Script script;
  AddOutput(drawing, terminal, kHeight, &script);
  script.Add("$map << EOD\n");
  const std::size_t columns = RunOf(map.values.size());
  const std::size_t rows = RunOf(map.values[0].size());
  for (std::size_t c = 0; c < map.values.size(); c += columns) {
    for (std::size_t r = 0; r < map.values[c].size(); r += rows) {
      script.Add("{:.9g} {:.9g} {:.6g}\n", map.x_start + map.x_step * static_cast<double>(c),
                 map.y_start + map.y_step * static_cast<double>(r),
                 GreatestOf(map, c, columns, r, rows));
    }
    // an empty line ends a column of the image
    script.Add("\n");
  }
  script.Add(
      "EOD\nset title {}\nset xlabel {}\nset ylabel {}\nset cblabel {}\n"
      "set autoscale fix\nset palette defined ({})\n"
      "plot $map using 1:2:3 with image notitle\nunset output\n",
      Label(map.title), Label(map.x_label), Label(map.y_label), Label(map.value_label), kPalette);
  return script;
}

// whether gnuplot read the whole script and ended with status 0; its messages are discarded,
// because the picture decides; -d: without the user's start-up files
Result<bool> RunGnuplot(const Script& script, const std::string& where, MonotonicNs longest_ns) {
  const auto run = RunWithin({"gnuplot", "-d"}, script.text(), longest_ns);
  if (run) return *run;
  return Failed(where, run.error().what, "is it installed (apt-get install gnuplot-nox)?");
}

// gnuplot 5.4 leaves "]]>" in an SVG's texts, where XML forbids it, and writes it nowhere else
std::string WellFormed(std::string drawing) {
  constexpr std::string_view kForbidden = "]]>";
  for (std::size_t at = drawing.find(kForbidden); at != std::string::npos;
       at = drawing.find(kForbidden, at)) {
    drawing.replace(at, kForbidden.size(), "]]&gt;");
  }
  return drawing;
}

// drawing that gnuplot makes from the script of `make(drawing, terminal)`, in memory: gnuplot
// reports no error where a disk is full
template <typename MakeScript>
Result<std::string> Drawn(const std::string& where, const Terminal& terminal,
                          const MakeScript& make) {
  const MemoryFile drawing;
  HAPTOMETER_LET(const auto run, RunGnuplot(make(drawing, terminal), where, kLongestPanelsNs));
  std::string picture = drawing.Content();
  // an incomplete picture (no end mark of its format) is an error
  if (!run || !cli::IsWholePicture(picture)) {
    return Failed(where, "gnuplot drew no whole picture", "is there memory left?");
  }
  return terminal.ending == ".svg" ? WellFormed(std::move(picture)) : picture;
}

template <typename MakeScript>
Result<void> DrawInto(const std::string& path, const MakeScript& make) {
  HAPTOMETER_TRY(CheckPlotPath(path));
  HAPTOMETER_LET(auto picture, Drawn(path, *TerminalOf(path), make));
  return cli::WriteOutput(path, cli::kPictureOutput, false, cli::Marked(std::move(picture)));
}

}  // namespace

Result<std::string> DrawSvg(const std::vector<Panel>& panels) {
  HAPTOMETER_CHECK(!panels.empty(), "a plot without panels");
  return Drawn("plot", *TerminalOf("plot.svg"),
               [&](const MemoryFile& drawing, const Terminal& terminal) {
                 return PanelsScript(drawing, terminal, panels);
               });
}

// drawing in characters for a terminal
Result<std::string> DrawText(const Panel& panel, int columns, int lines) {
  const MemoryFile drawing;
  Script script;
  script.Add(
      "set encoding utf8\nset terminal dumb size {},{} noenhanced\nset output {}\n"
      "set key off\nset autoscale xfix\n",
      columns, lines, Quoted(drawing.path()));
  for (std::size_t s = 0; s < panel.series.size(); ++s) {
    AddDataBlock(0, s, panel.series[s], &script);
  }
  AddPanel(0, panel, &script);
  script.Add("unset output\n");
  HAPTOMETER_LET(const auto run, RunGnuplot(script, "plot", kLongestTextNs));
  std::string text = drawing.Content();
  if (!run || text.empty()) return Failed("plot", "gnuplot drew nothing");
  std::erase(text, '\f');  // ends a page
  return text;
}

Result<void> CheckPlotPath(const std::string& path) {
  HAPTOMETER_TRY(CheckPrintable("the plot's path", path));
  if (TerminalOf(path) == nullptr) {
    return Usage(path, "has an ending that no plot can be written as", "use .svg, .png or .pdf");
  }
  return cli::CheckOutput(path, cli::kPictureOutput, false);
}

Result<void> DrawPanels(const std::string& path, const std::vector<Panel>& panels) {
  HAPTOMETER_CHECK(!panels.empty(), "a plot without panels");
  return DrawInto(path, [&](const MemoryFile& drawing, const Terminal& terminal) {
    return PanelsScript(drawing, terminal, panels);
  });
}

Result<void> DrawMap(const std::string& path, const Map& map) {
  HAPTOMETER_CHECK(!map.values.empty() && !map.values[0].empty(), "an empty map");
  return DrawInto(path, [&](const MemoryFile& drawing, const Terminal& terminal) {
    return MapScript(drawing, terminal, map);
  });
}

namespace {

// not a number: AddPoint() makes a gap in the curve of it
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// rows of the least and greatest value of [begin, end), and whether a value is missing
struct Extent {
  std::size_t low = 0;
  std::size_t high = 0;
  bool has_value = false;
  bool has_break = false;
};

Extent ExtentOf(const std::vector<double>& y, std::size_t begin, std::size_t end) {
  Extent extent;
  for (std::size_t i = begin; i < end; ++i) {
    if (!std::isfinite(y[i])) {
      extent.has_break = true;
      continue;
    }
    if (!extent.has_value) extent.low = extent.high = i;
    extent.has_value = true;
    if (y[i] < y[extent.low]) extent.low = i;
    if (y[i] > y[extent.high]) extent.high = i;
  }
  return extent;
}

}  // namespace

void AppendEnvelope(const std::vector<double>& x, const std::vector<double>& y, std::size_t slices,
                    std::vector<double>* out_x, std::vector<double>* out_y) {
  // few points: all are drawn
  if (y.size() <= 2 * slices) {
    out_x->insert(out_x->end(), x.begin(), x.end());
    out_y->insert(out_y->end(), y.begin(), y.end());
    return;
  }
  auto append = [&](double point_x, double point_y) {
    out_x->push_back(point_x);
    out_y->push_back(point_y);
  };
  // equal slices of rows; least and greatest of each in the order of their rows
  for (std::size_t slice = 0; slice < slices; ++slice) {
    const std::size_t begin = slice * y.size() / slices;
    const std::size_t end = (slice + 1) * y.size() / slices;
    const Extent extent = ExtentOf(y, begin, end);
    if (extent.has_value) {
      const auto [first, second] = std::minmax(extent.low, extent.high);
      append(x[first], y[first]);
      if (second != first) append(x[second], y[second]);
    }
    // a missing value in a slice makes a gap behind it
    if (extent.has_break) append(x[end - 1], kNan);
  }
}

}  // namespace haptometer::plot
