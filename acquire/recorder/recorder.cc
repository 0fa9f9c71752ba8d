#include "acquire/recorder/recorder.h"

#include <fmt/core.h>

#include <thread>
#include <utility>

#include "acquire/recorder/gap_counter.h"
#include "acquire/recorder/interval_statistics.h"
#include "acquire/recorder/row_queue.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kProgressEveryNs = kNsPerS / 2;

// the writing thread: everything that waits, then a flush when it is due
Result<void> WriteRows(RowQueue& queue, trial::TrialWriter& writer) {
  RowBatch batch;
  while (queue.Take(batch)) {
    for (std::size_t row = 0; row < batch.rows.size(); ++row) {
      if (auto appended = writer.Append(batch.RowOf(row)); !appended) return appended;
    }
    if (auto flushed = writer.FlushIfDue(); !flushed) return flushed;
  }
  return {};
}

// the reading thread's account of what came
class Tally {
 public:
  Tally(const Sensor& sensor, MonotonicNs origin_ns)
      : sensor_(sensor),
        timing_(sensor.header().timing),
        rate_hz_(sensor.header().rate_hz),
        origin_ns_(origin_ns),
        gaps_(timing_) {}

  // the time of a row since the beginning
  [[nodiscard]] MonotonicNs SinceBegin(const Reading& reading) const {
    if (timing_ != trial::Timing::kUniform) return reading.time_ns - origin_ns_;
    return NsFromSeconds(static_cast<double>(reading.index) / rate_hz_);
  }

  void Add(const Reading& reading) {
    ++summary_.readings;
    ++summary_.statuses[static_cast<std::size_t>(RowStatus(reading))];
    const MonotonicNs time_ns = SinceBegin(reading);
    summary_.elapsed_s = SecondsFromNs(time_ns);
    intervals_.Add(time_ns);
    gaps_.Add(reading);
  }

  [[nodiscard]] RecordingSummary Summary() const {
    RecordingSummary summary = summary_;
    summary.gaps = gaps_.gaps();
    summary.rate_hz = intervals_.RateHz();
    summary.interval_sd_s = intervals_.DeviationSeconds();
    summary.discarded_bytes = sensor_.discarded_bytes();
    return summary;
  }

  [[nodiscard]] std::uint64_t readings() const { return summary_.readings; }

 private:
  const Sensor& sensor_;
  trial::Timing timing_;
  double rate_hz_;
  MonotonicNs origin_ns_;
  RecordingSummary summary_;
  IntervalStatistics intervals_;
  GapCounter gaps_;
};

enum class Ending : std::uint8_t { kDone, kConnectionLost, kQueueRefused };

// the reading thread: rows into the queue until something ends the recording
Ending ReadRows(Sensor& sensor, Clock& clock, const std::atomic<bool>& stop,
                const RecordingLimits& limits, MonotonicNs origin_ns, RowQueue& queue, Tally& tally,
                const std::function<void(const RecordingSummary&)>& progress) {
  Reading reading;
  MonotonicNs progress_ns = clock.Now();
  while (!stop.load() && !(limits.readings && tally.readings() >= *limits.readings)) {
    const Outcome outcome = sensor.Next(reading);
    if (outcome == Outcome::kEnd) return Ending::kDone;
    if (outcome == Outcome::kGone) return Ending::kConnectionLost;
    // the end of the time: by the row's own time, or by the clock where no row comes
    const bool is_row = outcome == Outcome::kReading;
    const MonotonicNs elapsed_ns = is_row ? tally.SinceBegin(reading) : clock.Now() - origin_ns;
    if (limits.duration_ns && elapsed_ns >= *limits.duration_ns) return Ending::kDone;
    if (is_row) {
      if (!queue.Push(reading, origin_ns)) return Ending::kQueueRefused;
      tally.Add(reading);
    }
    if (progress && clock.Now() - progress_ns >= kProgressEveryNs) {
      progress_ns = clock.Now();
      progress(tally.Summary());
    }
  }
  return Ending::kDone;
}

}  // namespace

std::uint64_t RecordingSummary::repeated() const {
  return statuses[static_cast<std::size_t>(trial::SampleStatus::kRepeated)];
}

std::uint64_t RecordingSummary::bad() const {
  return readings - repeated() - statuses[static_cast<std::size_t>(trial::SampleStatus::kOk)];
}

Result<RecordingSummary> Record(Sensor& sensor, trial::TrialWriter& writer, Clock& clock,
                                const std::atomic<bool>& stop, const RecordingLimits& limits,
                                const std::function<void(const RecordingSummary&)>& progress) {
  RowQueue queue(limits.most_waiting_rows);
  Result<void> written;
  std::thread writing([&] {
    written = WriteRows(queue, writer);
    if (!written) queue.GiveUp();
  });
  const MonotonicNs origin_ns = sensor.Begin();
  Tally tally(sensor, origin_ns);
  const Ending ending = ReadRows(sensor, clock, stop, limits, origin_ns, queue, tally, progress);
  queue.Close();
  writing.join();
  if (!written) return std::unexpected(written.error());

  // the closing record, after the reason where there is one
  if (ending == Ending::kConnectionLost) {
    trial::Event remark;
    remark.text = "the connection was lost";
    if (auto added = writer.AddEvent(remark); !added) return std::unexpected(added.error());
  }
  if (auto finished = writer.Finish(); !finished) return std::unexpected(finished.error());
  RecordingSummary summary = tally.Summary();
  summary.connection_lost = ending == Ending::kConnectionLost;
  if (ending == Ending::kQueueRefused) {
    return Failed("",
                  fmt::format("the disk is slower than the sensor: stopped after {} readings, "
                              "which are kept",
                              summary.readings),
                  "record to a faster disk");
  }
  return summary;
}

}  // namespace haptometer::acquire
