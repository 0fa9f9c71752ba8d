#include "acquire/sensor/pipe_sensor.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "acquire/protocol/wire.h"
#include "base/band.h"
#include "base/text.h"
#include "trial/import/table/csv_header.h"

namespace haptometer::acquire {
namespace {

using trial::ChannelRole;

constexpr std::string_view kOption = "<channels>";
constexpr std::string_view kExample = "write e.g. displacement:m,voltage:V,trigger";

// one channel as it is written
struct Word {
  std::string name;
  std::string unit;
};

// NAME[:UNIT], separated by commas; no name twice
Result<std::vector<Word>> ReadWords(std::string_view text) {
  std::vector<Word> words;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view word = text.substr(0, comma);
    const std::size_t colon = word.find(':');
    Word read{.name = std::string(word.substr(0, colon)), .unit = ""};
    if (colon != std::string_view::npos) read.unit = word.substr(colon + 1);
    if (read.name.empty() || (colon != std::string_view::npos && read.unit.empty())) {
      return Usage(std::string(kOption), fmt::format("\"{}\" names no channel", word),
                   std::string(kExample));
    }
    if (std::ranges::find(words, read.name, &Word::name) != words.end()) {
      return Usage(std::string(kOption), fmt::format("{} is given twice", read.name),
                   fmt::format("call the second one {}_2", read.name));
    }
    words.push_back(std::move(read));
    if (words.size() > trial::kMaxChannels) {
      return Usage(std::string(kOption),
                   fmt::format("names more than {} channels", trial::kMaxChannels));
    }
    if (comma == std::string_view::npos) return words;
    text.remove_prefix(comma + 1);
  }
}

// SI unit of the role; "" where it has none
std::string UnitOf(ChannelRole role) {
  if (role == ChannelRole::kDisplacement) return "m";
  if (role == ChannelRole::kVoltage) return "V";
  return role == ChannelRole::kCurrent ? "A" : "";
}

// the role by which the name begins, for any unit
ChannelRole RoleOf(const std::string& name) {
  for (const ChannelRole role : {ChannelRole::kDisplacement, ChannelRole::kVoltage,
                                 ChannelRole::kCurrent, ChannelRole::kTrigger}) {
    const std::string_view word = Name(role);
    if (name == word || (name.starts_with(word) && name[word.size()] == '_')) return role;
  }
  return ChannelRole::kOther;
}

// the quantity whose unit that is; nothing of none
std::optional<ChannelRole> QuantityIn(const std::string& unit) {
  for (const ChannelRole role :
       {ChannelRole::kDisplacement, ChannelRole::kVoltage, ChannelRole::kCurrent}) {
    const std::string cell = fmt::format("{}_{}", Name(role), unit);
    if (trial::ReadCsvColumns({"time_s", cell}, std::string(kOption))) return role;
  }
  return std::nullopt;
}

// the error of a channel in the unit of another quantity, as of displacement:V
std::unexpected<Error> InUnitOf(ChannelRole role, const std::string& name,
                                const std::string& unit) {
  const std::string_view of_unit = Name(role);
  return Usage(std::string(kOption),
               fmt::format("{} cannot be in {}, which is a unit of {}", name, unit, of_unit),
               RoleOf(name) == ChannelRole::kDisplacement
                   ? fmt::format("give its <calibration>; without one name it {}:{}, or {}:m where "
                                 "it comes in metres",
                                 of_unit, unit, name)
                   : fmt::format("name it {}:{}", of_unit, unit));
}

// what a CSV's column of that name and unit is
Result<trial::CsvColumn> ColumnOf(const std::string& name, const std::string& unit) {
  // the unit is read as from a CSV heading, "displacement_mm"; its first column is a time
  const std::string cell = unit.empty() ? name : fmt::format("{}_{}", name, unit);
  const auto columns = trial::ReadCsvColumns({"time_s", cell}, std::string(kOption));
  if (columns && columns->back().kind == trial::CsvColumnKind::kValue) return columns->back();
  if (const auto other = QuantityIn(unit); other && !unit.empty())
    return InUnitOf(*other, name, unit);
  const std::string said = unit.empty() ? name : fmt::format("{}:{}", name, unit);
  return Usage(std::string(kOption), fmt::format("{} does not state its unit", said),
               std::string(kExample));
}

bool IsQuantity(ChannelRole role) { return !UnitOf(role).empty(); }

// a channel that comes in its own unit
Result<trial::ChannelFormat> PlainChannel(const Word& word, SampleFormat format) {
  trial::ChannelFormat channel;
  channel.encoding = EncodingOf(format);
  // a count has a size only by its calibration; a trigger needs none
  if (format == SampleFormat::kI16) {
    channel.name = word.name;
    channel.role = RoleOf(word.name);
    if (!IsQuantity(channel.role)) return channel;
    return Usage(std::string(kOption),
                 fmt::format("the size of a count of {} is not stated", word.name),
                 fmt::format("give <calibration> a file with a table [{}]", word.name));
  }
  HAPTOMETER_LET(const auto column, ColumnOf(word.name, word.unit));
  channel.name = column.name;
  channel.role = column.role;
  channel.unit = column.unit;
  // SI unit per number, from the unit that is stated
  channel.scale = column.factor;
  return channel;
}

// a channel that comes in the unit of the DAQ
Result<trial::RawLimits> CalibrateChannel(const Word& word,
                                          const trial::ChannelCalibration& calibration,
                                          trial::ChannelFormat* channel) {
  // unit after the calibration: SI
  channel->unit = UnitOf(channel->role);
  // counts: volts or amperes per count, from the calibration
  if (channel->encoding == trial::Encoding::kI32) {
    if (!calibration.input_per_count) {
      return Usage("<calibration>",
                   fmt::format("does not state the size of a count of {}", channel->name),
                   fmt::format("add {} to its table",
                               calibration.input_unit == "A" ? "a_per_count" : "v_per_count"));
    }
    return Calibrate(calibration, *calibration.input_per_count, calibration.input_at_zero_count,
                     channel);
  }
  // numbers: volts or amperes per number, from the unit that is stated
  double input_per_raw = 1;
  if (!word.unit.empty()) {
    const auto column = ColumnOf(calibration.input_unit == "A" ? "current" : "voltage", word.unit);
    if (!column) {
      return Usage(std::string(kOption),
                   fmt::format("{} comes in {} by its calibration, not in {}", word.name,
                               calibration.input_unit, word.unit),
                   fmt::format("write {}:{}", word.name, calibration.input_unit));
    }
    input_per_raw = column->factor;
  }
  return Calibrate(calibration, input_per_raw, 0, channel);
}

}  // namespace

