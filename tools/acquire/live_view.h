#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "acquire/recorder/recorder.h"
#include "dsp/filter/butterworth.h"
#include "tools/acquire/live_meter.h"

namespace haptometer::tools {

/// Where and how a live view shows itself.
enum class LiveStyle : std::uint8_t {
  kNone,          ///< not at all
  kProgressLine,  ///< one line on stderr, written over twice a second
  kPlot,          ///< the same below a moving text plot
  kOutputLines,   ///< a line a second on stdout
  kErrorLines,    ///< a line a second on stderr
};

/// "1.234 mm  20-500 Hz: 200.1 um RMS, 225.00 Hz", or why there is no RMS. Figures of a channel in
/// other units than metres are shown in theirs.
[[nodiscard]] std::string LiveLine(const LiveFigures& figures, const dsp::BandPass& band);

/// Shows a LiveMeter while a recording runs, from a thread of its own: transforms and gnuplot take
/// tens of milliseconds, which the reading thread does not have.
class LiveView {
 public:
  /// Begins to show; `meter` must outlive the view. `output_closed` may be empty; it is called,
  /// from another thread, whenever a line on stdout could not be written.
  LiveView(const LiveMeter& meter, const dsp::BandPass& band, LiveStyle style,
           std::function<void()> output_closed = {});
  /// Ends at once and clears what was written over.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// The recording's own account; from the reading thread.
  void Progress(const acquire::RecordingSummary& summary);

 private:
  void Run();
  void Show();
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] std::string Plot();

  const LiveMeter& meter_;
  dsp::BandPass band_;
  LiveStyle style_;
  std::function<void()> output_closed_;
  bool has_gnuplot_ = true;
  std::size_t lines_shown_ = 0;  ///< of a plot, above the cursor

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool ends_ = false;
  std::optional<acquire::RecordingSummary> summary_;
  std::thread thread_;  ///< last: runs only while all the rest exists
};

}  // namespace haptometer::tools
