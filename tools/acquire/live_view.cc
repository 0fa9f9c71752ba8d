#include "tools/acquire/live_view.h"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>
#include <vector>

#include "base/band.h"
#include "base/error.h"
#include "base/text.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/tone.h"
#include "dsp/statistics/moments.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/recording_document.h"
#include "tools/cli/terminal.h"
#include "tools/plot/gnuplot.h"
#include "trial/record.h"

namespace haptometer::tools {
namespace {

// least time and number of readings from which a rate is computed
constexpr MonotonicNs kLearningNs = kNsPerS;
constexpr std::uint64_t kLeastToLearn = 16;
constexpr std::uint64_t kMostMissing = 3;  // as many as dsp/readings/segments.h interpolates
// remainder of the filter's starting transient below which its output is used
constexpr double kDecayed = 1e-3;
// periods of the lower corner in the RMS window
constexpr double kWindowPeriods = 4;
constexpr std::size_t kLongestWindow = std::size_t{1} << 20;  // 8 MiB

// readings at a rail of the range or of the converter
bool IsClipped(trial::SampleStatus status) {
  return status == trial::SampleStatus::kOver || status == trial::SampleStatus::kUnder ||
         status == trial::SampleStatus::kClipped;
}

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

LiveMeter::LiveMeter(const trial::TrialHeader& header, const dsp::BandPass& band)
    : channel_(trial::DisplacementChannel(header).value_or(0)),
      timing_(header.timing),
      grid_rate_hz_(header.rate_hz),
      tare_(trial::DisplacementChannel(header) ? header.metadata.tare_m : 0),
      band_(band) {
  HAPTOMETER_CHECK(!header.channels.empty(), "no channel");
  format_ = header.channels[channel_];
  band_.corners = dsp::Corners::kEach;  // one causal pass has its -3 dB points at the corners
  figures_.channel = format_.name;
  figures_.unit = format_.unit;
  slots_.reserve(kSlots);
  // a uniform source states its rate: no learning is needed
  if (timing_ == trial::Timing::kUniform) Design(grid_rate_hz_);
}

// time of the reading: index / rate on a uniform grid, else its arrival
MonotonicNs LiveMeter::TimeOf(const acquire::Reading& reading) const {
  return timing_ == trial::Timing::kUniform
             ? NsFromSeconds(static_cast<double>(reading.index) / grid_rate_hz_)
             : reading.time_ns;
}

void LiveMeter::Add(const acquire::Reading& reading) {
  const trial::Sample& sample = reading.samples[channel_];
  const MonotonicNs time_ns = TimeOf(reading);
  const std::lock_guard lock(mutex_);
  if (!first_ns_) {
    first_ns_ = time_ns;
    // so that the first reading has no rows missing before it
    last_index_ = reading.index - 1;
  }
  ++figures_.readings;
  const auto missing = static_cast<std::uint64_t>(reading.lost_before);
  if (!intervals_.Explains(time_ns, missing)) intervals_.Restart();
  intervals_.Add(time_ns, missing);
  if (sample.status == trial::SampleStatus::kRepeated) ++repeated_;
  if (design_rate_hz_ == 0) LearnRate(time_ns);
  // indices that are skipped are lost rows of the uniform grid
  if (timing_ == trial::Timing::kUniform) {
    const std::int64_t skipped = reading.index - last_index_ - 1;
    last_index_ = reading.index;
    if (skipped > 0) Miss(static_cast<std::uint64_t>(skipped));
  }
  // no value for the filter, whose state stays: up to kMostMissing rows shift the phase only
  if (!IsMeasurement(sample.status)) {
    ++figures_.bad;
    if (IsClipped(sample.status)) ++figures_.clipped;
    Miss(1);
    return;
  }
  missing_in_a_row_ = 0;
  const double value = ValueOf(format_, sample) - tare_;
  figures_.level = value;
  if (filter_) Filter(value);
  KeepExtremes(time_ns, value);
}

// the rate from the intervals so far, after kLearningNs and kLeastToLearn readings
void LiveMeter::LearnRate(MonotonicNs time_ns) {
  if (time_ns - *first_ns_ < kLearningNs || figures_.readings < kLeastToLearn) return;
  if (const auto rate_hz = intervals_.RateHz()) Design(*rate_hz);
}

void LiveMeter::Design(double rate_hz) {
  design_rate_hz_ = rate_hz;
  // part of readings that are new: repeated ones add no information
  const double fresh = figures_.readings == 0 ? 1
                                              : 1 - static_cast<double>(repeated_) /
                                                        static_cast<double>(figures_.readings);
  if (!Observes(rate_hz * fresh, band_.upper_hz)) {
    figures_.no_band_because =
        fmt::format("{:g}-{:g} Hz needs {:.4g} new readings/s, {:.4g} come", band_.lower_hz,
                    band_.upper_hz, NeededRateHz(band_.upper_hz), rate_hz * fresh);
    return;
  }
  const auto design = dsp::DesignBandPass(band_, rate_hz);
  HAPTOMETER_CHECK(design, "{}", design.error().Text());
  filter_.emplace(*design);
  // samples until the starting transient has decayed to kDecayed
  ringing_ = dsp::RingingSamples(*design, kDecayed);
  // window of 1 s or kWindowPeriods of the lower corner, rounded up to a power of two
  const double wanted = rate_hz * std::max(1.0, kWindowPeriods / band_.lower_hz);
  window_.resize(wanted < static_cast<double>(kLongestWindow)
                     ? std::bit_ceil(static_cast<std::size_t>(wanted))
                     : kLongestWindow);
}

void LiveMeter::Miss(std::uint64_t rows) {
  // more rows than can be interpolated: the filter restarts from the next measurement
  missing_in_a_row_ += rows;
  if (missing_in_a_row_ > kMostMissing) starts_anew_ = true;
}

void LiveMeter::Filter(double value) {
  // restart in the steady state of this value, with an empty window
  if (starts_anew_) {
    starts_anew_ = false;
    filter_->StartFrom(value);
    to_settle_ = ringing_;
    next_ = filled_ = 0;
  }
  double filtered = 0;
  filter_->Process(std::span(&value, 1), std::span(&filtered, 1));
  if (to_settle_ > 0) {
    --to_settle_;
    return;
  }
  window_[next_] = filtered;
  next_ = (next_ + 1) & (window_.size() - 1);  // modulo, as the size is a power of two
  filled_ = std::min(filled_ + 1, window_.size());
}

void LiveMeter::KeepExtremes(MonotonicNs time_ns, double value) {
  const std::int64_t slot = (time_ns - *first_ns_) / kSlotNs;
  if (slot < last_slot_) return;  // time went back: no slot exists for it
  if (slot == last_slot_) {
    LiveExtremes& now = slots_[static_cast<std::size_t>(slot) % kSlots];
    now.least = std::min(now.least, value);
    now.greatest = std::max(now.greatest, value);
    return;
  }
  // slots without readings keep their former times, which Extremes() finds out of its span
  const LiveExtremes begun{SecondsFromNs(slot * kSlotNs), value, value};
  // time -1 marks a slot that was never filled
  slots_.resize(kSlots, {-1, 0, 0});
  slots_[static_cast<std::size_t>(slot) % kSlots] = begun;
  last_slot_ = slot;
}

LiveFigures LiveMeter::Figures() const {
  LiveFigures figures;
  std::vector<double> recent;
  double rate_hz = 0;
  // copy under the lock; the transform below runs without it
  {
    const std::lock_guard lock(mutex_);
    figures = figures_;
    figures.rate_hz = intervals_.RateHz();
    rate_hz = design_rate_hz_;
    if (filter_) {
      recent.assign(window_.begin(), window_.begin() + static_cast<long>(filled_));
      // in order of time; a ring that is not full begins at its first entry
      if (filled_ == window_.size()) {
        std::ranges::rotate(recent, recent.begin() + static_cast<long>(next_));
      }
    }
  }
  if (!figures.no_band_because.empty()) return figures;
  // half of kWindowPeriods periods are the least for an RMS
  if (recent.empty() ||
      static_cast<double>(recent.size()) < kWindowPeriods / 2 * rate_hz / band_.lower_hz) {
    figures.no_band_because = "settling";
    return figures;
  }
  figures.band_rms = dsp::Rms(recent);
  const auto tone = dsp::StrongestTone(
      recent, {rate_hz, band_.lower_hz, band_.upper_hz, band_.upper_hz - band_.lower_hz});
  // the rate of all readings is more accurate than the rate of the design: rescale the frequency
  const bool is_grid = timing_ == trial::Timing::kUniform;
  if (tone) figures.tone_hz = tone->frequency_hz * (is_grid ? 1 : *figures.rate_hz / rate_hz);
  return figures;
}

std::vector<LiveExtremes> LiveMeter::Extremes() const {
  std::vector<LiveExtremes> extremes;
  const std::lock_guard lock(mutex_);
  if (slots_.empty()) return extremes;
  const double oldest_s =
      SecondsFromNs((last_slot_ - static_cast<std::int64_t>(kSlots) + 1) * kSlotNs);
  for (const LiveExtremes& slot : slots_) {
    // slots older than the ring are excluded; 1e-9 s tolerates rounding of the slot's time
    if (slot.time_s >= std::max(oldest_s, 0.0) - 1e-9) extremes.push_back(slot);
  }
  std::ranges::sort(extremes, {}, &LiveExtremes::time_s);
  return extremes;
}

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
  if (style_ == LiveStyle::kProgressLine) cli::PrintError("\r\x1b[K");
  // the last plot stays on the screen
  if (style_ == LiveStyle::kPlot) cli::PrintError("\n");
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
      cli::PrintError(fmt::format("\r{}\x1b[K", text));
      break;
    case LiveStyle::kPlot: {
      // over the previous plot (lines_shown_ lines); no alternate screen, so the scrollback stays
      const std::string plot = Plot();
      const std::string up = lines_shown_ > 0 ? fmt::format("\x1b[{}A", lines_shown_) : "";
      cli::PrintError(fmt::format("\r{}\x1b[J{}{}", up, plot, text));
      lines_shown_ = static_cast<std::size_t>(std::ranges::count(plot, '\n'));
      break;
    }
    case LiveStyle::kOutputLines:
      // not fmt::print, which throws an exception where the output is closed
      std::fputs((text + "\n").c_str(), stdout);
      if (std::fflush(stdout) != 0 && output_closed_) output_closed_();
      break;
    case LiveStyle::kErrorLines:
      cli::PrintError(fmt::format("{}\n", text));
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
