#include "trial/import/table/row_times.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "trial/import/table/written_twice.h"

namespace haptometer::trial {
namespace {

using Segment = CsvRows::Segment;

// relative deviation of the rate within `tolerance`
bool IsRate(double rate_hz, double wanted_hz, double tolerance) {
  return std::abs(rate_hz / wanted_hz - 1) <= tolerance;
}

// rate of the longest segment, Hz
double RateOf(const Record& part) {
  return std::ranges::max_element(part.stretches, {}, &Stretch::rows)->rate_hz;
}

// what NoTimes tells of a segment, whose times are used up by then
struct Repeats {
  explicit Repeats(const Segment& segment)
      : rows(segment.rows),
        repeated(segment.times.repeated().size()),
        line(segment.repeat_line),
        copies(segment.copies),
        first_copy(segment.first_copy + 1) {}

  std::size_t rows, repeated, line, copies, first_copy;
};

// the error for times that determine no rate
std::unexpected<Error> NoTimes(const std::string& name, const Repeats& repeats) {
  const auto& [rows, repeated, line, copies, first_copy] = repeats;
  if (copies > 0) {
    return CannotAnswer(
        name,
        fmt::format("{} of {} rows repeat the time and the values of the row before "
                    "(first row {}), as if they were written twice",
                    copies, rows, first_copy),
        "remove these rows");
  }
  if (repeated == 0) {
    return CannotAnswer(name, "has times that lie too close for a rate to be stated",
                        "check the unit of its time column");
  }
  return CannotAnswer(name,
                      fmt::format("{} of {} rows {} the time of the row before (first in line {}), "
                                  "and no uniform grid explains it",
                                  repeated, rows, repeated == 1 ? "has" : "have", line),
                      "print the times with more digits, or remove these rows; only where no row "
                      "is missing, leave the times out (<columns>) and give <rate>");
}

// what became of times that repeat: their rows are left out, or a grid of `part` explains them
void NoteRepeats(const Repeats& repeats, std::size_t left_out, const Record& part,
                 Findings& findings) {
  if (left_out > 0) {
    findings.Doubt(FindingKind::kRowsExcluded,
                   {{"excluded", left_out}, {"rows", repeats.rows}, {"line", repeats.line}});
  } else if (repeats.repeated > 0 && part.timing == Timing::kUniform) {
    // times that repeat are one segment; either end's uncertainty is one of its span
    const Stretch& line = part.stretches.front();
    const double span_s = static_cast<double>(line.rows) / line.rate_hz;
    findings.Note(FindingKind::kTimesRebuilt,
                  {{"repeated", repeats.repeated},
                   {"rows", repeats.rows},
                   {"rate_hz", line.rate_hz},
                   {"rate_uncertainty_hz",
                    line.rate_hz * std::numbers::sqrt2 * line.time_uncertainty_s / span_s}});
  }
}

// times of one or several segments of a table, by printed times and stated clock
class TimeSetter {
 public:
  TimeSetter(const std::string& name, const TimeWords& words, const ImportOptions& options,
             Findings* findings)
      : name_(name), words_(words), options_(options), findings_(*findings) {}

  Result<void> One(Segment segment, Record* record) {
    HAPTOMETER_LET(auto part, Read(std::move(segment)));
    record->stretches = std::move(part.stretches);
    record->raw_times_s = std::move(part.raw_times_s);
    record->timing = part.timing;
    record->times_are_known = part.times_are_known;
    LeaveOutRows(left_out_, record);
    return {};
  }

  // all segments, each at the start that the file states
  Result<void> All(std::vector<Segment> segments, Record* record) {
    if (words_.segment_starts_s.size() != segments.size()) return WhichSegment(segments);
    SegmentedTimes times;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      HAPTOMETER_LET(auto part, Read(std::move(segments[s])));
      if (!times.Append(part, words_.segment_starts_s[s])) {
        return CannotAnswer(name_,
                            fmt::format("states that segment {} begins before the one ahead "
                                        "of it ends",
                                        s + 1),
                            "read one of them: <segment> 1");
      }
    }
    std::move(times).Complete(record);
    LeaveOutRows(left_out_, record);
    return {};
  }

  // one segment's times as a record without channels
  Result<Record> Read(Segment segment) {
    Record part;
    part.rows = segment.rows;
    // one row has no interval, hence no rate
    if (segment.rows < 2) {
      return CannotAnswer(fmt::format("{}: line {}", name_, segment.line),
                          "is a segment of one row, which has no rate", "remove the line");
    }
    const Repeats repeats(segment);
    // the stated clock overrides the printed times where their digits explain the difference
    if (words_.clock && segment.copies == 0) {
      if (const auto stretch = segment.times.By(*words_.clock)) {
        part.stretches = {*stretch};
        return part;
      }
    }
    const double first_s = segment.times.origin_s() + segment.times.times_s().front();
    // else the printed times: as grid where one agrees with them, or as they are
    const auto left_out =
        std::move(segment.times).Complete(Timing::kUniform, {}, segment.copies > 0, &part);
    if (!left_out) return NoTimes(name_, repeats);
    // rows of the segment become rows of the record
    for (const std::size_t row : *left_out) left_out_.push_back(segment.first_row + row);
    NoteRepeats(repeats, left_out->size(), part, findings_);
    return Agree(std::move(part), first_s);
  }

