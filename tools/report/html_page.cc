#include "tools/report/html_page.h"

#include <fmt/core.h>

#include <filesystem>

#include "base/error.h"
#include "base/text.h"
#include "tools/cli/output_file.h"

namespace haptometer::report {
namespace {

// one column that a narrow screen and A4 both hold; on paper no figure or row is cut in two
constexpr std::string_view kStyle = R"(
body { font: 16px/1.5 Helvetica, Arial, sans-serif; color: #222; max-width: 60rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin-top: 2rem; border-bottom: 1px solid #ccc; }
p.subtitle { color: #555; margin-top: .2rem; overflow-wrap: anywhere; }
p.warning { border-left: .3rem solid #d55e00; background: #fdf3ec; padding: .5rem 1rem; }
h3 { font-size: 1rem; margin: 1.5rem 0 .3rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .25rem .75rem .25rem 0;
         border-bottom: 1px solid #e4e4e4; overflow-wrap: anywhere; }
thead th { border-bottom: 2px solid #888; }
tbody th { font-weight: normal; color: #555; width: 11rem; }
figure { margin: 1.5rem 0; }
figure svg { width: 100%; height: auto; }
figcaption { color: #555; font-size: .9rem; }
@media print {
  body { margin: 0; max-width: none; font-size: 10pt; }
  figure, tr, p.warning { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
}
)";

// `text`, printable, with the characters that mean something to HTML written out
std::string Escaped(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : PrintableLines(text)) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

// a drawing without what only a file of its own begins with
std::string_view SvgElement(std::string_view svg) {
  const std::size_t begin = svg.find("<svg");
  return begin == std::string_view::npos ? svg : svg.substr(begin);
}

}  // namespace

HtmlPage::HtmlPage(std::string_view title, std::string_view subtitle) : title_(Escaped(title)) {
  body_ =
      fmt::format("<h1>{}</h1>\n<p class=\"subtitle\">{}</p>\n", Escaped(title), Escaped(subtitle));
}

void HtmlPage::Section(std::string_view heading) {
  body_ += fmt::format("<h2>{}</h2>\n", Escaped(heading));
}

void HtmlPage::Subsection(std::string_view heading) {
  body_ += fmt::format("<h3>{}</h3>\n", Escaped(heading));
}

void HtmlPage::Paragraph(std::string_view text) {
  body_ += fmt::format("<p>{}</p>\n", Escaped(text));
}

void HtmlPage::Warning(std::string_view text) {
  body_ += fmt::format("<p class=\"warning\">{}</p>\n", Escaped(text));
}

void HtmlPage::List(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += fmt::format("<li>{}</li>\n", Escaped(item));
  body_ += "</ul>\n";
}

void HtmlPage::Table(const std::vector<std::string>& header,
                     const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table>\n";
  if (!header.empty()) {
    body_ += "<thead><tr>";
    for (const std::string& cell : header) {
      body_ += fmt::format("<th scope=\"col\">{}</th>", Escaped(cell));
    }
    body_ += "</tr></thead>\n";
  }
  body_ += "<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    const std::size_t cells = header.empty() ? rows.front().size() : header.size();
    HAPTOMETER_CHECK(row.size() == cells, "{} cells, not {}", row.size(), cells);
    body_ += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string_view kind = i == 0 ? "th scope=\"row\"" : "td";
      body_ += fmt::format("<{}>{}</{}>", kind, Escaped(row[i]), kind.substr(0, 2));
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody>\n</table>\n";
}

Result<void> HtmlPage::Figure(std::string_view caption, const std::vector<plot::Panel>& panels) {
  const auto svg = plot::DrawSvg(panels);
  if (!svg) return std::unexpected(svg.error());
  ++figures_;
  body_ += fmt::format("<figure>\n{}\n<figcaption>Figure {}. {}</figcaption>\n</figure>\n",
                       SvgElement(*svg), figures_, Escaped(caption));
  return {};
}

std::string HtmlPage::Html() const {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      title_, kStyle, body_);
}

Result<void> WriteReport(const std::string& path, const HtmlPage& page) {
  return cli::WriteOutput(path, cli::kPageOutput, false, cli::Marked(page.Html()));
}

Result<void> CheckReportPath(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".html") {
    return Usage(path, "is to be a report, which is a page", "give it the ending .html");
  }
  return cli::CheckOutput(path, cli::kPageOutput, false);
}

}  // namespace haptometer::report
