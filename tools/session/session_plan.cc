#include "tools/session/session_plan.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "base/mapped.h"
#include "base/names.h"
#include "base/text.h"
#include "base/toml.h"
#include "dsp/statistics/distributions.h"
#include "tools/acquire/recording.h"
#include "tools/analyze/expectation.h"
#include "tools/session/watched_folder.h"
#include "tools/study/alike_names.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::tools {
namespace {

constexpr Names<SessionOrder, 3> kOrderNames{{"balanced", "random", "given"}};

// of the tests that a plan is judged by
constexpr double kPower = 0.8;

constexpr std::string_view kPerSubject = "per-subject";

Result<void> CheckNames(const std::vector<std::string>& names, const std::string& where,
                        std::size_t most) {
  if (names.empty()) return Usage(where, "are missing", "name at least one");
  if (names.size() > most) {
    return Usage(where, fmt::format("are {}, at most {} are possible", names.size(), most));
  }
  for (const std::string& name : names) {
    HAPTOMETER_TRY(CheckPrintable(where, name));
    if (name.empty() || trial::Trimmed(name) != name) {
      return Usage(where, fmt::format("'{}' is empty or has a blank at an end", name),
                   "write the name alone");
    }
    if (std::ranges::count(names, name) > 1) {
      return Usage(where, fmt::format("name {} twice", name), "give each a name of its own");
    }
  }
  for (const AlikeNames& pair : NamesAlike(names)) {
    if (pair.likeness != Likeness::kSpelling) continue;
    return Usage(where,
                 fmt::format("{} and {} differ by case, blanks or zeros in front only", pair.one,
                             pair.other),
                 "give each a name of its own");
  }
  return {};
}

// rows of places 0 to n - 1; each place follows each other equally often over all rows
std::vector<std::vector<std::size_t>> WilliamsRows(std::size_t n) {
  // 0, n-1, 1, n-2, ...: its differences modulo n are all different
  std::vector<std::size_t> zigzag;
  zigzag.reserve(n);
  for (std::size_t i = 0; i < n; ++i) zigzag.push_back(i % 2 == 0 ? i / 2 : n - 1 - i / 2);
  std::vector<std::vector<std::size_t>> rows;
  rows.reserve(2 * n);
  for (std::size_t shift = 0; shift < n; ++shift) {
    rows.push_back(Mapped<std::size_t>(zigzag, [&](std::size_t at) { return (at + shift) % n; }));
  }
  if (n % 2 == 0) return rows;
  // an odd number needs the mirror images too
  for (std::size_t row = 0; row < n; ++row) {
    rows.emplace_back(rows[row].rbegin(), rows[row].rend());
  }
  return rows;
}

// Fisher and Yates; the library's shuffle may differ from one system to the next
void Shuffle(std::vector<std::size_t>& places, std::mt19937_64& random) {
  for (std::size_t i = places.size(); i > 1; --i) std::swap(places[i - 1], places[random() % i]);
}

std::vector<std::size_t> Counted(std::size_t n) {
  std::vector<std::size_t> places(n);
  std::iota(places.begin(), places.end(), std::size_t{0});
  return places;
}

// the conditions' order of block `repeat` of subject `s`
class Blocks {
 public:
  explicit Blocks(const SessionPlan& plan)
      : order_(plan.order),
        places_(Counted(plan.conditions.size())),
        rows_(WilliamsRows(plan.conditions.size())),
        random_(static_cast<std::uint64_t>(plan.seed)) {
    // which condition has which place in the design
    if (order_ == SessionOrder::kBalanced) Shuffle(places_, random_);
  }

  [[nodiscard]] std::vector<std::size_t> Next(std::size_t subject, std::size_t repeat) {
    if (order_ == SessionOrder::kRandom) Shuffle(places_, random_);
    if (order_ != SessionOrder::kBalanced) return places_;
    return Mapped<std::size_t>(rows_[(subject + repeat) % rows_.size()],
                               [&](std::size_t place) { return places_[place]; });
  }

