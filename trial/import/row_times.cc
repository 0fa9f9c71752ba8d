#include "trial/import/row_times.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "trial/import/segmented_times.h"

namespace haptometer::trial {
namespace {

using Segment = CsvRows::Segment;

bool IsRate(double rate_hz, double wanted_hz, double tolerance) {
  return std::abs(rate_hz / wanted_hz - 1) <= tolerance;
}

double RateOf(const Record& part) {
  return std::ranges::max_element(part.stretches, {}, &Stretch::rows)->rate_hz;
}

class TimeSetter {
 public:
  TimeSetter(const std::string& name, const TimeWords& words, const ImportOptions& options,
             std::vector<std::string>* remarks)
      : name_(name), words_(words), options_(options), remarks_(*remarks) {}

  // no times but by the rate
  void Uniform(Record* record) {
    const auto& clock = words_.clock;
    Stretch stretch{.rows = record->rows};
    stretch.rate_hz = options_.rate_hz ? *options_.rate_hz : 1 / clock->interval_s;
    const bool is_replaced =
        options_.rate_hz && clock && !IsRate(*options_.rate_hz, 1 / clock->interval_s, 1e-3);
    if (is_replaced) {
      remarks_.push_back(fmt::format("--rate {:.6g} Hz replaces {:.6g} Hz by '{}'",
                                     *options_.rate_hz, 1 / clock->interval_s, clock->from));
    } else if (clock && clock->start_s) {
      stretch.start_s = *clock->start_s;
    } else {
      remarks_.emplace_back("the time of the first row is not in the file; it is put at 0 s");
    }
    record->stretches = {stretch};
  }

  Result<void> One(Segment segment, Record* record) {
    auto part = Read(std::move(segment));
    if (!part) return std::unexpected(part.error());
    Adopt(std::move(*part), record);
    return {};
  }

  // all segments, each when the file says
  Result<void> All(std::vector<Segment> segments, Record* record) {
    if (words_.segment_starts_s.size() != segments.size()) return WhichSegment(segments);
    SegmentedTimes times;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      auto part = Read(std::move(segments[s]));
      if (!part) return std::unexpected(part.error());
      if (!times.Append(*part, words_.segment_starts_s[s])) {
        return CannotAnswer(name_,
                            fmt::format("says that segment {} begins before the one ahead "
                                        "of it ends",
                                        s + 1),
                            "read one of them: --segment 1");
      }
    }
    std::move(times).Complete(record);
    return {};
  }

 private:
  static void Adopt(Record part, Record* record) {
    record->stretches = std::move(part.stretches);
    record->raw_times_s = std::move(part.raw_times_s);
    record->timing = part.timing;
    record->times_are_known = part.times_are_known;
  }

  std::unexpected<Error> WhichSegment(const std::vector<Segment>& segments) const {
    return CannotAnswer(
        name_,
        fmt::format(
            "its times begin again at line {}: either {} segments, of which it does not say "
            "when they were, or rows out of order",
            segments[1].line, segments.size()),
        fmt::format("read one of them (--segment 1 to {}), or sort the rows", segments.size()));
  }

  // one segment's times as a record without channels
  Result<Record> Read(Segment segment) {
    Record part;
    part.rows = segment.rows;
    if (segment.rows < 2) {
      return CannotAnswer(fmt::format("{}: line {}", name_, segment.line),
                          "is a segment of one row, which has no rate", "remove the line");
    }
    const std::size_t repeated = segment.times.repeated();
    if (words_.clock) {
      if (const auto stretch = segment.times.By(*words_.clock)) {
        part.stretches = {*stretch};
        return part;
      }
    }
    const double first_s = segment.times.times_s().front();
    if (!std::move(segment.times).Complete(Timing::kUniform, {}, &part)) {
      return CannotAnswer(
          name_,
          fmt::format("{} of {} times are those of the row before, and no even grid explains it",
                      repeated, segment.rows),
          "print the times with more digits, or leave them out (--columns) and say --rate");
    }
    if (repeated > 0) {
      remarks_.push_back(
          fmt::format("{} of {} times are those of the row before, too few digits being printed; "
                      "they are rebuilt on the even grid that explains all",
                      repeated, segment.rows));
    }
    return Agree(std::move(part), first_s);
  }

  // times and header must say the same
  Result<Record> Agree(Record part, double first_s) {
    if (!words_.clock) return part;
    const double stated_hz = 1 / words_.clock->interval_s;
    const double rate_hz = RateOf(part);
    if (IsRate(rate_hz, stated_hz, 1e-3)) return part;
    const std::string both = fmt::format("its times say {:.6g} rows a second and '{}' says {:.6g}",
                                         rate_hz, words_.clock->from, stated_hz);
    if (!options_.rate_hz) return CannotAnswer(name_, both, "say which is right with --rate");
    remarks_.push_back(both + "; --rate decides");
    if (IsRate(rate_hz, *options_.rate_hz, 0.01)) return part;
    Record stated;
    stated.rows = part.rows;
    stated.stretches = {{.rows = part.rows, .start_s = first_s, .rate_hz = stated_hz}};
    return stated;
  }

  const std::string& name_;
  const TimeWords& words_;
  const ImportOptions& options_;
  std::vector<std::string>& remarks_;
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

Result<void> SetForeignTimes(const std::string& name, const TimeWords& words,
                             const ImportOptions& options, CsvRows* rows, Record* record,
                             std::vector<std::string>* remarks) {
  std::vector<Segment> segments = std::move(rows->segments());
  TimeSetter setter(name, words, options, remarks);
  if (options.segment) {
    if (*options.segment < 1 || *options.segment > segments.size()) {
      return CannotAnswer(
          name, fmt::format("has {} segment{}", segments.size(), segments.size() == 1 ? "" : "s"),
          "say --segment with one of them, counted from 1");
    }
    if (rows->has_times()) {
      Segment wanted = std::move(segments[*options.segment - 1]);
      Cut(wanted, record);
      return setter.One(std::move(wanted), record);
    }
  }
  if (!rows->has_times()) {
    setter.Uniform(record);
    return {};
  }
  if (segments.size() == 1) return setter.One(std::move(segments[0]), record);
  return setter.All(std::move(segments), record);
}

}  // namespace haptometer::trial
