#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/recorder/recording_statistics.h"
#include "acquire/sensor/sensor.h"
#include "dsp/filter/butterworth.h"
#include "dsp/filter/cascade.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What a live view shows of one channel at one moment; what is not known is empty.
struct LiveFigures {
  std::string channel;
  std::string unit;               ///< of level and band_rms: "m", "V"
  std::optional<double> level;    ///< the last measurement, less the tare
  std::optional<double> rate_hz;  ///< readings a second so far
  std::optional<double> band_rms;
  std::optional<double> tone_hz;  ///< the strongest in the band, where one stands out
  std::string no_band_because;    ///< why band_rms is empty; "" where it is not
  std::uint64_t readings = 0;
  std::uint64_t bad = 0;      ///< rows that hold no measurement
  std::uint64_t clipped = 0;  ///< of these: over, under, or at a converter's rail
};

/// The least and the greatest value within a twentieth of a second.
struct LiveExtremes {
  double time_s = 0;  ///< of the slot's beginning, since the first reading
  double least = 0;   ///< less the tare
  double greatest = 0;
};

/// Looks on while readings come: level, band RMS, strongest tone, counters, and the last seconds
/// for a plot. The first displacement channel in metres, or else the first channel.
///
/// The band-pass is one causal pass (dsp/filter/cascade.h) of the asked order with -3 dB at its
/// corners and starts from the first value, so a constant distance does not ring. It is designed
/// once the rate is known: a uniform source's is, others are counted for a second. The RMS is that
/// of the last second or four periods of the lower corner (whichever is longer, rounded up to a
/// power of two of readings); it is one for the eye: `analyze` says more of a recording.
///
/// A row that holds no measurement is not fed to the filter, whose state stands still meanwhile, so
/// up to three in a row only shift the phase by as many samples. After more, and after as many
/// missing on a uniform grid, the filter starts anew from the next measurement, and the RMS is
/// empty until what started it has decayed to 1e-3.
class LiveMeter {
 public:
  /// How far LiveExtremes reach back.
  static constexpr std::size_t kSlots = 100;
  static constexpr MonotonicNs kSlotNs = kNsPerS / 20;

  /// Programmer's error: a header without channels. `band` is one at some rate
  /// (tools/cli/shared_options.h).
  LiveMeter(const trial::TrialHeader& header, const dsp::BandPass& band);

  /// The reading thread's: O(1), allocates when the rate becomes known and never again. Measured:
  /// bench/live_meter_bench.cc.
  void Add(const acquire::Reading& reading);

  /// Any other thread's; holds Add() up only while the window is copied.
  [[nodiscard]] LiveFigures Figures() const;
  [[nodiscard]] std::vector<LiveExtremes> Extremes() const;  ///< oldest first

  [[nodiscard]] const std::string& unit() const { return format_.unit; }

 private:
  [[nodiscard]] MonotonicNs TimeOf(const acquire::Reading& reading) const;
  void LearnRate(MonotonicNs time_ns);
  void Design(double rate_hz);
  void Miss(std::uint64_t rows);
  void Filter(double value);
  void KeepExtremes(MonotonicNs time_ns, double value);

  std::size_t channel_;
  trial::ChannelFormat format_;
  trial::Timing timing_;
  double grid_rate_hz_;
  double tare_;
  dsp::BandPass band_;

  mutable std::mutex mutex_;  ///< over all below
  LiveFigures figures_;       ///< without what Figures() works out
  acquire::IntervalStatistics intervals_;
  std::uint64_t repeated_ = 0;
  std::optional<MonotonicNs> first_ns_;
  std::int64_t last_index_ = 0;

  double design_rate_hz_ = 0;           ///< 0: not known yet
  std::optional<dsp::Cascade> filter_;  ///< empty: the band cannot be observed
  bool starts_anew_ = true;             ///< the next measurement does
  std::uint64_t missing_in_a_row_ = 0;
  std::size_t ringing_ = 0;     ///< samples until a start has decayed
  std::size_t to_settle_ = 0;   ///< of these, still to come
  std::vector<double> window_;  ///< a ring of filtered values
  std::size_t next_ = 0;
  std::size_t filled_ = 0;

  std::vector<LiveExtremes> slots_;  ///< a ring
  std::int64_t last_slot_ = -1;      ///< since the first reading
};

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