  [[nodiscard]] const std::vector<std::size_t>& left_out() const { return left_out_; }

 private:
  std::unexpected<Error> WhichSegment(const std::vector<Segment>& segments) const {
    // no oscilloscope writes segments of so few rows
    constexpr std::size_t kFewRows = 10;
    if (segments.size() > kFewRows &&
        segments.back().first_row + segments.back().rows < kFewRows * segments.size()) {
      return CannotAnswer(
          name_,
          fmt::format("its times go back in {} places, the first in line {}: the column is no "
                      "time, or the rows are out of order",
                      segments.size() - 1, segments[1].line),
          "name the columns in the order of the file (<columns>): are two exchanged?");
    }
    return CannotAnswer(
        name_,
        fmt::format("its times begin again at line {}: either {} segments, whose times are not "
                    "stated, or rows out of order",
                    segments[1].line, segments.size()),
        fmt::format("read one of them (<segment> 1 to {}), or sort the rows", segments.size()));
  }

  // printed times and stated clock must agree to 0.1 %; a rate of the user decides between them
  Result<Record> Agree(Record part, double first_s) {
    if (!words_.clock) return part;
    const double stated_hz = 1 / words_.clock->interval_s;
    const double rate_hz = RateOf(part);
    if (IsRate(rate_hz, stated_hz, 1e-3)) return part;
    if (!options_.rate_hz) {
      return CannotAnswer(name_,
                          fmt::format("its times give {:.6g} rows per second and '{}' gives {:.6g}",
                                      rate_hz, words_.clock->from, stated_hz),
                          "give the right one as <rate>");
    }
    findings_.Note(FindingKind::kRateContradicted,
                   {{"rate_hz", rate_hz},
                    {"stated_hz", stated_hz},
                    {"stated_by", std::string(words_.clock->from)}});
    // the user's rate is that of the times, to 1 %, or else that of the header
    if (IsRate(rate_hz, *options_.rate_hz, 0.01)) return part;
    Record stated;
    stated.rows = part.rows;
    stated.stretches = {{.rows = part.rows, .start_s = first_s, .rate_hz = stated_hz}};
    return stated;
  }

  const std::string& name_;
  const TimeWords& words_;
  const ImportOptions& options_;
  Findings& findings_;
  std::vector<std::size_t> left_out_;  // rows of the record
};

// the rows of `segment` alone
void Cut(const Segment& segment, Record* record) {
  const auto first = static_cast<std::ptrdiff_t>(segment.first_row);
  const auto last = first + static_cast<std::ptrdiff_t>(segment.rows);
  for (Channel& channel : record->channels) {
    channel.values = {channel.values.begin() + first, channel.values.begin() + last};
    channel.statuses = {channel.statuses.begin() + first, channel.statuses.begin() + last};
  }
  record->rows = segment.rows;
}

}  // namespace

void LeaveOutRows(const std::vector<std::size_t>& rows, Record* record) {
  if (rows.empty()) return;
  // each channel is compacted in place, in one pass
  for (Channel& channel : record->channels) {
    std::size_t kept = 0;
    auto next = rows.begin();
    for (std::size_t row = 0; row < channel.values.size(); ++row) {
      if (next != rows.end() && *next == row) {
        ++next;
        continue;
      }
      channel.values[kept] = channel.values[row];
      channel.statuses[kept] = channel.statuses[row];
      ++kept;
    }
    channel.values.resize(kept);
    channel.statuses.resize(kept);
  }
  record->rows -= rows.size();
}

// start + i / rate; the rate of the user overrides the stated one
Stretch UniformTimes(const TimeWords& words, const ImportOptions& options, std::size_t rows,
                     Findings* findings) {
  const auto& clock = words.clock;
  Stretch stretch{.rows = rows};
  stretch.rate_hz = options.rate_hz ? *options.rate_hz : 1 / clock->interval_s;
  const bool is_replaced =
      options.rate_hz && clock && !IsRate(*options.rate_hz, 1 / clock->interval_s, 1e-3);
  // the stated start belongs to the stated interval, so it is not used with another rate
  if (is_replaced) {
    findings->Note(FindingKind::kRateReplaced, {{"rate_hz", *options.rate_hz},
                                                {"stated_hz", 1 / clock->interval_s},
                                                {"stated_by", std::string(clock->from)}});
  } else if (clock && clock->start_s) {
    stretch.start_s = *clock->start_s;
  } else {
    findings->Note(FindingKind::kStartAssumed);
  }
  return stretch;
}

Result<Record> ReadSegmentTimes(const std::string& name, const TimeWords& words,
                                const ImportOptions& options, CsvRows::Segment segment,
                                std::vector<std::size_t>* left_out, Findings* findings) {
  TimeSetter setter(name, words, options, findings);
  auto part = setter.Read(std::move(segment));
  left_out->insert(left_out->end(), setter.left_out().begin(), setter.left_out().end());
  return part;
}