Result<PipeChannels> ReadPipeChannels(std::string_view text, SampleFormat format,
                                      const std::string& calibration_path) {
  HAPTOMETER_LET(const auto words, ReadWords(text));
  for (const Word& word : words) {
    if (format == SampleFormat::kI16 && !word.unit.empty()) {
      return Usage(std::string(kOption), fmt::format("counts of {} have no unit", word.name),
                   "leave it out: the calibration states the size of a count");
    }
  }

  // the calibration file is read for these names and roles
  trial::Calibration calibration;
  if (!calibration_path.empty()) {
    std::vector<trial::ChannelFormat> names;
    names.reserve(words.size());
    for (const Word& word : words) names.push_back({.name = word.name, .role = RoleOf(word.name)});
    HAPTOMETER_LET(auto read, trial::ReadCalibrationFile(calibration_path, names));
    calibration = std::move(read);
  }

  PipeChannels channels;
  if (!calibration_path.empty()) channels.fields = CalibrationFields(calibration);
  channels.averaging = calibration.averaging;
  // a channel of the calibration, else one that comes in its own unit
  for (const Word& word : words) {
    trial::ChannelFormat channel{.name = word.name, .role = RoleOf(word.name)};
    channel.encoding = EncodingOf(format);
    trial::RawLimits limits;
    if (const auto found = calibration.channels.find(word.name);
        found != calibration.channels.end()) {
      HAPTOMETER_LET(const auto calibrated, CalibrateChannel(word, found->second, &channel));
      limits = calibrated;
    } else {
      HAPTOMETER_LET(auto plain, PlainChannel(word, format));
      channel = std::move(plain);
    }
    channels.formats.push_back(std::move(channel));
    channels.limits.push_back(limits);
  }
  return channels;
}

