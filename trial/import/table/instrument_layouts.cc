#include "trial/import/table/instrument_layouts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

using Cells = std::vector<std::string_view>;

// the first value of a key above the table, or ""
std::string_view FirstValue(const TableBeginning& beginning, std::string_view key) {
  const auto values = ValuesOf(beginning.keys, key);
  return values.empty() ? "" : values[0];
}

// the cells of the line `down` lines below the one whose first cell begins with `first_cell`
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
  // a histogram is a table of counts, no waveform
  if (!beginning.above.empty()) {
    const Cells first = SplitCells(beginning.above[0].text, beginning.rows[0].separator);
    if (first.size() > 2 && LowerCase(first[2]) == "histogram") {
      return CannotAnswer(name, "holds a histogram, not a waveform",
                          "save the trace itself as a waveform");
    }
  }
  // a line for each segment: number, date, start in s since the first trigger
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
  // the columns are found by their titles, not by their order
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
    // one table of rows needs one clock for all channels
    const bool differs = table->clock && (table->clock->interval_s != clock.interval_s ||
                                          table->clock->start_s != clock.start_s);
    if (!IsSampleInterval(*interval_s) || differs) {
      return CannotAnswer(name, "has channels of different clocks, or one without",
                          "write channels of one clock into one file");
    }
    table->clock = clock;
  }
  return {};
}

// "t0,5/7/2021  12:00:47.056435,5/7/2021  12:00:47.056436": a note of how far the starts differ
void AddElvisStarts(const TableBeginning& beginning, ForeignTable* table) {
  const auto starts = ValuesOf(beginning.keys, "t0");
  double latest_s = 0;
  for (const std::string_view start : starts) {
    const auto clock_s = ReadClock(start);
    const auto first_s = ReadClock(starts[0]);
    if (clock_s && first_s) latest_s = std::max(latest_s, *clock_s - *first_s);
  }
  if (latest_s > 0) table->findings.Note(FindingKind::kChannelsApart, {{"apart_s", latest_s}});
}

// one channel of a Hantek file: # lines, then values
struct HantekBlock {
  std::string head{};
  std::string title{};
  std::string unit{};
  std::string clock{};
  Cells values{};
};

// adds one # line: kept in the head, and read as key where it is one
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
  // a # line behind values begins the next channel
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
    // several cells in a line: a table with all channels, which needs no joining
    if (blocks.empty() || CellsOf(line).cells.size() > 1) return {};
    blocks.back().values.push_back(line);
    is_in_values = true;
  }
  return blocks;
}

// what stands above a Rigol's rows
struct SequenceHead {
  std::vector<std::pair<std::string_view, std::string_view>> channels{};  // a column: title, unit
  bool has_numbers = false;                                               // in the first column
  std::optional<double> start_s{};
  std::optional<double> increment_s{};
  std::size_t lines = 0;
};

// the number behind "t0 =" or "tInc =", with or without an s
std::optional<double> NumberBehindSign(std::string_view cell) {
  cell = Trimmed(cell.substr(cell.find('=') + 1));
  if (cell.ends_with('s') || cell.ends_with('S')) cell.remove_suffix(1);
  return ReadNumberWithComma(Trimmed(cell));
}

SequenceHead SequenceHeadOf(const TableBeginning& beginning) {
  SequenceHead head;
  const auto cells_of = [&](std::size_t back) {
    return back > beginning.above.size()
               ? Cells{}
               : SplitCells(beginning.above[beginning.above.size() - back].text,
                            beginning.rows[0].separator);
  };
  // the header is "X,CH1,Start,Increment," above units, or one line with "t0 =" and "tInc ="
  Cells units = cells_of(1);
  const bool is_one_line = std::ranges::any_of(
      units, [](std::string_view cell) { return LowerCase(cell).starts_with("tinc"); });
  const Cells names = is_one_line ? std::exchange(units, {}) : cells_of(2);
  head.lines = is_one_line ? 1 : 2;
  units.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string title = LowerCase(names[i]);
    std::string_view name = names[i];
    std::string_view unit = units[i];
    // in one line the unit is the last letter of the name: "CH1V"
    if (is_one_line && name.size() > 1 && FindUnit(name.substr(name.size() - 1))) {
      unit = name.substr(name.size() - 1);
      name.remove_suffix(1);
    }
    if (title == "start") head.start_s = ReadNumberWithComma(units[i]);
    if (title == "increment") head.increment_s = ReadNumberWithComma(units[i]);
    if (title.starts_with("t0")) head.start_s = NumberBehindSign(names[i]);
    if (title.starts_with("tinc")) head.increment_s = NumberBehindSign(names[i]);
    const bool is_clock = title == "start" || title == "increment" || title.starts_with("t0") ||
                          title.starts_with("tinc");
    // a first column of row numbers is converted to times by Start and Increment
    if (i == 0) head.has_numbers = title == "x" || LowerCase(unit) == "sequence";
    if (is_clock || (i == 0 && head.has_numbers)) name = "";
    head.channels.emplace_back(name, unit);
  }
  return head;
}

