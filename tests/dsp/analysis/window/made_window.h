#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "dsp/analysis/window/measured_window.h"
#include "dsp/readings/segments.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {

/// A filtered record and a window of all of it, whose numbers the test sets. What the window refers
/// to is held here, so it is neither copied nor moved.
struct MadeWindow {
  explicit MadeWindow(std::vector<double> values_m, double rate_hz = 10e3)
      : record(RecordOf(std::move(values_m), rate_hz)),
        rows(record),
        segments(SplitAtHoles(rows, 0, {}).value()),
        signal(
            BandSignal::Filter({rows, 0, segments.parts.at(0)}, Designed({}, rate_hz), 1).value()),
        chosen{&signal, 0, signal.size()},
        window{.head = record, .chosen = chosen, .question = question, .analysis = analysis} {
    analysis.record.rate_hz = rate_hz;
    window.rows = record.rows;
    // fitted samples as long as the window
    window.samples = {std::vector<double>(record.rows, 0.0), rate_hz};
  }
  MadeWindow(const MadeWindow&) = delete;
  MadeWindow& operator=(const MadeWindow&) = delete;
  MadeWindow(MadeWindow&&) = delete;
  MadeWindow& operator=(MadeWindow&&) = delete;
  ~MadeWindow() = default;

  trial::Record record;
  trial::RecordRows rows;
  Segments segments;
  BandSignal signal;
  ChosenPart chosen;
  BandQuestion question;
  BandAnalysis analysis;
  MeasuredWindow window;
};

/// 1 um at 100 Hz for 2 s at 10 kHz.
inline std::vector<double> TwoSeconds() { return Samples(10e3, 20'000, 0, {{1e-6, 100}}); }

}  // namespace haptometer::dsp
