#include "tools/fit/impedance_table.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <optional>
#include <ranges>
#include <span>
#include <string_view>

#include "tools/study/text_table.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::tools {
namespace {

// a unit as tables print it, in lower case but for a leading M
struct SweepUnit {
  std::string_view printed;
  double si;
  std::string_view name;  // for the note
};

constexpr double kRadiansPerDegree = std::numbers::pi / 180;
constexpr SweepUnit kFrequencyUnits[]{{"hz", 1, "Hz"}, {"khz", 1e3, "kHz"}, {"Mhz", 1e6, "MHz"}};
constexpr SweepUnit kImpedanceUnits[]{
    {"ohm", 1, "ohm"},     {"ohms", 1, "ohm"},     {"mohm", 1e-3, "mohm"}, {"mohms", 1e-3, "mohm"},
    {"kohm", 1e3, "kohm"}, {"kohms", 1e3, "kohm"}, {"Mohm", 1e6, "Mohm"},  {"Mohms", 1e6, "Mohm"}};
constexpr SweepUnit kAngleUnits[]{{"deg", kRadiansPerDegree, "degrees"},
                                  {"degs", kRadiansPerDegree, "degrees"},
                                  {"degree", kRadiansPerDegree, "degrees"},
                                  {"degrees", kRadiansPerDegree, "degrees"},
                                  {"\u00b0", kRadiansPerDegree, "degrees"},
                                  {"rad", 1, "rad"},
                                  {"radian", 1, "rad"},
                                  {"radians", 1, "rad"},
                                  {"mrad", 1e-3, "mrad"}};

// a name in lower case; `unit` where it needs none
struct SweepName {
  std::string_view name;
  std::string_view unit{};
};

constexpr SweepName kFrequencyNames[]{
    {"frequency", "hz"}, {"freq", "hz"}, {"freq.", "hz"}, {"f", "hz"}, {"frequenz", "hz"}};
constexpr SweepName kMagnitudeNames[]{
    {"impedance"}, {"|z|"},       {"z"},      {"zabs"},        {"absz"},
    {"abs(z)"},    {"zmag"},      {"mag(z)"}, {"|impedance|"}, {"impedance magnitude"},
    {"magnitude"}, {"ohm", "ohm"}};
constexpr SweepName kPhaseNames[]{
    {"phase"},    {"phase angle"}, {"impedance phase"}, {"impedance phase angle"},
    {"theta"},    {"\u03b8"},      {"angle"},           {"arg(z)"},
    {"phase(z)"}, {"phi"},         {"\u03c6"},          {"degrees", "deg"}};
constexpr SweepName kRealNames[]{{"resistance"}, {"r"},    {"rs"},  {"re(z)"}, {"real(z)"},
                                 {"re"},         {"real"}, {"zre"}, {"zreal"}, {"z'"}};
constexpr SweepName kImaginaryNames[]{{"reactance"}, {"x"},    {"xs"},  {"im(z)"}, {"imag(z)"},
                                      {"im"},        {"imag"}, {"zim"}, {"zimag"}, {"z''"}};

enum class Part : std::uint8_t { kFrequency, kMagnitude, kPhase, kReal, kImaginary };
constexpr std::size_t kParts = 5;

struct PartWords {
  std::string_view label;
  std::span<const SweepName> names;
  std::span<const SweepUnit> units;
  std::string_view example;
};

constexpr std::array<PartWords, kParts> kPartWords{{
    {"frequency", kFrequencyNames, kFrequencyUnits, "frequency_hz"},
    {"magnitude", kMagnitudeNames, kImpedanceUnits, "impedance_ohm"},
    {"phase", kPhaseNames, kAngleUnits, "phase_deg"},
    {"real part", kRealNames, kImpedanceUnits, "resistance_ohm"},
    {"imaginary part", kImaginaryNames, kImpedanceUnits, "reactance_ohm"},
}};

const PartWords& WordsOf(Part part) { return kPartWords[static_cast<std::size_t>(part)]; }

// a column by its name; without `unit` it cannot be read
struct SweepColumn {
  std::string cell;
  std::string unit_text;
  const SweepUnit* unit = nullptr;
};

// what the columns of a table may be
struct SweepColumns {
  std::array<std::vector<SweepColumn>, kParts> readable;
  std::array<std::vector<SweepColumn>, kParts> unreadable;

