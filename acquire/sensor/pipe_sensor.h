#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/sample_format.h"
#include "acquire/sensor/sensor.h"
#include "acquire/transport/transport.h"
#include "base/error.h"
#include "trial/calibration.h"
#include "trial/trial_format.h"

namespace haptometer::acquire {

/// What the columns of a pipe are.
struct PipeChannels {
  std::vector<trial::ChannelFormat> formats;
  std::vector<trial::RawLimits> limits;       ///< one a channel, of the numbers as they come
  std::map<std::string, std::string> fields;  ///< the calibration, for metadata.fields
  trial::Averaging averaging{};               ///< of the sensor, where the calibration states it
};

/// Reads `NAME:UNIT,NAME:UNIT...`, e.g. `displacement:um,voltage:V,trigger`, by the rule for the
/// columns of a CSV (trial/import/table/csv_header.h: `displacement:um` is its displacement_um).
///
/// `calibration_path`: a calibration file (trial/calibration.h), or empty. A channel that it names
/// comes in volts or amperes, as the file says; its UNIT, if given, is theirs (`displacement:mV`).
/// Counts (SampleFormat::kI16) have no unit, and all but triggers and other channels need it.
/// Errors: Cause::kUsage for the text; the calibration file's.
[[nodiscard]] Result<PipeChannels> ReadPipeChannels(std::string_view text, SampleFormat format,
                                                    const std::string& calibration_path);

/// What a program pipes in.
struct PipeSetup {
  SampleFormat format = SampleFormat::kF64;
  double rate_hz = 0;     ///< rows a second, by the clock of the source; finite, > 0
  PipeChannels channels;  ///< at least one
};

/// Rows that came within some time of a monotonic clock.
struct RowsInTime {
  std::uint64_t spans = 0;
  std::int64_t rows = 0;
  MonotonicNs ns = 0;
};

/// Compares the rate at which rows come with the stated one. O(1) a wait for rows.
///
/// Judged are spans of 0.25 s and more between the times at which all that had come was read. In a
/// live span the reader waits at least half of the time, and rows come at most ten times as fast as
/// stated: otherwise the reader is slow, or a file is piped in. The first span is not judged: a
/// source may stall at its start.
class RowPace {
 public:
  /// `stated_hz` > 0.
  explicit RowPace(double stated_hz) : stated_hz_(stated_hz) {}

  /// `rows` had come in all, the last at `last_ns`, when the reader waited `waited_ns` for more.
  void AddWait(std::int64_t rows, MonotonicNs last_ns, MonotonicNs waited_ns);

  /// The live spans whose rate is more than 5 % above the stated one, or below it, where they are
  /// most of all live spans, three at least, and 1 s long at least.
  [[nodiscard]] std::optional<RowsInTime> AtOtherRate() const;

 private:
  void Judge(const RowsInTime& span);

  double stated_hz_;
  std::uint64_t spans_begun_ = 0;
  std::int64_t begin_rows_ = 0;  ///< of the present span
  MonotonicNs begin_ns_ = 0;
  MonotonicNs waited_ns_ = 0;
  std::uint64_t live_spans_ = 0;
  RowsInTime faster_;
  RowsInTime slower_;
};

/// Samples that another program, such as a DAQ's, writes to a pipe: a uniform grid at the stated
/// rate, whenever the bytes come. Rows that come at another rate than stated are a doubt (RowPace).
///
/// Lines of text before the first row (a heading) are passed over, with a remark; a later one that
/// is no row is a row of kBadFrame, so the grid holds. The end of the input ends the recording;
/// what is left of a cut row counts as discarded.
class PipeSensor final : public Sensor {
 public:
  /// `clock` must outlive the sensor.
  PipeSensor(std::unique_ptr<Transport> transport, PipeSetup setup, Clock& clock);

  /// Waits 60 s at most for the first whole row, and reads no more than 100 lines or 1 MiB that are
  /// none.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] Findings Found() const override;
  /// The next row has index 0; after Start() it is the first that came.
  [[nodiscard]] MonotonicNs Begin() override;
  /// kEnd at the end of the input. No allocation once the buffers have grown.
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] bool waits() const override { return true; }
  [[nodiscard]] std::uint64_t discarded_bytes() const override;

 private:
  Result<void> WaitForRow(const std::atomic<bool>& stop);
  RowState Read(MonotonicNs deadline);
  bool Fetch(MonotonicNs deadline);
  Error NoRow(std::string what) const;
  void Describe();

  PipeSetup setup_;
  Clock& clock_;
  std::unique_ptr<Transport> transport_;
  SampleParser parser_;
  trial::TrialHeader header_;
  Findings found_;
  std::vector<char> chunk_;
  std::vector<trial::Sample> row_;  ///< as parsed last
  bool has_row_ = false;            ///< row_ was not handed out yet
  bool has_ended_ = false;
  std::int64_t next_index_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::uint64_t heading_lines_ = 0;
  std::uint64_t heading_bytes_ = 0;
  std::string heading_;              ///< the last of these lines, or the first with commas
  bool has_decimal_commas_ = false;  ///< heading_ is a row where its commas are decimal signs
  RowPace pace_;
  std::int64_t rows_read_ = 0;  ///< lines that are no rows included
  MonotonicNs last_bytes_ns_ = 0;
};

}  // namespace haptometer::acquire
