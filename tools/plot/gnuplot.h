#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace haptometer::plot {

/// One curve. A NaN in `y` breaks the line.
struct Series {
  std::string title;      ///< in the key; empty: not listed
  std::string style;      ///< gnuplot's words: "lines lc rgb '#1f77b4'", "points pt 7 ps 0.3"
  std::vector<double> x;  ///< (n), ascending where there are more than 4000
  std::vector<double> y;  ///< (n)
  /// (n), half the length of each point's error bar, with "yerrorbars" as the style; empty: none
  std::vector<double> y_error = {};
};

/// A name below an axis.
struct Tick {
  double x = 0;
  std::string name;
};

/// Which axes are logarithmic; values that are not above 0 have no place on such an axis.
enum class LogAxes : std::uint8_t { kNone, kX, kY, kBoth };

/// One pair of axes.
struct Panel {
  std::string title;
  std::string x_label;  ///< with its unit: "time / s"
  std::string y_label;
  std::vector<Series> series;
  LogAxes log_axes = LogAxes::kNone;
  /// The axis reaches further by 0.7 of the least distance of two.
  std::vector<Tick> ticks = {};  ///< ascending, in the place of numbers
  bool y_from_zero = false;
  bool x_from_zero = false;  ///< and a twentieth further than the last point
  bool has_margins = false;  ///< room between the outermost points and the frame
  bool equal_axes = false;   ///< one unit is as long along y as along x: circles are round
};

/// Colours that stay apart in grey and for colour-blind readers (Okabe and Ito, 2008).
inline constexpr std::string_view kBlue = "#0072b2";
inline constexpr std::string_view kOrange = "#d55e00";
inline constexpr std::string_view kGrey = "#b0b0b0";

/// Draws `panels` one below the other into `path`, whose ending chooses SVG, PNG or PDF.
///
/// A curve of more than 4000 points is drawn as the minimum and maximum of each of 2000 slices,
/// which looks the same at this size. Written as a cli::OutputFile: an older plot of ours at `path`
/// is replaced. Errors: as CheckPlotPath; gnuplot absent or failing, or a path that cannot be
/// written (Cause::kFailed). Starts one gnuplot process and waits for it, 120 s at most.
[[nodiscard]] Result<void> DrawPanels(const std::string& path, const std::vector<Panel>& panels);

/// A quantity over two axes, shown by colour.
struct Map {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::string value_label;
  double x_start = 0;
  double x_step = 1;
  double y_start = 0;
  double y_step = 1;
  std::vector<std::vector<double>> values;  ///< (columns along x, rows along y)
};

/// Draws `map` as DrawPanels does; of more than 1000 columns or rows the greatest of each run is
/// shown. Errors: as DrawPanels.
[[nodiscard]] Result<void> DrawMap(const std::string& path, const Map& map);

/// DrawPanels as one SVG document. Errors (Cause::kFailed): gnuplot absent or failing.
[[nodiscard]] Result<std::string> DrawSvg(const std::vector<Panel>& panels);

/// Draws `panel` with characters, `columns` wide and `lines` high, for a terminal: its lines with
/// their ends. Errors (Cause::kFailed): gnuplot absent or failing. Starts one gnuplot process and
/// waits for it, some 30 ms and 5 s at most.
[[nodiscard]] Result<std::string> DrawText(const Panel& panel, int columns, int lines);

/// Whether DrawPanels can write `path`; to be asked before long work. Errors: Cause::kUsage for
/// another ending; as cli::CheckOutput.
[[nodiscard]] Result<void> CheckPlotPath(const std::string& path);

}  // namespace haptometer::plot