// whether a name states what its numbers are: "Force [N]", "Laser mm", "Laser_mm"; an index in
// brackets and a word of one letter do not
bool MayStateUnit(std::string_view name) {
  constexpr std::string_view kBetween = " _()[]/";
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t end = std::min(name.find_first_of(kBetween, at), name.size());
    const std::string_view word = name.substr(at, end - at);
    const bool is_in_brackets = at > 0 && (name[at - 1] == '(' || name[at - 1] == '[');
    if (is_in_brackets ? !ReadNumber(word) : word.size() > 1 && FindUnit(word)) return true;
    at = end + 1;
  }
  return false;
}

// Saleae's digital channels are 0, 1 or X; analog ones have decimals, and their unit is the volt
void MindSaleaeKinds(const TableBeginning& beginning, ForeignTable* table) {
  // the cells of a digital channel
  const auto is_level = [](std::string_view cell) {
    return cell == "0" || cell == "1" || cell == "X" || cell == "x" || cell.empty();
  };
  bool is_digital = false;
  bool is_assumed = false;
  for (std::size_t i = 0; i < table->columns.size(); ++i) {
    CsvColumn& column = table->columns[i];
    if (column.kind != CsvColumnKind::kValue || !column.unit.empty()) continue;
    // two rows without other cells than levels: a digital channel
    const bool has_levels = std::ranges::all_of(
        beginning.rows, [&](const TableCells& row) { return is_level(row.cells[i]); });
    is_digital = is_digital || has_levels;
    const bool is_volts = column.role == ChannelRole::kOther && !MayStateUnit(column.printed);
    if (has_levels || !is_volts) continue;
    SetPrintedUnit("V", &column);
    is_assumed = true;
  }
  // digital channels are exported at their transitions only, so rows are no samples
  if (is_digital) table->findings.Doubt(FindingKind::kTransitionsOnly);
  if (is_assumed) {
    table->findings.Note(
        FindingKind::kValueUnitAssumed,
        {{"title", std::string(FactsOf(TableFormat::kSaleae).title)}, {"unit", std::string("V")}});
  }
}

}  // namespace

std::vector<CsvColumn> SideColumns(const TableBeginning& beginning) {
  // Tektronix TDS: keys in columns 1 and 2, column 3 empty, time and value in columns 4 and 5
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

Result<std::size_t> ReadSequence(const TableBeginning& beginning, const std::string& name,
                                 ForeignTable* table) {
  // time of row i: Start + (number in the first column) * Increment
  const SequenceHead head = SequenceHeadOf(beginning);
  if (!head.start_s || !head.increment_s || !std::isfinite(*head.start_s) ||
      !IsSampleInterval(*head.increment_s)) {
    return CannotAnswer(name, "has no Start and Increment beside its names, or invalid ones",
                        "give <format> plain with <columns> and <rate>");
  }
  table->columns.assign(beginning.width(), {.kind = CsvColumnKind::kLeftOut});
  for (std::size_t i = 0; i < std::min(head.channels.size(), beginning.width()); ++i) {
    const auto& [title, unit] = head.channels[i];
    if (title.empty()) continue;
    table->columns[i] = {.name = std::string(title), .printed = std::string(title)};
    SetPrintedUnit(unit, &table->columns[i]);
  }
  table->clock = StatedClock{*head.increment_s, head.start_s, "Increment"};
  // without row numbers the rows are at Start + i * Increment
  if (!head.has_numbers) return head.lines;
  table->columns[0] = {.kind = CsvColumnKind::kTime,
                       .name = "time",
                       .unit = "s",
                       .factor = *head.increment_s,
                       .offset = *head.start_s,
                       .is_count = true};
  const double first = ReadNumber(beginning.rows[0].cells[0]).value_or(0);
  // a file that begins at a later row has a later start
  *table->clock->start_s += first * *head.increment_s;
  if (first != 0) {
    table->findings.Doubt(FindingKind::kRowsBeginAt,
                          {{"first", first}, {"earlier_s", first * *head.increment_s}});
  }
  return head.lines;
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
      MindSaleaeKinds(beginning, table);
      return {};
    default:
      return {};
  }
}

Result<std::optional<std::string>> JoinHantekBlocks(std::string_view text,
                                                    const std::string& name) {
  const auto blocks = HantekBlocks(text);
  if (blocks.empty()) return std::nullopt;
  // blocks become columns only if they have one length and one clock
  for (const HantekBlock& block : blocks) {
    if (block.values.size() == blocks[0].values.size() && block.clock == blocks[0].clock) continue;
    return CannotAnswer(name,
                        fmt::format("has blocks of {} and {} values, or of other clocks",
                                    blocks[0].values.size(), block.values.size()),
                        "save the channels into files of their own");
  }
  // the joined text is a table: keys of the first block, a line of names, rows
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