  [[nodiscard]] bool Has(Part part) const {
    return !readable[static_cast<std::size_t>(part)].empty();
  }
};

// "Ohm", "OHM" and both code points of the sign as "ohm"; a leading M stays
std::string PlainUnit(std::string_view printed) {
  std::string unit = trial::LowerCase(printed);
  if (printed.starts_with('M')) unit[0] = 'M';
  for (const std::string_view sign : {"\u03a9", "\u2126"}) {
    const auto at = unit.find(sign);
    if (at != std::string::npos) unit.replace(at, sign.size(), "ohm");
  }
  return unit;
}

// the text of the unit behind a name: "(ohm)", " [kHz]", "/rad", "_deg", " in ohm"; nothing where
// the name goes on
std::optional<std::string_view> UnitBehind(std::string_view rest) {
  constexpr std::string_view kSigns = " _/([";
  if (rest.empty()) return rest;
  if (!kSigns.contains(rest.front())) return {};
  rest.remove_prefix(std::min(rest.find_first_not_of(kSigns), rest.size()));
  if (rest.starts_with("in ")) rest.remove_prefix(3);
  return rest.substr(0, rest.find_last_not_of(" )]") + 1);
}

// puts a column where its longest name belongs; passed over where it has none
void Sort(const std::string& cell, SweepColumns* columns) {
  const std::string lower = trial::LowerCase(cell);
  std::size_t longest = 0;
  std::size_t place = 0;
  SweepColumn column{.cell = cell, .unit_text = {}};
  for (std::size_t part = 0; part < kParts; ++part) {
    for (const SweepName& name : kPartWords[part].names) {
      if (name.name.size() <= longest || !lower.starts_with(name.name)) continue;
      const auto text = UnitBehind(std::string_view(cell).substr(name.name.size()));
      if (!text) continue;
      longest = name.name.size();
      place = part;
      column.unit_text = PlainUnit(text->empty() ? name.unit : *text);
    }
  }
  if (longest == 0) return;
  const auto& units = kPartWords[place].units;
  const auto unit = std::ranges::find(units, column.unit_text, &SweepUnit::printed);
  column.unit = unit == units.end() ? nullptr : &*unit;
  auto& list = column.unit ? columns->readable[place] : columns->unreadable[place];
  list.push_back(std::move(column));
}

// reads the columns of one table
class SweepReader {
 public:
  explicit SweepReader(const TextTable& table) : table_(table) {
    for (const auto& [cell, values] : table.columns) Sort(cell, &columns_);
  }

  Result<ImpedanceTable> Read() {
    HAPTOMETER_TRY(CheckParts());
    const bool is_polar = HasBoth(Part::kMagnitude, Part::kPhase);
    const Part first_part = is_polar ? Part::kMagnitude : Part::kReal;
    const Part second_part = is_polar ? Part::kPhase : Part::kImaginary;
    HAPTOMETER_LET(const auto hertz, Numbers(Part::kFrequency));
    HAPTOMETER_LET(const auto first, Numbers(first_part));
    HAPTOMETER_LET(const auto second, Numbers(second_part));
    ImpedanceTable sweep;
    sweep.points.reserve(hertz.size());
    for (std::size_t n = 0; n < hertz.size(); ++n) {
      // a negative magnitude has no phase
      const double magnitude = is_polar ? first[n] : std::hypot(first[n], second[n]);
      if (!(hertz[n] > 0 && magnitude > 0)) {
        return CannotAnswer(fmt::format("{}:{}", table_.name, table_.lines[n]),
                            "has a frequency or a magnitude that is not positive",
                            "correct that line");
      }
      sweep.points.push_back({hertz[n], is_polar ? std::polar(first[n], second[n])
                                                 : std::complex<double>(first[n], second[n])});
    }
    if (!are_plain_) sweep.columns = fmt::format("{}", fmt::join(taken_, ", "));
    return sweep;
  }

 private:
  [[nodiscard]] bool HasBoth(Part one, Part other) const {
    return columns_.Has(one) && columns_.Has(other);
  }

  [[nodiscard]] std::string Found() const {
    return fmt::format("{}", fmt::join(std::views::keys(table_.columns), ", "));
  }