namespace {

constexpr MonotonicNs kSliceNs = 100'000'000;
// how long the program that writes may take to its first row
constexpr MonotonicNs kPatienceNs = 60 * kNsPerS;
constexpr std::size_t kChunkBytes = 65'536;
// a heading is longer than this nowhere
constexpr std::uint64_t kMostHeadingLines = 100;
constexpr std::size_t kMostShown = 24;  // characters of a line that is no row
constexpr std::uint64_t kMostHeadingBytes = 1 << 20;

std::string FormName(const PipeSetup& setup) {
  return fmt::format("{} x {}", setup.channels.formats.size(), Name(setup.format));
}

// a span lasts 0.25 s at least
constexpr MonotonicNs kShortestSpanNs = kNsPerS / 4;
// rows that come over ten times as fast as stated are those of a file
constexpr double kFastestLive = 10;
// a rate within 5 % of the stated one is no other rate
constexpr double kTolerance = 0.05;
// a single stall is one span: three show a rate
constexpr std::uint64_t kLeastSpans = 3;

}  // namespace

void RowPace::AddWait(std::int64_t rows, MonotonicNs last_ns, MonotonicNs waited_ns) {
  // no row yet: the first span begins with the first one
  if (rows == 0) return;
  const RowsInTime span{.spans = 1, .rows = rows - begin_rows_, .ns = last_ns - begin_ns_};
  if (spans_begun_ == 0 || span.ns >= kShortestSpanNs) {
    // the first span is not judged
    if (++spans_begun_ > 2) Judge(span);
    begin_rows_ = rows;
    begin_ns_ = last_ns;
    waited_ns_ = 0;
  }
  // this wait belongs to the span that is open now
  waited_ns_ += waited_ns;
}

void RowPace::Judge(const RowsInTime& span) {
  const double rate = static_cast<double>(span.rows) / SecondsFromNs(span.ns) / stated_hz_;
  const bool is_live = 2 * waited_ns_ >= span.ns && rate <= kFastestLive;
  if (!is_live) return;
  ++live_spans_;
  if (std::abs(rate - 1) <= kTolerance) return;
  RowsInTime& other = rate > 1 ? faster_ : slower_;
  other.spans += span.spans;
  other.rows += span.rows;
  other.ns += span.ns;
}

std::optional<RowsInTime> RowPace::AtOtherRate() const {
  for (const RowsInTime& other : {faster_, slower_}) {
    const bool are_most = 2 * other.spans > live_spans_ && other.spans >= kLeastSpans;
    if (are_most && other.ns >= kNsPerS) return other;
  }
  return std::nullopt;
}

PipeSensor::PipeSensor(std::unique_ptr<Transport> transport, PipeSetup setup, Clock& clock)
    : setup_(std::move(setup)),
      clock_(clock),
      transport_(std::move(transport)),
      parser_(setup_.format, setup_.channels.limits),
      chunk_(kChunkBytes),
      row_(setup_.channels.formats.size()),
      pace_(setup_.rate_hz) {
  HAPTOMETER_CHECK(std::isfinite(setup_.rate_hz) && setup_.rate_hz > 0, "rate_hz = {}",
                   setup_.rate_hz);
  HAPTOMETER_CHECK(setup_.channels.limits.size() == row_.size(), "{} limits, {} channels",
                   setup_.channels.limits.size(), row_.size());
}

Result<void> PipeSensor::Start(const std::atomic<bool>& stop) {
  HAPTOMETER_TRY(WaitForRow(stop));
  Describe();
  return {};
}

// skips heading lines up to the first row, within bounds of time, lines and bytes
Result<void> PipeSensor::WaitForRow(const std::atomic<bool>& stop) {
  const MonotonicNs deadline = clock_.Now() + kPatienceNs;
  while (clock_.Now() < deadline && heading_lines_ <= kMostHeadingLines &&
         bytes_read_ <= kMostHeadingBytes) {
    if (stop.load()) {
      return Failed(transport_->name(), "was not recorded: interrupted before the first row");
    }
    const RowState state = Read(std::min(deadline, clock_.Now() + kSliceNs));
    has_row_ = state == RowState::kRow;
    if (has_row_) {
      // bytes of the heading are not counted as damage
      heading_bytes_ = parser_.discarded_bytes();
      return {};
    }
    // the last heading line is shown where no row follows, or the first with decimal commas
    if (state == RowState::kBadRow) {
      ++heading_lines_;
      if (!has_decimal_commas_) heading_ = Printable(parser_.line().substr(0, kMostShown));
      has_decimal_commas_ = has_decimal_commas_ || parser_.IsRowWithDecimalCommas();
    } else if (has_ended_) {
      return std::unexpected(NoRow("ended before a whole row came"));
    }
  }
  if (bytes_read_ > kMostHeadingBytes) {
    return std::unexpected(NoRow(fmt::format("{} bytes came, and no row", bytes_read_)));
  }
  return std::unexpected(NoRow(fmt::format("no row came in {} s", kPatienceNs / kNsPerS)));
}

