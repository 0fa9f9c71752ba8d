#include "tools/reproduce/reproduce.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/input_file.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Key;
using document::Section;
using document::Unit;
using document::Value;

namespace fs = std::filesystem;

constexpr std::string_view kVerb = "reproduce";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Recompute every number of the thesis and compare.",
    .examples = {"haptometer reproduce", "haptometer reproduce --figures figures/ --chain",
                 "haptometer reproduce --report thesis.html --json"}};

// resolution of a computed value: one digit more than is printed
constexpr double kFurtherDigit = 0.1;
// half of the last digit of a value that is printed without decimals
constexpr double kHalf = 0.5;
// resolution of a relative deviation
constexpr double kLeastShare = 1e-4;

// printed in the unit of the thesis, SI in JSON
Unit UnitOf(const ThesisUnit& unit) { return {"", unit.si_name, {{{1 / unit.si, unit.name}}}}; }

// the last printed digit in SI; 0 where no value is printed, or only a bound
double StepOf(const ThesisNumber& number) { return 2 * number.half_step * number.unit.si; }

// --- findings ---

// what the rows rest on: kind and words
constexpr std::pair<std::string_view, std::string_view> kNotes[] = {
    {"half-digit",
     "a printed value is rounded to half of its last digit, 8200 N/m to 50 N/m, 220 Hz to 5 Hz"},
    {"coil-reaction",
     "equation 2.3 is taken with the coil's reaction on the case, as matrix 2.5 has it"},
    {"skin-range",
     "the skin's stiffness goes up to 2000 N/m (text of 2.1.1); Table 2.1 has 1200 N/m"},
    {"reading",
     "\"reading\" is a candidate cause that is computed; no cause is proved (--all shows the "
     "causes)"},
    {"tuned", "\"tuned\" is a candidate cause with a number chosen by what is printed"},
    {"rounding",
     "\"rounding\" is the set of inputs, among those that round to the printed ones, that "
     "comes nearest to what is printed; it may miss it"},
    {"generated",
     "{circular} rows are of trials generated with the printed number, not of the thesis's "
     "recordings: they test the analysis alone and are counted separately"},
};

// --- rows ---

// a remark, and candidate causes with the value that each gives; placed below the row's table
Section ReasonsSection(std::string heading, const std::string& remark) {
  Section reasons{.heading = std::move(heading), .detail = Detail::kAll};
  reasons.Add({"remark", "remark"}, document::TextOrNotKnown(remark));
  return reasons;
}

Section CandidatesSection(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  Section list{.name = "candidates", .shape = Section::Shape::kArray};
  for (const CandidateCause& cause : row.candidates) {
    const bool hits = Hits(number, cause);
    // value by this cause, in the thesis's unit
    const double gives = cause.gives / number.unit.si;
    Section& section = list.sections.emplace_back();
    section.Add({document::kText.name, Name(cause.kind)}, cause.text).note = fmt::format(
        "gives {}{}{}{}",
        document::NumberText(gives, 0, kFurtherDigit * StepOf(number) / number.unit.si),
        number.unit.name.empty() ? "" : " ", number.unit.name, hits ? ", as printed" : "");
    section.Add(document::kKind, Name(cause.kind));
    section.Add({"gives"}, cause.gives);
    section.Add({"from_rounded_interval"}, cause.from_rounded);
    section.Add({"as_printed"}, hits);
  }
  return list;
}

// `some_generated`: a row of its group is of generated data, so the table has a column for it
Section RowSection(const ThesisRow& row, bool some_generated) {
  const ThesisNumber& number = row.number();
  const Unit unit = UnitOf(number.unit);
  const double step = StepOf(number);
  const bool is_printed = number.relation != Relation::kNotPrinted;
  Section section;
  section.Add(document::kKey, row.key);
  section.Add({"group"}, number.group);
  section.Add({document::kWhat.name, "quantity"}, number.what);
  section.Add({"where", "in the thesis"}, document::TextOrNotKnown(number.where));
  section.Add({"relation", "relation"}, Name(number.relation));
  // decimals are printed as in the thesis, with final zeros; integers as they are
  section.Add({"printed", "printed", unit}, is_printed ? Value(SiValue(number)) : Value())
      .resolution = number.half_step < kHalf ? step : 0;
  section.Add({"printed_half_step"}, step > 0 ? Value(step / 2) : Value());
  section.Add(document::kUnit, number.unit.si_name);
  section.Add({"ours", "computed", unit}, row.ours).resolution = kFurtherDigit * step;
  section.Add({"ours_interval_95", "95 %", unit}, row.interval).resolution = kFurtherDigit * step;
  section.Add({document::kDeviation.name, "deviation", document::kShare}, DeviationOf(row))
      .resolution = kLeastShare;
  section.Add({document::kVerdict.name, "verdict"}, Name(VerdictOf(row)));
  section.Add({"generated", some_generated ? "generated" : ""}, row.generated);
  section.sections.push_back(ReasonsSection(std::string(number.what), row.remark));
  section.sections.back().sections.push_back(CandidatesSection(row));
  return section;
}

