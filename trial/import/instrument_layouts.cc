#include "trial/import/instrument_layouts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "trial/import/printed_number.h"
#include "trial/import/printed_unit.h"

namespace haptometer::trial {
namespace {

using Cells = std::vector<std::string_view>;

std::string_view FirstValue(const TableBeginning& beginning, std::string_view key) {
  const auto values = ValuesOf(beginning.keys, key);
  return values.empty() ? "" : values[0];
}

Cells CellsBelow(const TableBeginning& beginning, std::string_view first_cell, std::size_t down) {
  for (std::size_t i = 0; i + down < beginning.above.size(); ++i) {
    const char separator = beginning.rows[0].separator;
    if (!LowerCase(SplitCells(beginning.above[i].text, separator)[0]).starts_with(first_cell)) {
      continue;
    }
    return SplitCells(beginning.above[i + down].text, separator);
  }
  return {};
}

// names for the value columns, in order; the unit each has stays
void NameChannels(const Cells& names, ForeignTable* table) {
  std::size_t at = 0;
  for (CsvColumn& column : table->columns) {
    if (column.kind != CsvColumnKind::kValue || at >= names.size()) continue;
    if (!names[at].empty()) column.name = std::string(names[at]);
    ++at;
  }
}

// "Segments,2,SegmentSize,502", and "#2,22-Jan-2015 11:35:11,0.00123"
Result<void> AddLecroySegments(const TableBeginning& beginning, const std::string& name,
                               ForeignTable* table) {
  if (!beginning.above.empty()) {
    const Cells first = SplitCells(beginning.above[0].text, beginning.rows[0].separator);
    if (first.size() > 2 && LowerCase(first[2]) == "histogram") {
      return CannotAnswer(name, "holds a histogram, not a waveform",
                          "save the trace itself as a waveform");
    }
  }
  for (const std::string_view comment : beginning.comments) {
    const Cells cells = SplitCells(comment, beginning.rows[0].separator);
    const auto start = ReadNumberWithComma(cells.back());
    if (cells.size() < 3 || !ReadNumber(cells[0].substr(1)) || !start || !std::isfinite(*start)) {
      continue;
    }
    table->segment_starts_s.push_back(*start);
  }
  return {};
}

// "Physical channel, Start Time, Sample Interval, Sample Count" and a line for each channel
Result<void> AddPxiClock(const TableBeginning& beginning, const std::string& name,
                         ForeignTable* table) {
  const Cells titles = CellsBelow(beginning, "physical channel", 0);
  const auto at = [&](const Cells& cells, std::string_view title) -> std::optional<double> {
    for (std::size_t i = 0; i < std::min(titles.size(), cells.size()); ++i) {
      if (LowerCase(titles[i]) != title) continue;
      const auto number = ReadNumberWithComma(cells[i]);
      return number && std::isfinite(*number) ? number : std::nullopt;
    }
    return std::nullopt;
  };
  for (std::size_t down = 1;; ++down) {
    const Cells cells = CellsBelow(beginning, "physical channel", down);
    const auto interval_s = at(cells, "sample interval");
    if (!interval_s) break;
    const auto rows = at(cells, "sample count");
    if (rows && *rows >= 1 && *rows < 1e15) table->stated_rows = static_cast<std::size_t>(*rows);
    const StatedClock clock{*interval_s, at(cells, "start time"), "Sample Interval"};
    const bool differs = table->clock && (table->clock->interval_s != clock.interval_s ||
                                          table->clock->start_s != clock.start_s);
    if (!(*interval_s > 0) || !std::isfinite(1 / *interval_s) || differs) {
      return CannotAnswer(name, "has channels of different clocks, or one without",
                          "write channels of one clock into one file");
    }
    table->clock = clock;
  }
  return {};
}

// "t0,5/7/2021  12:00:47.056435,5/7/2021  12:00:47.056436"
void AddElvisStarts(const TableBeginning& beginning, ForeignTable* table) {
  const auto starts = ValuesOf(beginning.keys, "t0");
  double latest_s = 0;
  for (const std::string_view start : starts) {
    const auto clock_s = ReadClock(start);
    const auto first_s = ReadClock(starts[0]);
    if (clock_s && first_s) latest_s = std::max(latest_s, *clock_s - *first_s);
  }
  if (latest_s > 0) {
    table->remarks.push_back(
        fmt::format("its channels begin up to {:.4g} us apart (t0); all are put at the first one's "
                    "times",
                    latest_s * 1e6));
  }
}

// one channel of a Hantek file: # lines, then values
struct HantekBlock {
  std::string head{};
  std::string title{};
  std::string unit{};
  std::string clock{};
  Cells values{};
};

void TakeHantekKey(std::string_view line, HantekBlock* block) {
  block->head += line;
  block->head += '\n';
  const auto key = ReadTableKey(line, ',');
  if (!key) return;
  const std::string word = LowerCase(key->key);
  if (word == "channel") block->title = key->values[0];
  if (word == "units") block->unit = key->values[0];
  if (word == "clock") block->clock = key->values[0];
}

// the blocks of `text`, or none where it is a table
std::vector<HantekBlock> HantekBlocks(std::string_view text) {
  std::vector<HantekBlock> blocks;
  bool is_in_values = true;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = Trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    if (line.starts_with('#')) {
      if (std::exchange(is_in_values, false)) blocks.emplace_back();
      TakeHantekKey(line, &blocks.back());
      continue;
    }
    if (blocks.empty() || CellsOf(line).cells.size() > 1) return {};
    blocks.back().values.push_back(line);
    is_in_values = true;
  }
  return blocks;
}

}  // namespace

