#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace haptometer::plot {

/// A colour: 0xRRGGBB.
struct Colour {
  std::uint32_t rgb = 0;
};

/// Colours that stay apart in grey and for colour-blind readers (Okabe and Ito, 2008).
inline constexpr Colour kBlue{0x0072b2};
inline constexpr Colour kOrange{0xd55e00};
inline constexpr Colour kGreen{0x009e73};
inline constexpr Colour kPurple{0xcc79a7};
inline constexpr Colour kYellow{0xe69f00};
inline constexpr Colour kSkyBlue{0x56b4e9};
inline constexpr Colour kBlack{0x000000};
inline constexpr Colour kGrey{0xb0b0b0};
inline constexpr Colour kDarkGrey{0x404040};

/// What a curve is drawn with; kErrorBars are points with Series::y_error.
enum class Mark : std::uint8_t { kLines, kPoints, kLinesPoints, kBoxes, kErrorBars };

/// How a curve is drawn.
struct Style {
  Mark mark = Mark::kLines;
  Colour colour = kBlue;
  double width = 1;  ///< of lines
  int dash = 1;      ///< 1: solid; 2, 3, ...: gnuplot's dash types
  double size = 1;   ///< of points
  int point = 7;     ///< gnuplot's point types: 7 is a disc, 2 a cross
};

/// Shorthands for the two most usual styles.
[[nodiscard]] constexpr Style Lines(Colour colour, double width = 1, int dash = 1) {
  return {.colour = colour, .width = width, .dash = dash};
}
[[nodiscard]] constexpr Style Points(Colour colour, double size) {
  return {.mark = Mark::kPoints, .colour = colour, .size = size};
}

/// One curve. A NaN in `y` breaks the line.
struct Series {
  std::string title{};  ///< in the key; empty: not listed
  Style style = {};
  std::vector<double> x{};  ///< (n), ascending where there are more than 4000
  std::vector<double> y{};  ///< (n)
  /// (n), half the length of each point's error bar, for Mark::kErrorBars; empty: none
  std::vector<double> y_error = {};
};

/// A name below an axis.
struct Tick {
  double x = 0;
  std::string name;
};

/// Which axes are logarithmic; values that are not above 0 have no place on such an axis.
enum class LogAxes : std::uint8_t { kNone, kX, kY, kBoth };

/// Intervals of x that are shaded over the height of a panel, behind its curves.
struct Shade {
  std::string title{};  ///< in the key; empty: not listed
  Colour colour = kGrey;
  std::vector<std::pair<double, double>> intervals{};
};

/// One pair of axes.
struct Panel {
  std::string title{};
  std::string x_label{};  ///< with its unit: "time / s"
  std::string y_label{};
  std::vector<Series> series{};
  LogAxes log_axes = LogAxes::kNone;
  /// The axis reaches further by 0.7 of the least distance of two.
  std::vector<Tick> ticks = {};  ///< ascending, in the place of numbers
  bool y_from_zero = false;
  /// The ends of the y axis; as wide as the points where they are equal. For panels that are
  /// compared.
  std::pair<double, double> y_range{};
  bool x_from_zero = false;  ///< and a twentieth further than the last point
  /// The ends of the x axis; as wide as the points where they are equal. Panels of the same ends
  /// are aligned.
  std::pair<double, double> x_range{};
  std::vector<Shade> shades = {};
  bool has_margins = false;  ///< room between the outermost points and the frame
  bool equal_axes = false;   ///< one unit is as long along y as along x: circles are round
};

/// Draws `panels` one below the other into `path`, whose ending chooses SVG, PNG or PDF.
///
/// A curve of more than 4000 points is drawn as the minimum and maximum of each of 2000 slices,
/// which looks the same at this size. Titles, labels and names may be any text: it is shown, never
/// executed (tools/plot/script.h). Written as a cli::OutputFile: an older plot of ours at `path` is
/// replaced. Errors: as CheckPlotPath; gnuplot absent or failing, or a path that cannot be written
/// (Cause::kFailed). Starts one gnuplot process and waits for it, 120 s at most.
[[nodiscard]] Result<void> DrawPanels(const std::string& path, const std::vector<Panel>& panels);

/// A quantity over two axes, shown by colour.
struct Map {
  std::string title{};
  std::string x_label{};
  std::string y_label{};
  std::string value_label{};
  double x_start = 0;
  double x_step = 1;
  double y_start = 0;
  double y_step = 1;
  std::vector<std::vector<double>> values{};  ///< (columns along x, rows along y)
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

/// A curve of fewer points that covers the same ink: of each of `slices` equal runs of rows its
/// least and its greatest value, so that no peak is lost however long the curve is.
///
/// A NaN breaks the line, and still does so where it falls among measured values: the slice's two
/// points are followed by one NaN. `y` shorter than twice `slices` comes back as it is.
/// Appends to `out_x`, `out_y` at most three points a slice. Cost: one pass.
void AppendEnvelope(const std::vector<double>& x, const std::vector<double>& y, std::size_t slices,
                    std::vector<double>* out_x, std::vector<double>* out_y);

}  // namespace haptometer::plot
