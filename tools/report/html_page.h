#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::report {

/// One self-contained page: figures, numbers and settings in a single file that needs nothing from
/// elsewhere, reads on a narrow screen and prints on A4 with no figure or row cut in two.
///
/// All text is escaped here; what is not printable is shown as base/text.h says.
class HtmlPage {
 public:
  /// `title` is the window's title and the first heading; `subtitle` stands below it.
  HtmlPage(std::string_view title, std::string_view subtitle);

  void Section(std::string_view heading);
  void Subsection(std::string_view heading);
  void Paragraph(std::string_view text);
  /// What a reader must not miss: why nothing was answered, what was assumed.
  void Warning(std::string_view text);
  void List(const std::vector<std::string>& items);
  /// `rows` each have as many cells as `header`, or as each other where it is empty; the first cell
  /// is the row's heading.
  void Table(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows);
  /// Draws the panels with gnuplot into the page. Errors: as plot::DrawSvg.
  [[nodiscard]] Result<void> Figure(std::string_view caption,
                                    const std::vector<plot::Panel>& panels);

  /// The whole document so far.
  [[nodiscard]] std::string Html() const;

 private:
  std::string title_;
  std::string body_;
  int figures_ = 0;
};

/// Writes `page` to `path`, beside it first, so that a failure costs no older report.
/// Errors (Cause::kFailed): the place cannot be written.
[[nodiscard]] Result<void> WriteReport(const std::string& path, const HtmlPage& page);

/// Whether a report can be written to `path`: its ending is .html, its directory is there and
/// nothing but a file is in its place; to be asked before long work. Errors: Cause::kUsage.
[[nodiscard]] Result<void> CheckReportPath(const std::string& path);

}  // namespace haptometer::report