  // a frequency, and one pair
  [[nodiscard]] Result<void> CheckParts() const {
    if (!columns_.Has(Part::kFrequency)) return Lacks({Part::kFrequency});
    const bool is_polar = HasBoth(Part::kMagnitude, Part::kPhase);
    const bool is_cartesian = HasBoth(Part::kReal, Part::kImaginary);
    if (is_polar && is_cartesian) {
      return CannotAnswer(table_.name,
                          fmt::format("has magnitude and phase, and real and imaginary parts too, "
                                      "in its columns {}",
                                      Found()),
                          "leave one pair out");
    }
    if (is_polar || is_cartesian) return {};
    // the pair of which something is there
    const bool is_part = columns_.Has(Part::kReal) || columns_.Has(Part::kImaginary);
    return is_part ? Lacks({Part::kReal, Part::kImaginary, Part::kMagnitude, Part::kPhase})
                   : Lacks({Part::kMagnitude, Part::kPhase, Part::kReal, Part::kImaginary});
  }

  // a column that would be one of `parts` but for its unit, else none
  [[nodiscard]] std::unexpected<Error> Lacks(std::initializer_list<Part> parts) const {
    for (const Part part : parts) {
      const auto& unreadable = columns_.unreadable[static_cast<std::size_t>(part)];
      if (columns_.Has(part) || unreadable.empty()) continue;
      return NoUnit(unreadable.front(), WordsOf(part));
    }
    const Part missing = *std::ranges::find_if_not(parts, [&](Part p) { return columns_.Has(p); });
    return CannotAnswer(table_.name,
                        fmt::format("has no column {} among {}", WordsOf(missing).example, Found()),
                        "its header needs frequency_hz,impedance_ohm,phase_deg or "
                        "frequency_hz,resistance_ohm,reactance_ohm");
  }

  [[nodiscard]] std::unexpected<Error> NoUnit(const SweepColumn& column,
                                              const PartWords& words) const {
    const std::string cell = fmt::format("its column '{}'", column.cell);
    const std::string among = fmt::format("(columns: {})", Found());
    if (column.unit_text.starts_with("db")) {
      return CannotAnswer(table_.name, fmt::format("{} is in dB {}", cell, among),
                          "convert it to ohm, 10^(dB/20) times what 0 dB stands for");
    }
    const std::string remedy = fmt::format("name it {}, if that is its unit", words.example);
    if (column.unit_text.empty()) {
      return CannotAnswer(table_.name, fmt::format("{} does not state its unit {}", cell, among),
                          remedy);
    }
    return CannotAnswer(table_.name,
                        fmt::format("{} has the unit '{}', which is none of a {} {}", cell,
                                    column.unit_text, words.label, among),
                        remedy);
  }

  // the part's numbers in SI; which column they are is kept for the note
  Result<std::vector<double>> Numbers(Part part) {
    constexpr std::string_view kPlain[]{"frequency_hz", "impedance_ohm", "phase_deg",
                                        "frequency",    "ohm",           "degrees"};
    const auto& readable = columns_.readable[static_cast<std::size_t>(part)];
    if (readable.size() > 1) {
      return CannotAnswer(table_.name,
                          fmt::format("its columns '{}' and '{}' may both be the {}",
                                      readable[0].cell, readable[1].cell, WordsOf(part).label),
                          "leave one out");
    }
    const SweepColumn& column = readable.front();
    HAPTOMETER_LET(auto numbers, NumbersOf(table_, column.cell));
    for (double& number : numbers) number *= column.unit->si;
    are_plain_ = are_plain_ && std::ranges::find(kPlain, column.cell) != std::end(kPlain);
    taken_.push_back(
        fmt::format("'{}' as the {} in {}", column.cell, WordsOf(part).label, column.unit->name));
    return numbers;
  }

  const TextTable& table_;
  SweepColumns columns_;
  std::vector<std::string> taken_;
  bool are_plain_ = true;
};

}  // namespace

Result<ImpedanceTable> ReadImpedanceTable(const std::string& path) {
  HAPTOMETER_LET(const auto table, ReadTextTable(path, {}));
  return SweepReader(table).Read();
}

}  // namespace haptometer::tools
