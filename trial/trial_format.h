#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trial/record.h"

/// What a trial.bin holds, in memory; docs/formats.md has the same byte by byte.
namespace haptometer::trial {

/// How a channel's raw values are stored: as the source sent them, bit for bit.
enum class Encoding : std::uint8_t {
  kI32,  ///< whole counts; value = counts * scale + offset
  kF32,
  kF64,
};

/// "i32", "f32", "f64".
[[nodiscard]] std::string_view Name(Encoding encoding);
/// 4, 4, 8.
[[nodiscard]] std::size_t BytesOf(Encoding encoding);

/// One channel: what its raw values mean. The calibration is copied in, so a file explains itself.
struct ChannelFormat {
  std::string name{};  ///< as the source calls it: "displacement", "CH1"
  ChannelRole role = ChannelRole::kOther;
  std::string unit{};  ///< of the value: "m", "V", "A"; "" where unknown
  Encoding encoding = Encoding::kF64;
  double scale = 1;   ///< value = raw * scale + offset, in `unit`; finite
  double offset = 0;  ///< in `unit`; finite
  double range_min = -std::numeric_limits<double>::infinity();  ///< in `unit`
  double range_max = std::numeric_limits<double>::infinity();   ///< in `unit`
  double resolution = 0;  ///< one step, in `unit`; 0 where unknown
};

/// The head of a trial.
struct TrialHeader {
  Timing timing = Timing::kUniform;
  /// Rows per second of the grid (kUniform: finite, > 0). For the other timings it is not used;
  /// what the source promises stands in metadata.nominal_rate_hz.
  double rate_hz = 0;
  std::vector<ChannelFormat> channels{};  ///< 1 to kMaxChannels
  Metadata metadata{};                    ///< metadata.labels: those known before the recording
};

inline constexpr std::size_t kMaxChannels = 1024;

/// An empty channel that is what `format` says.
[[nodiscard]] Channel ChannelOf(const ChannelFormat& format);

/// The head of a trial that would hold `record`: channels of doubles in their units, its metadata.
/// The rate is that of its longest stretch.
[[nodiscard]] TrialHeader HeaderOf(const Record& record);

/// One raw value as sent. Kept as bits, so that even a float's NaN comes back as it was.
class RawValue {
 public:
  RawValue() = default;
  [[nodiscard]] static RawValue Counts(std::int32_t counts) {
    return RawValue(static_cast<std::uint32_t>(counts));
  }
  [[nodiscard]] static RawValue F32(float value) {
    return RawValue(std::bit_cast<std::uint32_t>(value));
  }
  [[nodiscard]] static RawValue F64(double value) {
    return RawValue(std::bit_cast<std::uint64_t>(value));
  }
  [[nodiscard]] static RawValue Bits(std::uint64_t bits) { return RawValue(bits); }

  [[nodiscard]] std::uint64_t bits() const { return bits_; }
  /// The number that the bits mean in `encoding`, before scale and offset.
  [[nodiscard]] double Number(Encoding encoding) const;

 private:
  explicit RawValue(std::uint64_t bits) : bits_(bits) {}
  std::uint64_t bits_ = 0;
};

/// One value of one channel with what the sensor said of it.
struct Sample {
  RawValue raw;  ///< in the channel's encoding; any value where the status is not a measurement
  SampleStatus status = SampleStatus::kOk;
};

enum class EventKind : std::uint8_t {
  kGap,        ///< readings were lost before row `row`
  kReconnect,  ///< the device went away and came back before row `row`
  kRemark,     ///< something worth knowing, in `text`
  kLabels,     ///< labels given later; the last word counts
  kTimeBase,   ///< one stretch of the cleaned time base
};

/// "gap", "reconnect", "remark", "labels", "time_base".
[[nodiscard]] std::string_view Name(EventKind kind);

/// What happened beside the rows.
struct Event {
  EventKind kind = EventKind::kRemark;
  std::uint64_t row = 0;                        ///< rows written before it; the writer fills it in
  std::optional<std::int64_t> time_ns{};        ///< since the trial's start; empty where unknown
  std::string text{};                           ///< in words; may be empty
  std::map<std::string, std::string> labels{};  ///< kLabels
  std::optional<Stretch> stretch{};             ///< kTimeBase
  /// Rows that are missing directly before `row`; a value that is empty itself: some, of a number
  /// that is not known.
  std::optional<std::optional<std::uint64_t>> missing{};

  /// Whether rows may be missing here. Gaps and reconnects of older files carry no `missing`.
  [[nodiscard]] bool BeginsStretch() const {
    return missing || kind == EventKind::kGap || kind == EventKind::kReconnect;
  }
};

/// The metadata field of a source that numbers its rows, "0 to 99": every loss, up to whole turns
/// of the numbers, is an event with Event::missing.
inline constexpr std::string_view kLineNumbersField = "line_numbers";

}  // namespace haptometer::trial