// a table for each group: rows of a group follow each other
std::vector<Section> GroupsOf(const std::vector<ThesisRow>& rows) {
  std::vector<Section> groups;
  for (auto row = rows.begin(); row != rows.end();) {
    const std::string_view group = row->number().group;
    const auto end = std::find_if(
        row, rows.end(), [&](const ThesisRow& other) { return other.number().group != group; });
    const bool some_generated =
        std::any_of(row, end, [](const ThesisRow& of) { return of.generated; });
    Section& table = groups.emplace_back(Section{.name = document::kRows.name,
                                                 .heading = std::string(group),
                                                 .shape = Section::Shape::kTable});
    for (; row != end; ++row) table.sections.push_back(RowSection(*row, some_generated));
  }
  return groups;
}

// counts over the rows that are not circular
void AddCounts(const std::vector<ThesisRow>& rows, Section& root) {
  const auto count = [&](const auto& is_counted) {
    return std::ranges::count_if(
        rows, [&](const ThesisRow& row) { return !row.generated && is_counted(row); });
  };
  const auto of_verdict = [&](RowVerdict verdict) {
    return count([&](const ThesisRow& row) { return VerdictOf(row) == verdict; });
  };
  // rows explained by causes of this kind alone
  const auto by_cause = [&](CauseKind kind) {
    return count([&](const ThesisRow& row) { return ExplainedBy(row) == kind; });
  };
  root.Add({"reproduced", "reproduced"}, of_verdict(RowVerdict::kReproduced));
  root.Add({document::kExplained.name, "explained by a candidate"},
           of_verdict(RowVerdict::kExplained));
  root.Add({"explained_by_rounding", "of these by rounding alone"}, by_cause(CauseKind::kRounding));
  root.Add({"explained_by_tuned", "of these by a tuned one alone"}, by_cause(CauseKind::kTuned));
  root.Add({"disagree", "disagree"}, of_verdict(RowVerdict::kDisagrees));
  root.Add({"not_printed", "not printed"}, of_verdict(RowVerdict::kNotPrinted));
  root.Add({"circular", "of generated trials"},
           std::ranges::count(rows, true, &ThesisRow::generated));
}

// --- chain ---

Section ChainRowSection(const ChainRow& row) {
  // six digits: the truth is exact to rounding
  constexpr double kDigits = 1e-6;  // of the truth
  Section section;
  section.Add(document::kKey, row.key);
  section.Add(document::kSensor, row.sensor);
  section.Add({document::kScene.name, "scene"}, row.scene);
  section.Add({"quantity", "quantity"}, row.quantity);
  section.Add(document::kUnit, row.unit.symbol);
  section.Add({"truth", "truth", row.unit}, row.truth).resolution = kDigits * row.truth.value_or(0);
  document::Item& answer = section.Add({"answer", "answer", row.unit, document::Form::kInterval},
                                       row.answer, row.standard_uncertainty);
  answer.interval = row.interval;
  // relative deviation from the truth
  const bool is_compared = row.truth && row.answer;
  section
      .Add({"", "deviation", document::kShare},
           is_compared ? Value(*row.answer / *row.truth - 1) : Value())
      .resolution = kLeastShare;
  section.Add({"holds", "holds"}, row.holds());
  section.sections.push_back(
      ReasonsSection(fmt::format("{}, {}: {}", row.sensor, row.scene, row.quantity), row.remark));
  return section;
}

Section ChainSection(const std::optional<std::vector<ChainRow>>& rows) {
  Section chain{.name = "chain", .heading = "Scene, sensor, record, analysis"};
  chain.is_known = rows.has_value();
  if (!rows) return chain;
  chain = ListOf(std::move(chain), *rows, ChainRowSection);
  // a row holds if its interval contains the truth
  chain.Add({"", "rows that hold"}, std::ranges::count_if(*rows, &ChainRow::holds));
  return chain;
}

// the rows, a table for each group, with the causes of each below; the chain; the figures
document::Document ReproductionDocument(const Reproduction& reproduction,
                                        const std::vector<ThesisFigure>& figures,
                                        const std::vector<std::string>& files) {
  document::Document document{.verb = "reproduce",
                              .title =
                                  "J. Lindsay, \"A Mechanical Amplifier for Haptic Feedback\", "
                                  "University of Washington, 2013, recomputed"};
  Section& root = document.root;
  root.sources = {document::DataSource::kSimulated};
  AddCounts(reproduction.rows, root);
  root.sections = GroupsOf(reproduction.rows);
  root.sections.push_back(ChainSection(reproduction.chain));
  Section drawn{.heading = "Figures"};
  drawn.Add({"files", "written"}, files);
  for (const ThesisFigure& figure : figures) {
    drawn.figures.push_back({.caption = figure.caption, .panels = figure.panels});
  }
  root.sections.push_back(std::move(drawn));
  const auto circular = std::ranges::count(reproduction.rows, true, &ThesisRow::generated);
  for (const auto& [kind, text] : kNotes) {
    // the number of rows is that of the last note
    root.Find(Severity::kNote, kind, text,
              text.starts_with("{circular}")
                  ? std::vector<FindingNumber>{{"circular", static_cast<std::size_t>(circular)}}
                  : std::vector<FindingNumber>{});
  }
  return document;
}

