#include "tools/plot/gnuplot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>

#include "base/check.h"
#include "base/clock.h"
#include "tools/cli/output_file.h"
#include "tools/plot/envelope.h"
#include "tools/plot/memory_file.h"
#include "tools/plot/run_within.h"

namespace haptometer::plot {
namespace {

constexpr std::size_t kMostPoints = 4000;
// viridis (van der Walt and Smith, 2015): even steps for the eye, also in grey
constexpr std::string_view kPalette =
    "0 '#440154', 1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725'";
constexpr std::size_t kMostCells = 1000;  // of a map, along each axis
// some thousand times what it needs: beyond, it hangs
constexpr MonotonicNs kLongestTextNs = 5 * kNsPerS;
constexpr MonotonicNs kLongestPanelsNs = 120 * kNsPerS;

struct Terminal {
  std::string_view ending;
  std::string_view words;  // of "set terminal"; {0} is the height in pixels
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

// gnuplot doubles a quote inside quotes
std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

void AppendPoint(std::string& data, double x, double y) {
  data += std::isfinite(y) ? fmt::format("{:.9g} {:.9g}\n", x, y) : "\n";
}

// each point with half the length of its error bar
std::string ErrorRows(const Series& series) {
  HAPTOMETER_CHECK(series.y_error.size() == series.y.size(), "{} error bars, {} y",
                   series.y_error.size(), series.y.size());
  std::string rows;
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    if (!std::isfinite(series.y[i]) || !std::isfinite(series.y_error[i])) continue;
    fmt::format_to(std::back_inserter(rows), "{:.9g} {:.9g} {:.9g}\n", series.x[i], series.y[i],
                   series.y_error[i]);
  }
  return rows;
}

std::string DataBlock(std::size_t panel, std::size_t number, const Series& series) {
  HAPTOMETER_CHECK(series.x.size() == series.y.size(), "{} x, {} y", series.x.size(),
                   series.y.size());
  std::string data = fmt::format("$data_{}_{} << EOD\n", panel, number);
  if (!series.y_error.empty()) return data + ErrorRows(series) + "EOD\n";
  std::vector<double> x;
  std::vector<double> y;
  AppendEnvelope(series.x, series.y, kMostPoints / 2, &x, &y);
  for (std::size_t i = 0; i < y.size(); ++i) AppendPoint(data, x[i], y[i]);
  return data + "EOD\n";
}

std::string_view LogWords(LogAxes axes) {
  switch (axes) {
    case LogAxes::kNone:
      return "unset logscale";
    case LogAxes::kX:
      return "unset logscale; set logscale x";
    case LogAxes::kY:
      return "unset logscale; set logscale y";
    case LogAxes::kBoth:
      return "set logscale xy";
  }
  HAPTOMETER_CHECK(false, "axes {}", static_cast<int>(axes));
}

// points beside the frame, not on it
std::string RangeOfX(const Panel& panel) {
  if (!panel.x_from_zero) return "set xrange [*:*]\n";
  double last = 0;
  for (const Series& series : panel.series) {
    for (const double x : series.x) last = std::max(last, x);
  }
  return fmt::format("set xrange [0:{:.9g}]\n", 1.05 * last);
}

// Of an axis, x or y: on a logarithmic one of less than three decades 1, 2 and 5 of each, because
// gnuplot would name the decades alone, of which it may hold one.
std::string NumbersOn(char axis, bool is_logarithmic, const Panel& panel,
                      std::vector<double> Series::* values) {
  std::string automatic = fmt::format("set {}tics autofreq\n", axis);
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (const Series& series : panel.series) {
    for (const double value : series.*values) {
      if (!(value > 0)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  if (!is_logarithmic || !(most < 1000 * least)) return automatic;
  std::string numbers;
  const int last = static_cast<int>(std::ceil(std::log10(most)));
  for (int decade = static_cast<int>(std::floor(std::log10(least))); decade <= last; ++decade) {
    for (const double step : {1.0, 2.0, 5.0}) {
      fmt::format_to(std::back_inserter(numbers), "{}{:.9g}", numbers.empty() ? "" : ", ",
                     step * std::pow(10.0, decade));
    }
  }
  return fmt::format("set {}tics ({})\n", axis, numbers);
}

// both axes as they are without, so that no panel inherits from the one before
std::string AxisWords(const Panel& panel) {
  std::string words = panel.y_from_zero ? "set yrange [0:*]\n" : "set yrange [*:*]\n";
  words += panel.has_margins ? "set offsets graph 0.08, graph 0.08, graph 0.08, graph 0.08\n"
                             : "unset offsets\n";
  const bool both = panel.log_axes == LogAxes::kBoth;
  words += NumbersOn('y', both || panel.log_axes == LogAxes::kY, panel, &Series::y);
  if (panel.ticks.empty()) {
    return words + NumbersOn('x', both || panel.log_axes == LogAxes::kX, panel, &Series::x) +
           RangeOfX(panel);
  }
  double least = 1;  // between two of them
  for (std::size_t i = 1; i < panel.ticks.size(); ++i) {
    const double distance = panel.ticks[i].x - panel.ticks[i - 1].x;
    least = i == 1 ? distance : std::min(least, distance);
  }
  const double further = 0.7 * least;
  words += "set xtics (";
  for (const Tick& tick : panel.ticks) {
    fmt::format_to(std::back_inserter(words), "{}{} {:.9g}",
                   &tick == panel.ticks.data() ? "" : ", ", Quoted(tick.name), tick.x);
  }
  return words + fmt::format(")\nset xrange [{:.9g}:{:.9g}]\n", panel.ticks.front().x - further,
                             panel.ticks.back().x + further);
}

std::string PanelScript(std::size_t number, const Panel& panel) {
  std::string script = fmt::format(
      "set title {}\nset xlabel {}\nset ylabel {}\n{}\n{}plot ", Quoted(panel.title),
      Quoted(panel.x_label), Quoted(panel.y_label), LogWords(panel.log_axes), AxisWords(panel));
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    const std::string title =
        series.title.empty() ? "notitle" : fmt::format("title {}", Quoted(series.title));
    script += fmt::format("{}$data_{}_{} using {} with {} {}", i == 0 ? "" : ", ", number, i,
                          series.y_error.empty() ? "1:2" : "1:2:3", series.style, title);
  }
  return script + "\n";
}

// a square leaves room for the key beside it, not above
std::string_view ShapeWords(const Panel& panel) {
  return panel.equal_axes ? "set size ratio -1\nset key rmargin top vertical\n"
                          : "set size noratio\nset key tmargin right horizontal\n";
}

std::string Script(const std::string& path, const Terminal& terminal,
                   const std::vector<Panel>& panels) {
  const bool square = std::ranges::any_of(panels, &Panel::equal_axes);
  const std::size_t height = (square ? 560 : 320) * panels.size();
  std::string script =
      "set encoding utf8\nset terminal " +
      fmt::format(fmt::runtime(terminal.words), height, static_cast<double>(height) / 100) +
      "\nset termoption noenhanced\nset output " + Quoted(path) +
      "\nset grid lc rgb '#e0e0e0'\nset autoscale xfix\n"
      "set boxwidth 0.6\nset format '%.10g'\n";
  for (std::size_t p = 0; p < panels.size(); ++p) {
    for (std::size_t s = 0; s < panels[p].series.size(); ++s) {
      script += DataBlock(p, s, panels[p].series[s]);
    }
  }
  script += fmt::format("set multiplot layout {},1\n", panels.size());
  for (std::size_t p = 0; p < panels.size(); ++p) {
    script += ShapeWords(panels[p]);
    script += PanelScript(p, panels[p]);
  }
  return script + "unset multiplot\nunset output\n";
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

std::string MapScript(const std::string& path, const Terminal& terminal, const Map& map) {
  std::string script =
      "set encoding utf8\nset terminal " + fmt::format(fmt::runtime(terminal.words), 480, 4.8) +
      "\nset termoption noenhanced\nset output " + Quoted(path) + "\n$map << EOD\n";
  const std::size_t columns = RunOf(map.values.size());
  const std::size_t rows = RunOf(map.values[0].size());
  for (std::size_t c = 0; c < map.values.size(); c += columns) {
    for (std::size_t r = 0; r < map.values[c].size(); r += rows) {
      fmt::format_to(std::back_inserter(script), "{:.9g} {:.9g} {:.6g}\n",
                     map.x_start + map.x_step * static_cast<double>(c),
                     map.y_start + map.y_step * static_cast<double>(r),
                     GreatestOf(map, c, columns, r, rows));
    }
    script += "\n";
  }
  return script + fmt::format(
                      "EOD\nset title {}\nset xlabel {}\nset ylabel {}\nset cblabel {}\n"
                      "set autoscale fix\nset palette defined ({})\n"
                      "plot $map using 1:2:3 with image notitle\nunset output\n",
                      Quoted(map.title), Quoted(map.x_label), Quoted(map.y_label),
                      Quoted(map.value_label), kPalette);
}

// Whether gnuplot took the whole script and ended well. Its own words say nothing to a user; what
// it drew, or did not, is the evidence.
Result<bool> RunGnuplot(const std::string& script, const std::string& where,
                        MonotonicNs longest_ns) {
  const auto run = RunWithin({"gnuplot"}, script, longest_ns);
  if (run) return *run;
  return Failed(where, run.error().what, "is it installed (apt-get install gnuplot-nox)?");
}

// what gnuplot draws by `script`, which is given the terminal and where to draw; in memory, because
// gnuplot does not tell when a disk is full
template <typename MakeScript>
Result<std::string> Drawn(const std::string& where, const Terminal& terminal,
                          const MakeScript& script) {
  const MemoryFile drawing;
  const auto run = RunGnuplot(script(drawing.path(), terminal), where, kLongestPanelsNs);
  if (!run) return std::unexpected(run.error());
  std::string picture = drawing.Content();
  if (*run && cli::IsWholePicture(picture)) return picture;
  return Failed(where, "gnuplot drew no whole picture", "is there memory left?");
}

template <typename MakeScript>
Result<void> DrawInto(const std::string& path, const MakeScript& script) {
  if (auto known = CheckPlotPath(path); !known) return known;
  auto picture = Drawn(path, *TerminalOf(path), script);
  if (!picture) return std::unexpected(picture.error());
  return cli::WriteOutput(path, cli::kPictureOutput, false, cli::Marked(*std::move(picture)));
}

}  // namespace

Result<std::string> DrawSvg(const std::vector<Panel>& panels) {
  HAPTOMETER_CHECK(!panels.empty(), "a plot without panels");
  return Drawn("plot", *TerminalOf("plot.svg"),
               [&](const std::string& drawing, const Terminal& terminal) {
                 return Script(drawing, terminal, panels);
               });
}

Result<std::string> DrawText(const Panel& panel, int columns, int lines) {
  const MemoryFile drawing;
  std::string script = fmt::format(
      "set encoding utf8\nset terminal dumb size {},{} noenhanced\nset output {}\n"
      "set key off\nset autoscale xfix\n",
      columns, lines, Quoted(drawing.path()));
  for (std::size_t s = 0; s < panel.series.size(); ++s) {
    script += DataBlock(0, s, panel.series[s]);
  }
  const auto run =
      RunGnuplot(script + PanelScript(0, panel) + "unset output\n", "plot", kLongestTextNs);
  if (!run) return std::unexpected(run.error());
  std::string text = drawing.Content();
  if (!*run || text.empty()) return Failed("plot", "gnuplot drew nothing");
  std::erase(text, '\f');  // ends a page
  return text;
}

Result<void> CheckPlotPath(const std::string& path) {
  if (TerminalOf(path) == nullptr) {
    return Usage(path, "has an ending that no plot can be written as", "use .svg, .png or .pdf");
  }
  return cli::CheckOutput(path, cli::kPictureOutput, false);
}

Result<void> DrawPanels(const std::string& path, const std::vector<Panel>& panels) {
  HAPTOMETER_CHECK(!panels.empty(), "a plot without panels");
  return DrawInto(path, [&](const std::string& drawing, const Terminal& terminal) {
    return Script(drawing, terminal, panels);
  });
}

Result<void> DrawMap(const std::string& path, const Map& map) {
  HAPTOMETER_CHECK(!map.values.empty() && !map.values[0].empty(), "an empty map");
  return DrawInto(path, [&](const std::string& drawing, const Terminal& terminal) {
    return MapScript(drawing, terminal, map);
  });
}

}  // namespace haptometer::plot