// a rate of the user and the rate of the times must agree to 1 %
Result<void> CheckRate(const std::string& name, const ImportOptions& options,
                       const Record& record) {
  constexpr double kTolerance = 0.01;
  if (!options.rate_hz) return {};
  const double rate_hz = RateOf(record);
  if (std::abs(rate_hz - *options.rate_hz) <= kTolerance * *options.rate_hz) return {};
  return CannotAnswer(
      name,
      fmt::format("its times give {:.6g} rows per second and <rate> gives {:.6g} Hz", rate_hz,
                  *options.rate_hz),
      "leave out <rate>, or name the time's unit in <columns> (time_ms), or - to "
      "leave the times out");
}

// times of a table of this program: one segment
Result<void> SetOwnTimes(const std::string& name, Timing timing, std::vector<Stretch> stretches,
                         CsvRows* rows, Record* record, Findings* findings) {
  Segment segment = std::move(rows->segments()[0]);
  MarkRowsWrittenTwice(record->channels, &segment);
  const Repeats repeats(segment);
  const auto left_out =
      std::move(segment.times).Complete(timing, std::move(stretches), segment.copies > 0, record);
  if (!left_out) return NoTimes(name, repeats);
  record->rows = segment.rows;
  LeaveOutRows(*left_out, record);
  NoteRepeats(repeats, left_out->size(), *record, *findings);
  return {};
}

Result<void> SetForeignTimes(const std::string& name, const TimeWords& words,
                             const ImportOptions& options, CsvRows* rows, Record* record,
                             Findings* findings) {
  // one segment by number, or all of them
  std::vector<Segment> segments = std::move(rows->segments());
  for (Segment& segment : segments) MarkRowsWrittenTwice(record->channels, &segment);
  TimeSetter setter(name, words, options, findings);
  if (options.segment) {
    if (*options.segment < 1 || *options.segment > segments.size()) {
      return CannotAnswer(
          name, fmt::format("has {} segment{}", segments.size(), segments.size() == 1 ? "" : "s"),
          "give <segment> with one of them, counted from 1");
    }
    // without times segments cannot be distinguished
    if (rows->has_times()) {
      Segment wanted = std::move(segments[*options.segment - 1]);
      Cut(wanted, record);
      // rows of the segment now begin at row 0 of the record
      wanted.first_row = 0;
      return setter.One(std::move(wanted), record);
    }
  }
  // no time column: the rate or the stated clock alone
  if (!rows->has_times()) {
    if (!options.rate_hz && MayGroupThousands(*words.clock, rows->has_commas())) {
      return CannotAnswer(name,
                          fmt::format("states {} by '{}', which may have a decimal sign or group "
                                      "thousands",
                                      words.clock->printed, words.clock->from),
                          "give the rows per second (<rate>)");
    }
    const Stretch whole = UniformTimes(words, options, record->rows, findings);
    record->stretches = {whole};
    if (rows->numbers()) record->stretches = rows->numbers()->Divide(whole, findings);
    return {};
  }
  if (segments.size() == 1) return setter.One(std::move(segments[0]), record);
  return setter.All(std::move(segments), record);
}

bool SegmentedTimes::IsBehind(double start_s) const {
  if (stretches_.empty()) return true;
  const Stretch& last = stretches_.back();
  // time of the last row = start + (rows - 1) / rate
  return start_s > last.start_s + static_cast<double>(last.rows - 1) / last.rate_hz;
}

// all times of the part are shifted by `shift_s`; rows follow those of the parts before
bool SegmentedTimes::Append(const Record& part, double shift_s) {
  if (!IsBehind(part.stretches.front().start_s + shift_s)) return false;
  const std::size_t before =
      stretches_.empty() ? 0 : stretches_.back().first_row + stretches_.back().rows;
  // raw times for all rows or for none: rows of a grid have the grid's times
  if (!part.raw_times_s.empty() && !has_raw_) {
    has_raw_ = true;
    Record taken;
    taken.rows = before;
    taken.stretches = stretches_;
    raw_times_s_.reserve(before + part.rows);
    for (std::size_t row = 0; row < before; ++row) raw_times_s_.push_back(TimeOf(taken, row));
  }
  if (has_raw_) {
    raw_times_s_.reserve(before + part.rows);
    for (std::size_t row = 0; row < part.rows; ++row) {
      raw_times_s_.push_back(
          shift_s + (part.raw_times_s.empty() ? TimeOf(part, row) : part.raw_times_s[row]));
    }
  }
  stretches_.reserve(stretches_.size() + part.stretches.size());
  for (Stretch stretch : part.stretches) {
    stretch.first_row += before;
    stretch.start_s += shift_s;
    stretches_.push_back(stretch);
  }
  return true;
}

void SegmentedTimes::Complete(Record* record) && {
  record->stretches = std::move(stretches_);
  if (!has_raw_) return;
  record->timing = Timing::kPolled;
  record->times_are_known = true;
  record->raw_times_s = std::move(raw_times_s_);
}

}  // namespace haptometer::trial