// --- the verb ---

struct Wanted {
  std::string figures;  // a folder; empty: none
  bool chain = false;
  document::Outputs outputs;
};

// the folder is made before the computation
Result<void> MakeFolder(const Wanted& wanted) {
  if (wanted.figures.empty()) return {};
  std::error_code failure;
  fs::create_directories(wanted.figures, failure);
  if (failure || !fs::is_directory(wanted.figures)) {
    return Usage(wanted.figures, "is not a folder, and none can be made there", "name another");
  }
  return {};
}

// draws the figures; returns the paths of the files
Result<std::vector<std::string>> DrawFigures(const std::string& folder,
                                             const std::vector<ThesisFigure>& figures) {
  std::vector<std::string> written;
  if (folder.empty()) return written;
  for (const ThesisFigure& figure : figures) {
    written.push_back(fs::path(folder) / (figure.name + ".svg"));
    HAPTOMETER_TRY(plot::DrawPanels(written.back(), figure.panels));
  }
  return written;
}

Result<document::Document> Answer(const Wanted& wanted, const Reproduction& reproduction) {
  std::vector<ThesisFigure> figures;
  // figures are computed only where they are drawn
  if (!wanted.figures.empty() || wanted.outputs.HasFigures()) figures = FiguresOf(reproduction);
  HAPTOMETER_LET(auto files, DrawFigures(wanted.figures, figures));
  if (!wanted.outputs.report.empty()) files.push_back(wanted.outputs.report);
  return ReproductionDocument(reproduction, figures, files);
}

// rows in the order of the thesis; each number has exactly one row
std::vector<ThesisRow> InOrder(std::vector<ThesisRow> rows) {
  const auto numbers = ThesisNumbers();
  HAPTOMETER_CHECK(rows.size() == numbers.size(), "{} rows, {} numbers", rows.size(),
                   numbers.size());
  std::vector<ThesisRow> ordered;
  ordered.reserve(rows.size());
  for (const ThesisNumber& number : numbers) {
    const auto found = std::ranges::find(rows, number.key, &ThesisRow::key);
    HAPTOMETER_CHECK(found != rows.end(), "no row {}", number.key);
    ordered.push_back(std::move(*found));
  }
  return ordered;
}

// computes every row with the rooms as they are: nothing of it is stored
Result<Reproduction> Reproduce(const ThesisModel& model, bool with_chain) {
  HAPTOMETER_LET(auto study, RunGeneratedStudy(model));
  std::vector<ThesisRow> rows = StudyRows(study);
  for (auto* group : {DisplacementRows, ElectricalRows, OptimumRows, FrequencyRows, RiseRows,
                      ReceptorRows, PrototypeRows}) {
    for (ThesisRow& row : group(model)) rows.push_back(std::move(row));
  }
  Reproduction reproduction{model, std::move(study), InOrder(std::move(rows)), std::nullopt};
  // scene, sensor, record, analysis: only with --chain
  if (!with_chain) return reproduction;
  HAPTOMETER_LET(reproduction.chain, RunChain(model));
  return reproduction;
}

}  // namespace

int RunReproduce(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  document::Outputs& outputs = wanted.outputs;
  document::DeclareOutputs(options, outputs,
                           {.all = "Show the candidate causes of each row too",
                            .report = "Write rows and figures as one self-contained page"});
  options.Output("--figures", &wanted.figures, "DIR",
                 "Draw Figures 2.2-2.7 and 3.3-3.5 into DIR, as SVG; older ones are replaced");
  options.Flag("--chain", &wanted.chain,
               "Also run scene, sensor, record and analysis, and compare with the simulated truth; "
               "status 1 where an interval misses it");
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_TRY(MakeFolder(wanted));
    HAPTOMETER_LET(const auto reproduction, Reproduce({}, wanted.chain));
    // the generated trials are no inputs of the user
    ForgetInputs();
    HAPTOMETER_LET(const auto document, Answer(wanted, reproduction));
    const int status = document::Present(document, outputs, argc, argv);
    // status 1 where an interval of the chain misses the truth
    const bool holds =
        !reproduction.chain || std::ranges::all_of(*reproduction.chain, &ChainRow::holds);
    return cli::WorseStatus(status, holds ? 0 : 1);
  });
}

}  // namespace haptometer::tools