 private:
  SessionOrder order_;
  std::vector<std::size_t> places_;
  std::vector<std::vector<std::size_t>> rows_;
  std::mt19937_64 random_;
};

std::string TomlList(const std::vector<std::string>& texts) {
  const auto quoted =
      Mapped<std::string>(texts, [](const std::string& text) { return TomlString(text); });
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

// a line of what is planned; none of what is not
std::string NumberLine(std::string_view key, const std::optional<double>& number) {
  return number ? fmt::format("{} = {}\n", key, *number) : "";
}

std::string ContrastsLine(const std::vector<PlannedContrast>& contrasts) {
  if (contrasts.empty()) return {};
  const auto pairs = Mapped<std::string>(contrasts, [](const PlannedContrast& contrast) {
    return TomlList({contrast.treatment, contrast.control});
  });
  return fmt::format("contrasts = [{}]\n", fmt::join(pairs, ", "));
}

}  // namespace

std::string_view Name(SessionOrder order) { return kOrderNames.Of(order); }

std::optional<SessionOrder> OrderNamed(std::string_view name) { return kOrderNames.From(name); }

std::string NameOf(const SessionCell& cell) {
  if (cell.is_floor()) return fmt::format("subject {}, floor", cell.subject);
  return fmt::format("subject {}, {}, repeat {}", cell.subject, cell.condition, cell.repeat);
}

std::vector<std::string> NamesIn(const std::string& text) {
  std::vector<std::string> names;
  if (text.empty()) return names;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    names.emplace_back(trial::Trimmed(rest.substr(0, comma)));
    if (comma == std::string_view::npos) return names;
    rest.remove_prefix(comma + 1);
  }
}

Result<std::vector<std::string>> ReadSubjects(const std::string& text) {
  // "2.5" and "-2" are numbers too, and no names
  if (!NumberFrom<double>(text)) return NamesIn(text);
  const auto count = NumberFrom<std::uint64_t>(text);
  if (!count || *count == 0 || *count > kMostSubjects) {
    return Usage("--subjects",
                 fmt::format("{} is not a whole number from 1 to {}", text, kMostSubjects),
                 "write how many there are, or their names with commas");
  }
  return Mapped<std::string>(Counted(*count), [](std::size_t i) { return std::to_string(i + 1); });
}

Result<void> CheckPlan(const SessionPlan& plan, const std::string& where) {
  HAPTOMETER_TRY(CheckNames(plan.subjects, where + ": subjects", kMostSubjects));
  HAPTOMETER_TRY(CheckNames(plan.conditions, where + ": conditions", kMostConditions));
  if (plan.repeats < 1 || plan.repeats > kMostRepeats) {
    return Usage(where + ": repeats",
                 fmt::format("{} is not from 1 to {}", plan.repeats, kMostRepeats));
  }
  const std::size_t cells =
      plan.subjects.size() * plan.conditions.size() * static_cast<std::size_t>(plan.repeats);
  if (cells > kMostCells) {
    return Usage(where, fmt::format("plans {} trials, at most {} are possible", cells, kMostCells));
  }
  if (plan.seed < 0) return Usage(where + ": seed", "is below 0");
  if (!(plan.duration_s > 0) || plan.duration_s > kLongestTimeS) {
    return Usage(where + ": duration", "is not above 0, or beyond 30 years", "write e.g. 4s");
  }
  if (plan.source.empty()) {
    return Usage(where + ": source", "is missing", "write the options of acquire behind --");
  }
  for (const std::string& file : plan.files_before) {
    if (ReadFolderFile(file)) continue;
    return Usage(where + ": files_before", fmt::format("'{}' is no file with its size", file));
  }
  if (const auto checked = CheckContrasts(plan.contrasts, plan.conditions); !checked) {
    const Error& error = checked.error();
    return Usage(fmt::format("{}: contrasts: {}", where, error.where), error.what, error.remedy);
  }
  const bool has_frequency = !plan.drive_frequency_hz || *plan.drive_frequency_hz > 0;
  const bool has_amplitude = !plan.drive_amplitude_v || *plan.drive_amplitude_v > 0;
  if (!has_frequency || !has_amplitude) return Usage(where + ": drive", "is not above 0");
  if (plan.expect.empty()) return {};
  const auto expected = ParseExpectation(plan.expect);
  return expected ? Result<void>{} : std::unexpected(expected.error());
}

