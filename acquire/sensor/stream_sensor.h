#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "acquire/protocol/stream_line.h"
#include "acquire/sensor/line_link.h"
#include "acquire/sensor/sensor.h"
#include "trial/calibration.h"

namespace haptometer::acquire {

/// Lines that are missing, by the number that each line carries.
///
/// The number goes from 0 to turn - 1 and begins again. A damaged line carries none, but was there.
/// Whole turns cannot be seen: turn lines lost in a row look like none.
class LineCounter {
 public:
  /// `turn` >= 1.
  explicit LineCounter(std::int32_t turn) : turn_(turn) {}

  /// How many lines are missing directly before the one numbered `number` (0 <= number < turn);
  /// none before the first.
  [[nodiscard]] std::int64_t LostBefore(std::int32_t number);

  /// A line came whose number cannot be read.
  void CountDamaged() { ++damaged_; }

 private:
  std::int32_t turn_;
  std::optional<std::int32_t> last_;
  std::int64_t damaged_ = 0;  ///< since the last number
};

/// How a free-running sensor sends.
struct StreamSetup {
  int baud = 921600;
  StreamFormat format;
  trial::Averaging averaging{};  ///< of the sensor, where it is stated: the lines do not say it
};

/// A sensor that sends one line per reading without being asked.
///
/// What arrived before the beginning is no part of a recording: it is thrown away, and with it the
/// line that it cut. A line of another form is a row with the status kBadFrame, and the next
/// delimiter is where it goes on. A line's time is the arrival of the bytes it came with, less the
/// time that those behind it needed on the wire; times never go back (a line behind a full buffer
/// gets the time of the line before). Where the lines carry a counter, Reading::lost_before says
/// how many are missing before a line.
class StreamSensor final : public Sensor {
 public:
  /// `clock` must outlive the sensor.
  StreamSensor(std::unique_ptr<Transport> transport, StreamSetup setup, Clock& clock);

  /// Waits for one line of the right form, 3 s at most. Behind a virtual terminal or a socket it
  /// first asks whether the head is an emulated one, and gives it 0.2 s to say so.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  [[nodiscard]] Findings Found() const override;
  [[nodiscard]] MonotonicNs Begin() override;
  [[nodiscard]] Outcome Next(Reading& reading) override;
  /// What came before the recording began, and the line that its beginning cut, do not count.
  [[nodiscard]] std::uint64_t discarded_bytes() const override {
    return link_.discarded_bytes() - discarded_before_;
  }

 private:
  void AskWhetherEmulated();
  Error NoLines(const std::string& example) const;
  void MakeHeader();

  StreamSetup setup_;
  Clock& clock_;
  LineLink link_;
  trial::TrialHeader header_;
  MonotonicNs identity_deadline_ns_ = 0;
  bool is_emulated_ = false;
  std::uint64_t discarded_before_ = 0;
  std::uint64_t lines_ = 0;  ///< of the right form, since the beginning
  MonotonicNs begin_ns_ = 0;
  MonotonicNs last_ns_ = 0;
  bool drop_line_ = false;  ///< the next line was cut by the beginning
  LineCounter counter_;
};

}  // namespace haptometer::acquire
