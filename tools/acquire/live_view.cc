#include "tools/acquire/live_view.h"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "base/text.h"
#include "tools/acquire/recording_document.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

using std::chrono::milliseconds;

constexpr double kMmPerM = 1e3;
constexpr double kUmPerM = 1e6;
// lines of a plot at most
constexpr int kPlotLines = 18;

// columns and lines of the terminal on stderr; 80 by 24 where it states none
winsize TerminalSize() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size : winsize{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
}

bool IsLength(const LiveFigures& figures) { return figures.unit == "m"; }

}  // namespace

std::string LiveLine(const LiveFigures& figures, const dsp::BandPass& band) {
  std::string line;
  // the level: lengths in mm, other quantities in the channel's unit
  if (!figures.level) {
    line = "no measurement";
  } else if (IsLength(figures)) {
    line = fmt::format("{:.4f} mm", *figures.level * kMmPerM);
  } else {
    line = fmt::format("{:.5g} {}", *figures.level, figures.unit);
  }
  // the RMS in the band, or the reason why it is not determined
  line += fmt::format("  {:g}-{:g} Hz: ", band.lower_hz, band.upper_hz);
  if (!figures.band_rms) {
    line += figures.no_band_because;
  } else if (IsLength(figures)) {
    line += fmt::format("{:.4g} um RMS", *figures.band_rms * kUmPerM);
  } else {
    line += fmt::format("{:.4g} {} RMS", *figures.band_rms, figures.unit);
  }
  if (figures.band_rms) {
    line += figures.tone_hz ? fmt::format(", {:.2f} Hz", *figures.tone_hz) : ", no tone";
  }
  line += fmt::format("  {} bad", figures.bad);
  if (figures.clipped > 0) line += fmt::format(" ({} clipped)", figures.clipped);
  return line;
}

LiveView::LiveView(const LiveMeter& meter, const dsp::BandPass& band, LiveStyle style,
                   std::function<void()> output_closed)
    : meter_(meter), band_(band), style_(style), output_closed_(std::move(output_closed)) {
  if (style_ != LiveStyle::kNone) thread_ = std::thread([this] { Run(); });
}

LiveView::~LiveView() {
  if (style_ == LiveStyle::kNone) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
  // clear the progress line: the report follows in its place
  if (style_ == LiveStyle::kProgressLine) fmt::print(stderr, "\r\x1b[K");
  // the last plot stays on the screen
  if (style_ == LiveStyle::kPlot) fmt::print(stderr, "\n");
}

void LiveView::Progress(const acquire::RecordingSummary& summary) {
  const std::lock_guard lock(mutex_);
  summary_ = summary;
}

void LiveView::Run() {
  const bool is_terminal = style_ == LiveStyle::kProgressLine || style_ == LiveStyle::kPlot;
  // a terminal twice per second, lines for programs once per second
  const milliseconds period(is_terminal ? 500 : 1000);
  auto due = std::chrono::steady_clock::now() + period;
  std::unique_lock lock(mutex_);
  while (!wake_.wait_until(lock, due, [this] { return ends_; })) {
    lock.unlock();
    Show();
    lock.lock();
    // after a slow plot the next is due one period later, or at once: no accumulated backlog
    due = std::max(due + period, std::chrono::steady_clock::now());
  }
}

void LiveView::Show() {
  const std::string text = Text();
  switch (style_) {
    case LiveStyle::kNone:
      break;
    case LiveStyle::kProgressLine:
      fmt::print(stderr, "\r{}\x1b[K", text);
      break;
    case LiveStyle::kPlot: {
      // over the previous plot (lines_shown_ lines); no alternate screen, so the scrollback stays
      const std::string plot = Plot();
      const std::string up = lines_shown_ > 0 ? fmt::format("\x1b[{}A", lines_shown_) : "";
      fmt::print(stderr, "\r{}\x1b[J{}{}", up, plot, text);
      lines_shown_ = static_cast<std::size_t>(std::ranges::count(plot, '\n'));
      break;
    }
    case LiveStyle::kOutputLines:
      // not fmt::print, which throws an exception where the output is closed
      std::fputs((text + "\n").c_str(), stdout);
      if (std::fflush(stdout) != 0 && output_closed_) output_closed_();
      break;
    case LiveStyle::kErrorLines:
      fmt::print(stderr, "{}\n", text);
      break;
  }
}

std::string LiveView::Text() const {
  std::string text = LiveLine(meter_.Figures(), band_);
  {
    const std::lock_guard lock(mutex_);
    if (summary_) text += "  " + ProgressLine(*summary_);
  }
  // a line that wraps cannot be overwritten by a carriage return
  const bool is_terminal = style_ == LiveStyle::kProgressLine || style_ == LiveStyle::kPlot;
  if (is_terminal) text.resize(std::min<std::size_t>(text.size(), TerminalSize().ws_col - 1U));
  return text;
}

std::string LiveView::Plot() {
  const bool is_length = meter_.unit() == "m";
  const double factor = is_length ? kMmPerM : 1;
  // least and greatest value of each slot in turn: a vibration appears as a filled band
  plot::Series extremes;
  for (const LiveExtremes& slot : meter_.Extremes()) {
    for (const double value : {slot.least, slot.greatest}) {
      extremes.x.push_back(slot.time_s);
      extremes.y.push_back(value * factor);
    }
  }
  // two slots are the least for a line
  if (!has_gnuplot_ || extremes.x.size() < 4) return {};
  const winsize size = TerminalSize();
  const auto drawn = plot::DrawText({.title = is_length ? "distance / mm" : "level",
                                     .x_label = "time / s",
                                     .y_label = "",
                                     .series = {extremes}},
                                    std::min<int>(size.ws_col, 120) - 1,
                                    std::min<int>(size.ws_row - 2, kPlotLines));
  has_gnuplot_ = drawn.has_value();  // after a failure not started again
  return drawn ? *drawn : std::string();
}

}  // namespace haptometer::tools