Expectation ExpectationOf(const SessionPlan& plan) {
  // the limits were read by CheckPlan()
  Expectation expected;
  if (auto read = ParseExpectation(plan.expect)) expected = *std::move(read);
  if (!expected.tone_hz && plan.drive_frequency_hz) {
    expected.tone_hz = Quantity{*plan.drive_frequency_hz, 0.01 * *plan.drive_frequency_hz};
  }
  return expected;
}

std::size_t ContrastsOf(const SessionPlan& plan) {
  return plan.contrasts.empty() ? plan.conditions.size() - 1 : plan.contrasts.size();
}

std::size_t DesignRows(const SessionPlan& plan) {
  return WilliamsRows(plan.conditions.size()).size();
}

std::optional<double> DetectableEffect(const SessionPlan& plan) {
  const auto subjects = static_cast<double>(plan.subjects.size());
  const auto contrasts = static_cast<double>(ContrastsOf(plan));
  if (subjects < 2 || contrasts < 1) return std::nullopt;
  const auto shown =
      dsp::NoncentralityForPower(subjects - 1, (1 - dsp::kConfidence) / contrasts, kPower);
  if (!shown) return std::nullopt;
  return *shown / std::sqrt(subjects);
}

std::string TomlOf(const SessionPlan& plan) {
  return fmt::format(
      "# a session of haptometer; a change of names or numbers changes the plan for what is not "
      "recorded yet\n"
      "subjects = {}\nconditions = {}\nrepeats = {}\norder = \"{}\"\nseed = {}\nfloor = \"{}\"\n"
      "duration_s = {}\nexpect = {}\n{}{}{}source = {}\n{}",
      TomlList(plan.subjects), TomlList(plan.conditions), plan.repeats, Name(plan.order), plan.seed,
      plan.has_floors ? kPerSubject : "none", plan.duration_s, TomlString(plan.expect),
      NumberLine("drive_frequency_hz", plan.drive_frequency_hz),
      NumberLine("drive_amplitude_v", plan.drive_amplitude_v), ContrastsLine(plan.contrasts),
      TomlList(plan.source),
      plan.files_before.empty() ? std::string()
                                : fmt::format("files_before = {}\n", TomlList(plan.files_before)));
}

Result<SessionPlan> ParsePlan(std::string_view text, const std::string& where) {
  HAPTOMETER_LET(auto table, TomlTable::ParseText(text, where));
  SessionPlan plan;
  plan.subjects = table.TextList("subjects");
  plan.conditions = table.TextList("conditions");
  plan.repeats = table.Integer("repeats").value_or(plan.repeats);
  const auto order = table.Choice("order", {"balanced", "random", "given"});
  plan.order = OrderNamed(order.value_or("")).value_or(plan.order);
  plan.seed = table.Integer("seed").value_or(0);
  plan.has_floors = table.Choice("floor", {"per-subject", "none"}) == kPerSubject;
  plan.duration_s = table.Require("duration_s", Dimension::kTime);
  plan.expect = table.Text("expect").value_or("");
  plan.drive_frequency_hz = table.Number("drive_frequency_hz", Dimension::kFrequency);
  plan.drive_amplitude_v = table.Number("drive_amplitude_v", Dimension::kVoltage);
  plan.contrasts = ReadContrasts(table);
  plan.source = table.TextList("source");
  plan.files_before = table.TextList("files_before");
  HAPTOMETER_TRY(table.Finish());
  HAPTOMETER_TRY(CheckPlan(plan, where));
  return plan;
}

std::vector<SessionCell> CellsOf(const SessionPlan& plan) {
  std::vector<SessionCell> cells;
  Blocks blocks(plan);
  for (std::size_t s = 0; s < plan.subjects.size(); ++s) {
    const std::string& subject = plan.subjects[s];
    if (plan.has_floors) cells.push_back({.subject = subject, .condition = "", .repeat = 1});
    for (std::int64_t repeat = 1; repeat <= plan.repeats; ++repeat) {
      for (const std::size_t place : blocks.Next(s, static_cast<std::size_t>(repeat - 1))) {
        cells.push_back({subject, plan.conditions[place], repeat});
      }
    }
  }
  return cells;
}

}  // namespace haptometer::tools
