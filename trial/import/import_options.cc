#include "trial/import/import_options.h"

#include <algorithm>
#include <array>

#include "base/error.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

using enum TableFormat;

// format, name in options, title in messages, assumed units of time and of values
constexpr std::array<TableFormatFacts, 21> kFormats{{
    {kPlain, "plain", "plain table", "", ""},
    {kTektronixTds, "tektronix-tds", "Tektronix TDS/TBS/DPO2000", "s", ""},
    {kTektronixDpo, "tektronix-dpo", "Tektronix MSO/DPO3000-4000", "s", ""},
    {kTektronixMso, "tektronix-mso", "Tektronix MSO 4/5/6", "s", ""},
    {kRigolSequence, "rigol-sequence", "Rigol DS1000Z/2000A/4000/MSO5000", "", ""},
    {kRigolSeconds, "rigol-seconds", "Rigol DS1000E", "", ""},
    {kRigolVolts, "rigol-volts", "Rigol DS1102D", "s", ""},
    {kRigolDs1204, "rigol-ds1204", "Rigol DS1204B", "", ""},
    {kRigolUltrascope, "rigol-ultrascope", "Rigol UltraScope", "", ""},
    {kKeysightInfiniivision, "keysight-infiniivision", "Keysight InfiniiVision", "", ""},
    {kKeysightInfiniium, "keysight-infiniium", "Keysight Infiniium", "s", "V"},
    {kSiglent, "siglent", "Siglent SDS", "", "V"},
    {kLecroy, "lecroy", "LeCroy", "s", "V"},
    {kPicoscope, "picoscope", "PicoScope", "", ""},
    {kSaleae, "saleae", "Saleae Logic 2", "", ""},
    {kDigilent, "digilent", "Digilent WaveForms", "", ""},
    {kHantek, "hantek", "Hantek", "", ""},
    {kOpenhantek, "openhantek", "OpenHantek", "", ""},
    {kRohdeSchwarz, "rohde-schwarz", "Rohde & Schwarz", "", ""},
    {kNiPxi, "ni-pxi", "NI PXI", "", "V"},
    {kNiElvis, "ni-elvis", "NI ELVIS", "", "V"},
}};

// layouts are recognised by the first lines alone
constexpr std::size_t kLinesLookedAt = 64;

// the lines in lower case with commas between cells, without quotes and blanks: what separates and
// how it is decorated depends on the program that a file went through last
std::vector<std::string> BareLines(std::string_view text) {
  std::vector<std::string> lines;
  lines.reserve(kLinesLookedAt);
  while (!text.empty() && lines.size() < kLinesLookedAt) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    // longer lines are compared by their beginning
    constexpr std::size_t kLongest = 400;
    std::string line = LowerCase(text.substr(0, std::min(end, kLongest)));
    text.remove_prefix(std::min(end + 1, text.size()));
    std::erase_if(line, [](char c) { return c == ' ' || c == '"' || c == '\r'; });
    // where another sign separates cells, a comma is a decimal one
    if (line.find_first_of(";\t") != std::string::npos) std::ranges::replace(line, ',', '.');
    std::ranges::replace(line, '\t', ',');
    std::ranges::replace(line, ';', ',');
    lines.push_back(std::move(line));
  }
  return lines;
}

// what the lines of a file begin with or contain, by which its layout is recognised
class Signs {
 public:
  explicit Signs(std::string_view text) : lines_(BareLines(text)) {}

  [[nodiscard]] bool Begins(std::string_view sign) const {
    return std::ranges::any_of(lines_, [&](const auto& l) { return l.starts_with(sign); });
  }
  [[nodiscard]] bool Contains(std::string_view sign) const {
    return std::ranges::any_of(lines_, [&](const auto& l) { return l.contains(sign); });
  }
  // a line that begins with `sign` right above one that begins with `below`
  [[nodiscard]] bool Pair(std::string_view sign, std::string_view below) const {
    for (std::size_t i = 0; i + 1 < lines_.size(); ++i) {
      if (lines_[i].starts_with(sign) && lines_[i + 1].starts_with(below)) return true;
    }
    return false;
  }
  // a header of which only the time has a unit, and a channel the name that Saleae gives
  [[nodiscard]] bool BeginsWithTimeAlone() const {
    constexpr std::string_view kTime = "time[s],";
    return std::ranges::any_of(lines_, [&](std::string_view line) {
      if (!line.starts_with(kTime)) return false;
      const auto cells = SplitCells(line.substr(kTime.size()), ',');
      return std::ranges::none_of(cells, HasUnit) && std::ranges::any_of(cells, IsSaleaeName);
    });
  }
  // metadata beside the numbers, from the first line on
  [[nodiscard]] bool HasSideColumns() const {
    if (lines_.empty() || !lines_[0].starts_with("recordlength,")) return false;
    const auto cells = SplitCells(lines_[0], ',');
    return cells.size() >= 5 && cells[2].empty() && ReadNumber(cells[3]) && ReadNumber(cells[4]);
  }