Error PipeSensor::NoRow(std::string what) const {
  if (has_decimal_commas_) {
    return {Cause::kCannotAnswer, transport_->name(),
            fmt::format("a comma separates numbers, and \"{}\" is a row of {} only where it is the "
                        "decimal sign",
                        heading_, FormName(setup_)),
            "write decimal points, e.g. with tr , . behind the program; where commas do separate, "
            "state each number by <channels>"};
  }
  if (heading_lines_ > 0) {
    what = fmt::format("no line is a row of {}: \"{}\"", FormName(setup_), heading_);
  } else if (parser_.waiting_bytes() > 0) {
    what += fmt::format(" ({} bytes did)", parser_.waiting_bytes());
  }
  return {
      Cause::kCannotAnswer, transport_->name(), std::move(what),
      fmt::format(
          "check that the program writes {}, or state what it writes by <channels> and <format>",
          FormName(setup_))};
}

void PipeSensor::Describe() {
  header_.timing = trial::Timing::kUniform;
  header_.rate_hz = setup_.rate_hz;
  header_.channels = setup_.channels.formats;
  header_.metadata.sensor = "pipe";
  header_.metadata.source = fmt::format("{}, {}", transport_->Source(), FormName(setup_));
  header_.metadata.nominal_rate_hz = setup_.rate_hz;
  header_.metadata.fields = setup_.channels.fields;
  StateAveraging(setup_.channels.averaging, &header_.metadata);
  // the rate is the user's statement: the pipe carries no times
  found_.Note(FindingKind::kStatedRate, {{"rate_hz", setup_.rate_hz},
                                         {"observable_hz", HighestObservableHz(setup_.rate_hz)},
                                         {"half_rate_hz", 0.5 * setup_.rate_hz}});
  if (heading_lines_ > 0) {
    found_.Note(FindingKind::kHeadingLines, {{"lines", heading_lines_}, {"first", heading_}});
  }
}

Findings PipeSensor::Found() const {
  Findings found = found_;
  if (const auto other = pace_.AtOtherRate()) {
    const double elapsed_s = SecondsFromNs(other->ns);
    found.Doubt(FindingKind::kRowRateDiffers,
                {{"rate_hz", static_cast<double>(other->rows) / elapsed_s},
                 {"elapsed_s", elapsed_s},
                 {"stated_hz", setup_.rate_hz}});
  }
  return found;
}

RowState PipeSensor::Read(MonotonicNs deadline) {
  // rows that are already in the parser come before new bytes
  RowState state = parser_.Next(row_);
  if (state == RowState::kNeedMore && !has_ended_ && Fetch(deadline)) state = parser_.Next(row_);
  if (state != RowState::kNeedMore) ++rows_read_;
  return state;
}

// bytes for the parser; false where none came
bool PipeSensor::Fetch(MonotonicNs deadline) {
  const MonotonicNs now = clock_.Now();
  ReadOutcome outcome = transport_->Read(chunk_, now);
  // nothing is there: all rows so far had come with the bytes before, and the source is waited for
  if (outcome.state == ReadState::kTimeout) {
    outcome = transport_->Read(chunk_, deadline);
    pace_.AddWait(rows_read_, last_bytes_ns_, clock_.Now() - now);
  }
  has_ended_ = outcome.state == ReadState::kGone;
  if (outcome.state != ReadState::kBytes) return false;
  last_bytes_ns_ = clock_.Now();
  bytes_read_ += outcome.bytes;
  parser_.Feed(std::string_view(chunk_.data(), outcome.bytes));
  return true;
}

MonotonicNs PipeSensor::Begin() {
  // times are index / rate, from 0 at each beginning
  next_index_ = 0;
  return clock_.Now();
}

Outcome PipeSensor::Next(Reading& reading) {
  // the row that Start() has read is the first
  if (!std::exchange(has_row_, false) && Read(clock_.Now() + kSliceNs) == RowState::kNeedMore) {
    return has_ended_ ? Outcome::kEnd : Outcome::kNothing;
  }
  reading.index = next_index_++;
  reading.samples.assign(row_.begin(), row_.end());
  return Outcome::kReading;
}

std::uint64_t PipeSensor::discarded_bytes() const {
  // a part of a row at the end is damage too
  return parser_.discarded_bytes() - heading_bytes_ + (has_ended_ ? parser_.waiting_bytes() : 0);
}

}  // namespace haptometer::acquire