std::vector<CsvColumn> SideColumns(const TableBeginning& beginning) {
  std::vector<CsvColumn> columns(beginning.width(), {.kind = CsvColumnKind::kLeftOut});
  columns[3] = {.kind = CsvColumnKind::kTime, .name = "time", .unit = "s"};
  if (const auto unit = FindUnit(FirstValue(beginning, "Horizontal Units"));
      unit && unit->si_unit == "s") {
    columns[3].factor = unit->factor;
  }
  const std::string_view source = FirstValue(beginning, "Source");
  columns[4] = {.name = source.empty() ? "channel_1" : std::string(source)};
  SetPrintedUnit(FirstValue(beginning, "Vertical Units"), &columns[4]);
  return columns;
}

Result<void> ReadSequence(const TableBeginning& beginning, const std::string& name,
                          ForeignTable* table) {
  const Cells names = beginning.above.size() < 2
                          ? Cells{}
                          : SplitCells(beginning.above[beginning.above.size() - 2].text,
                                       beginning.rows[0].separator);
  const Cells units = beginning.above.empty()
                          ? Cells{}
                          : SplitCells(beginning.above.back().text, beginning.rows[0].separator);
  std::optional<double> start_s;
  std::optional<double> increment_s;
  table->columns.assign(beginning.width(), {.kind = CsvColumnKind::kLeftOut});
  for (std::size_t i = 1; i < std::min(names.size(), units.size()); ++i) {
    const std::string title = LowerCase(names[i]);
    if (title == "start") start_s = ReadNumberWithComma(units[i]);
    if (title == "increment") increment_s = ReadNumberWithComma(units[i]);
    if (!title.starts_with("ch") || i >= beginning.width()) continue;
    table->columns[i] = {.name = std::string(names[i])};
    SetPrintedUnit(units[i], &table->columns[i]);
  }
  if (!start_s || !increment_s || !std::isfinite(*start_s) || !std::isfinite(1 / *increment_s) ||
      !(*increment_s > 0)) {
    return CannotAnswer(name, "has no Start and Increment below its names, or no sound ones",
                        "say --format plain with --columns and --rate");
  }
  table->columns[0] = {.kind = CsvColumnKind::kTime,
                       .name = "time",
                       .unit = "s",
                       .factor = *increment_s,
                       .offset = *start_s,
                       .is_count = true};
  const double first = ReadNumber(beginning.rows[0].cells[0]).value_or(0);
  table->clock = StatedClock{*increment_s, *start_s + first * *increment_s, "Increment"};
  if (first != 0) {
    table->remarks.push_back(fmt::format(
        "its rows begin at number {}: times are Start + number x Increment; if Start is the first "
        "row's, all are {:.6g} s earlier",
        beginning.rows[0].cells[0], first * *increment_s));
  }
  return {};
}

Result<void> AddInstrumentWords(const TableBeginning& beginning, const std::string& name,
                                ForeignTable* table) {
  switch (table->format) {
    case TableFormat::kLecroy:
      return AddLecroySegments(beginning, name, table);
    case TableFormat::kNiPxi:
      return AddPxiClock(beginning, name, table);
    case TableFormat::kNiElvis:
      AddElvisStarts(beginning, table);
      return {};
    case TableFormat::kRigolUltrascope:
      NameChannels(ValuesOf(beginning.keys, "Channel Data"), table);
      return {};
    case TableFormat::kSiglent:
      NameChannels(ValuesOf(beginning.keys, "Source"), table);
      return {};
    case TableFormat::kSaleae:
      if (std::ranges::all_of(table->columns, [](const CsvColumn& c) { return c.unit != "V"; })) {
        table->remarks.emplace_back(
            "digital channels list their transitions alone: rows are no samples");
      }
      return {};
    default:
      return {};
  }
}

Result<std::optional<std::string>> JoinHantekBlocks(std::string_view text,
                                                    const std::string& name) {
  const auto blocks = HantekBlocks(text);
  if (blocks.empty()) return std::nullopt;
  for (const HantekBlock& block : blocks) {
    if (block.values.size() == blocks[0].values.size() && block.clock == blocks[0].clock) continue;
    return CannotAnswer(name,
                        fmt::format("has blocks of {} and {} values, or of other clocks",
                                    blocks[0].values.size(), block.values.size()),
                        "save the channels into files of their own");
  }
  std::string joined = blocks[0].head;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const HantekBlock& block = blocks[b];
    if (b > 0) joined += '\t';
    joined += block.title.empty() ? fmt::format("CH{}", b + 1) : block.title;
    if (!block.unit.empty()) joined += fmt::format(" [{}]", block.unit);
  }
  joined += '\n';
  for (std::size_t row = 0; row < blocks[0].values.size(); ++row) {
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (b > 0) joined += '\t';
      joined += blocks[b].values[row];
    }
    joined += '\n';
  }
  return joined;
}

}  // namespace haptometer::trial