 private:
  static bool HasUnit(std::string_view cell) {
    const std::size_t open = cell.find_first_of("[(");
    const std::size_t close = cell.find_last_of("])");
    return open != std::string_view::npos && close != std::string_view::npos && close > open &&
           FindUnit(cell.substr(open + 1, close - open - 1));
  }
  // "channel0", "d0" and "a0", where the user has not renamed it
  static bool IsSaleaeName(std::string_view cell) {
    const std::size_t digits = cell.find_first_of("0123456789");
    if (digits == std::string_view::npos) return false;
    const std::string_view word = cell.substr(0, digits);
    return (word == "channel" || word == "d" || word == "a") &&
           cell.find_first_not_of("0123456789", digits) == std::string_view::npos;
  }

  std::vector<std::string> lines_;
};

// layouts of oscilloscopes; the order matters, because several begin with the same words
TableFormat FindScope(const Signs& signs) {
  if (signs.Begins("#digilentwaveforms")) return kDigilent;
  if (signs.Begins("#channel:ch") || (signs.Begins("#clock=") && signs.Begins("#size="))) {
    return kHantek;
  }
  if (signs.Begins("lecroy")) return kLecroy;
  if (signs.HasSideColumns()) return kTektronixTds;
  if (signs.Begins("model,") && signs.Begins("waveformtype,")) {
    return signs.Begins("zeroindex,") ? kTektronixMso : kTektronixDpo;
  }
  if (signs.Begins("recordlength,analog:") || signs.Pair("source,ch", "second,")) return kSiglent;
  if (signs.Pair("x,ch", "sequence,") || signs.Contains(",start,increment") ||
      signs.Contains(",tinc=")) {
    return kRigolSequence;
  }
  if (signs.Begins("numberofdatapoints")) return kRigolUltrascope;
  if (signs.Pair("x,ch", "second,")) return kRigolSeconds;
  if (signs.Begins("x,ch1(v)") || signs.Begins("x,ch2(v)")) return kRigolVolts;
  if (signs.Pair(",ch", "second,")) return kRigolDs1204;
  return kPlain;
}

// layouts of data loggers and of programs, whose signs are weaker: after the oscilloscopes
TableFormat FindOther(const Signs& signs) {
  if (signs.Pair("x-axis,", "second,")) return kKeysightInfiniivision;
  if (signs.Begins("revision:") || signs.Begins("xinc:")) return kKeysightInfiniium;
  if (signs.Pair("metadata", "physicalchannel,")) return kNiPxi;
  if (signs.Pair("waveform,", "t0,")) return kNiElvis;
  if (signs.Begins("time,channel") || signs.Begins("zeit,kanal")) return kPicoscope;
  if (signs.BeginsWithTimeAlone()) return kSaleae;
  if (signs.Begins("t/s,ch")) return kOpenhantek;
  if (signs.Begins("ins,") || signs.Begins("timeins,")) return kRohdeSchwarz;
  return kPlain;
}

}  // namespace

std::span<const TableFormatFacts> TableFormats() { return kFormats; }

const TableFormatFacts& FactsOf(TableFormat format) {
  const auto found = std::ranges::find(kFormats, format, &TableFormatFacts::format);
  HAPTOMETER_CHECK(found != kFormats.end(), "format {}", static_cast<int>(format));
  return *found;
}

std::optional<TableFormat> TableFormatFromName(std::string_view name) {
  const auto found = std::ranges::find(kFormats, name, &TableFormatFacts::name);
  if (found == kFormats.end()) return std::nullopt;
  return found->format;
}

TableFormat FindTableFormat(std::string_view text) {
  const Signs signs(text);
  const TableFormat scope = FindScope(signs);
  return scope == kPlain ? FindOther(signs) : scope;
}

}  // namespace haptometer::trial
