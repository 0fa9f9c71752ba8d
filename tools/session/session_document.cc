#include "tools/session/session_document.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tools/acquire/recording_document.h"
#include "tools/document/keys.h"
#include "tools/session/session_log.h"
#include "tools/study/alike_names.h"
#include "tools/study/study_document.h"

namespace haptometer::tools {
namespace {

using document::Item;
using document::Key;
using document::Section;

constexpr double kHourS = 3600;

// keys of more than one place
constexpr Key kAttempt{"attempt", "attempt"};
constexpr Key kPlanned{"planned"};
constexpr Key kDone{"done"};
constexpr Key kNext{"next", "next"};

Section CellSection(const SessionCell& cell) {
  Section section;
  section.Add({document::kSubject.name}, cell.subject);
  section.Add({kCondition.name}, document::TextOrNotKnown(cell.condition));
  section.Add({kRepeat.name}, cell.is_floor() ? document::Value() : document::Value(cell.repeat));
  section.Add({"is_floor"}, cell.is_floor());
  return section;
}

// subject, condition and repeat of the cell that comes next; null where all are done
void AddNext(const SessionCounts& counts, Section& section) {
  Section next = CellSection(counts.next.value_or(SessionCell{}));
  next.name = kNext.name;
  next.is_known = counts.next.has_value();
  section.sections.push_back(std::move(next));
  section.Add({"", kNext.label},
              counts.next ? NameOf(*counts.next) : std::string("nothing, all cells are done"));
}

Section FloorsSection(const SessionCounts& counts) {
  Section floors{.name = "floors"};
  floors.Add(kPlanned, counts.floors);
  floors.Add(kDone, counts.floors_done);
  if (counts.floors > 0) {
    floors.Add({"", "floors"}, fmt::format("{} of {}", counts.floors_done, counts.floors));
  }
  return floors;
}

// a row for each attempt, in the order of their beginnings
Section AttemptsSection(const SessionFolder& session) {
  Section list{.name = "attempts",
               .heading = "attempts",
               .shape = Section::Shape::kTable,
               .detail = document::Detail::kAll};
  for (const SessionAttempt& attempt : session.state().attempts) {
    const bool is_running = session.IsRunning(attempt);
    Section& row = list.sections.emplace_back();
    row.Add(document::kSubject, attempt.cell.subject);
    row.Add(kCondition, document::TextOrNotKnown(attempt.cell.condition));
    row.Add(kRepeat, attempt.cell.repeat);
    row.Add(kAttempt, attempt.number);
    row.Add({document::kVerdict.name, "verdict"},
            attempt.verdict ? document::Value(Name(*attempt.verdict)) : document::Value());
    row.Add({"is_running"}, is_running);
    row.Add({document::kBandRms.name, "RMS", document::kMetre}, attempt.band_rms_m).resolution =
        attempt.band_rms_m ? *attempt.band_rms_m * 1e-3 : 0;
    row.Add({document::kFile.name, "file"}, attempt.file);
    row.Add({document::kReasons.name, "reasons"},
            document::TextOrNotKnown(is_running ? "is being recorded" : attempt.Reasons()));
    row.Add(document::kNotes,
            document::TextOrNotKnown(fmt::format("{}", fmt::join(attempt.notes, "; "))));
  }
  return list;
}

// a row for each cell that is skipped, or has notes without an attempt
Section RemarksSection(const Key& key, std::string_view text_name,
                       const std::vector<SessionRemark>& remarks) {
  Section list{.name = key.name,
               .heading = std::string(key.label),
               .shape = Section::Shape::kTable,
               .detail = document::Detail::kAll};
  for (const SessionRemark& remark : remarks) {
    Section& row = list.sections.emplace_back(CellSection(remark.cell));
    row.Add({"", "cell"}, NameOf(remark.cell));
    row.Add({text_name, text_name}, remark.text);
  }
  return list;
}

}  // namespace

document::Document StatusDocument(std::string_view verb, const SessionFolder& session,
                                  const Findings<FolderFinding>& found) {
  const SessionCounts counts = session.CountsWithout(found);
  document::Document document{.verb = std::string(verb), .title = session.folder()};
  Section& root = document.root;
  root.Add({"", "done"}, fmt::format("{} of {} trials", counts.done, counts.planned));
  root.Add(kPlanned, counts.planned);
  root.Add(kDone, counts.done);
  root.Add({"good", "GOOD"}, counts.good);
  root.Add({"check", "CHECK"}, counts.check);
  root.Add({kBadKey.name, "BAD"}, counts.bad);
  AddNext(counts, root);
  const auto add_if = [&](const Key& key, std::string_view label, std::size_t count) {
    root.Add({key.name, count > 0 ? label : ""}, count);
  };
  root.Add({"attempt_count", "attempts"}, counts.attempts);
  add_if({"skipped_count"}, "cells skipped", counts.skipped);
  const auto running = static_cast<std::size_t>(std::ranges::count_if(
      session.state().attempts,
      [&](const SessionAttempt& attempt) { return session.IsRunning(attempt); }));
  add_if({"attempts_running"}, "attempts being recorded", running);
  add_if({"attempts_not_ended"}, "attempts that did not end", counts.interrupted - running);
  add_if({"attempts_outside_plan"}, "attempts outside the plan", counts.outside);
  add_if({"damaged_lines"}, "lines of the log that are damaged", session.state().damaged_lines);
  const auto lost = static_cast<std::size_t>(
      std::ranges::count_if(found.list(), IsOfLostTrial, &FindingOf<FolderFinding>::kind));
  add_if({"trials_lost"}, "trials missing or damaged", lost);
  document::AddFindings(root, found);
  root.sections.push_back(FloorsSection(counts));
  root.sections.push_back(AttemptsSection(session));
  root.sections.push_back(
      RemarksSection({"skipped", "skipped cells"}, "reason", session.state().skipped));
  root.sections.push_back(RemarksSection({"cell_notes", "notes of cells"}, document::kNotes.name,
                                         session.state().notes));
  return document;
}

document::Document AttemptDocument(std::string_view verb, const SessionFolder& session,
                                   const AttemptOutcome& outcome) {
  const SessionAttempt& attempt = outcome.attempt;
  document::Document document{
      .verb = std::string(verb),
      .title = std::string(Name(*attempt.verdict)) + "  " + NameOf(attempt.cell)};
  Section& root = document.root;
  root.sections.push_back(CellSection(attempt.cell));
  root.Add(kAttempt, attempt.number);
  // an import that cannot be read has none
  const bool has_file = !attempt.reason.ends_with(kNoTrial);
  root.Add({document::kFile.name, "file"},
           document::TextOrNotKnown(has_file ? session.trials() + attempt.file : ""));
  root.Add(document::kVerdict, Name(*attempt.verdict));
  using document::Form;
  root.Add({document::kBandRms.name, "band RMS", document::kMetre, Form::kUncertain},
           outcome.band_rms_m, outcome.band_rms_uncertainty_m);
  root.Add({document::kToneFrequency.name, "tone", document::kHertz, Form::kUncertain},
           outcome.tone_hz, outcome.tone_uncertainty_hz);
  root.Add({"noise_floor", "noise floor"}, document::TextOrNotKnown(outcome.floor));
  root.Add({document::kReasons.name}, outcome.reasons);
  for (const std::string& reason : outcome.reasons) root.Add({"", "because"}, reason);
  const SessionCounts counts = session.Counts();
  AddNext(counts, root);
  if (counts.next == attempt.cell)
    root.items.back().note = "again; session skip continues without it";
  root.Add({"", "done"}, fmt::format("{} of {} trials", counts.done, counts.planned));
  return document;
}

namespace {

// the difference that the study can show; `spread`: relative standard deviation of the subjects'
// differences, where it is stated
void AddDetectable(const SessionPlan& plan, std::optional<double> spread, Section& root) {
  const auto effect = DetectableEffect(plan);
  const std::size_t contrasts = ContrastsOf(plan);
  root.Add({"contrast_count"}, contrasts);
  Item& item = root.Add({"detectable_effect_d_z", "difference that is shown"}, effect);
  item.resolution = 0.01;
  item.note = fmt::format(
      "standard deviations of the subjects' differences, at 80 % power: paired t at 5 %{}",
      contrasts > 1 ? fmt::format(", Holm over {} contrasts", contrasts) : "");
  if (!effect) {
    root.Find(Severity::kNote, "no-detectable-effect",
              "what difference the study can show is not determined: it takes 2 subjects and 2 "
              "conditions at least");
  }
  if (!effect || !spread) return;
  Item& share = root.Add({"detectable_difference", "", document::kShare}, *effect * *spread);
  share.label = "in percent";
  share.resolution = 1e-3;
  share.note = fmt::format("where the subjects' differences scatter by {:g} %", 100 * *spread);
}

// beyond an hour in hours
std::string TimeText(double time_s) {
  if (time_s > kHourS) return fmt::format("{:.3g} h", time_s / kHourS);
  return document::QuantityText(time_s, document::kSecond, 6);
}

// what of a plan should be known before the first trial
void FindInPlan(const SessionPlan& plan, Section& root) {
  for (const auto& [label, names] :
       {std::pair("subject", &plan.subjects), std::pair("condition", &plan.conditions)}) {
    for (const AlikeNames& pair : NamesAlike(*names)) {
      root.Find(
          Severity::kDoubt, "planned-names-alike",
          "the {label}s {one} and {other} differ by {how}: if they are one, plan again in another "
          "folder",
          {{"label", std::string(label)},
           {"one", pair.one},
           {"other", pair.other},
           {"how", std::string(WordsOf(pair.likeness))}});
    }
  }
  const std::size_t rows = DesignRows(plan);
  if (plan.order == SessionOrder::kBalanced && plan.subjects.size() % rows != 0) {
    root.Find(Severity::kNote, "design-incomplete",
              "the design is not complete: its order is balanced where the subjects are a multiple "
              "of {rows}, and they are {subjects}",
              {{"rows", rows}, {"subjects", plan.subjects.size()}});
  }
  const Expectation expected = ExpectationOf(plan);
  if (expected.rms_m || expected.amplitude_m || expected.distance_m) return;
  root.Find(Severity::kNote, "scale-not-checked",
            "scale and polarity of the sensor are not checked: no rms, amplitude or distance is in "
            "--expect");
}

}  // namespace

document::Document PlanDocument(const std::string& folder, const SessionPlan& plan,
                                std::optional<double> spread) {
  const std::vector<SessionCell> cells = CellsOf(plan);
  const SessionCounts counts = CountCells(cells, {});
  document::Document document{.verb = "session new", .title = folder};
  Section& root = document.root;
  root.Add({kPlanned.name, "trials"}, counts.planned);
  root.Add({"", "of"}, fmt::format("{}, {}, {}", Counted(plan.subjects.size(), "subject"),
                                   Counted(plan.conditions.size(), "condition"),
                                   Counted(static_cast<std::size_t>(plan.repeats), "repeat")));
  root.Add({document::kOrder.name, "order"}, Name(plan.order));
  root.sections.push_back(FloorsSection(counts));
  const double recording_s = plan.duration_s * static_cast<double>(cells.size());
  root.Add(document::kRecording, recording_s);
  root.Add({"", "recording"}, TimeText(recording_s)).note = "without what lies between";
  AddDetectable(plan, spread, root);
  FindInPlan(plan, root);
  AddNext(counts, root);
  return document;
}

}  // namespace haptometer::tools
