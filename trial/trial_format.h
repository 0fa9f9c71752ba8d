#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "trial/record.h"

/// What a trial.bin holds, in memory; docs/reference/formats.md has the same byte by byte.
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

/// A displacement that comes as whole counts of `step_m`.
[[nodiscard]] ChannelFormat DisplacementCounts(std::string name, double step_m);

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
  /// The number that the bits mean in `encoding`, before scale and offset; 4-byte encodings are in
  /// the low 32 bits.
  [[nodiscard]] double Number(Encoding encoding) const {
    const auto low = static_cast<std::uint32_t>(bits_);
    if (encoding == Encoding::kI32) return std::bit_cast<std::int32_t>(low);
    if (encoding == Encoding::kF32) return static_cast<double>(std::bit_cast<float>(low));
    HAPTOMETER_CHECK(encoding == Encoding::kF64, "encoding {}", static_cast<int>(encoding));
    return std::bit_cast<double>(bits_);
  }

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
  kExcluded,   ///< no part of any study from now on, for the reason in `text`
  kIncluded,   ///< takes kExcluded back; of both the last word counts
};

inline constexpr std::size_t kEventKindCount = 7;

/// "gap", "reconnect", "remark", "labels", "time_base", "excluded", "included".
[[nodiscard]] std::string_view Name(EventKind kind);

/// What happened beside the rows.
struct Event {
  EventKind kind = EventKind::kRemark;
  std::uint64_t row = 0;                        ///< rows written before it; the writer fills it in
  std::optional<std::int64_t> time_ns{};        ///< since the trial's start; empty where unknown
  std::string utc{};                            ///< of what is given later: when; else empty
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

/// The text of the remark behind the last row of a recording that was stopped before its end.
inline constexpr std::string_view kInterruptedText =
    "interrupted: stopped before the end that was asked for";

/// What the text of a remark begins with where its sensor doubts what was recorded.
inline constexpr std::string_view kDoubtMark = "doubt: ";

/// The metadata field of a source that numbers its rows, "0 to 99": every loss, up to whole turns
/// of the numbers, is an event with Event::missing.
inline constexpr std::string_view kLineNumbersField = "line_numbers";

/// The metadata field that says how late every line's time is at least, in seconds: its own time on
/// the wire. How much more the sensor, the driver and the system add is one constant that nobody
/// here can know; it does not touch intervals.
inline constexpr std::string_view kLatencyField = "latency_at_least_s";

/// The metadata field of a trial that is excluded from studies, with the reason. kExcluded sets it,
/// kIncluded removes it (MetadataOf); an export and a CSV carry it as any other field.
inline constexpr std::string_view kExcludedField = "excluded";

/// The members of Metadata that hold one text, by their keys in files (docs/reference/formats.md).
inline constexpr std::array<std::pair<std::string_view, std::string Metadata::*>, 8> kMetadataTexts{
    {{"source", &Metadata::source},
     {"sensor", &Metadata::sensor},
     {"head", &Metadata::head},
     {"hold", &Metadata::hold},
     {"laser_spot", &Metadata::laser_spot},
     {"utc_start", &Metadata::utc_start},
     {"host", &Metadata::host},
     {"command_line", &Metadata::command_line}}};

/// The JSON payloads of a trial.bin; keys in docs/reference/formats.md. Keys that this version does
/// not know are passed over. Texts that are not printable (base/text.h) are refused on their way
/// into a file and escaped on their way out of one.

/// Whether all texts of what is new are printable. Errors: Cause::kUsage, naming the first that is
/// not.
[[nodiscard]] Result<void> CheckTexts(const TrialHeader& header);
[[nodiscard]] Result<void> CheckTexts(const Event& event);

[[nodiscard]] std::string HeaderToJson(const TrialHeader& header);

/// Nothing when `json` is no header: not JSON, an unknown timing, role or encoding, no channel, a
/// scale that is not a number, a uniform timing without a rate.
[[nodiscard]] std::optional<TrialHeader> HeaderFromJson(std::string_view json);

/// The event's text, which a device may have had a part in, is made printable.
[[nodiscard]] std::string EventToJson(const Event& event);

/// Nothing when `json` is no event. An event of a kind that this version does not know becomes a
/// remark that names the kind.
[[nodiscard]] std::optional<Event> EventFromJson(std::string_view json);

/// What a finished or failed writer has to say.
struct TrialTotals {
  std::uint64_t rows = 0;       ///< appended
  std::uint64_t rows_kept = 0;  ///< of these, handed to the disk in whole blocks
  /// Values by status over all channels; index: SampleStatus.
  std::array<std::uint64_t, kSampleStatusCount> statuses{};
  /// Where the finished file is, if another program moved it meanwhile; empty where it is in place.
  std::string moved_to{};
};

[[nodiscard]] std::string TotalsToJson(const TrialTotals& totals);

}  // namespace haptometer::trial
