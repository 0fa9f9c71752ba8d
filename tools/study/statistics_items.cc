#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/text.h"
#include "dsp/statistics/distributions.h"
#include "tools/study/alike_names.h"
#include "tools/study/study_document.h"

namespace haptometer::tools {
namespace {

using document::Item;
using document::Key;
using document::MemberOf;
using document::Range;
using document::Section;
using document::Value;

// adds t, df and p for JSON; returns the text of the line
std::string TestText(Section& section, const std::optional<dsp::StudentTest>& test) {
  const dsp::StudentTest known = test.value_or(dsp::StudentTest{});
  section.Add({"t"}, MemberOf(test, &dsp::StudentTest::t));
  section.Add({"df"}, MemberOf(test, &dsp::StudentTest::df));
  section.Add(kP, MemberOf(test, &dsp::StudentTest::p));
  return fmt::format("t({:g}) = {:.4g}, p = {:.3g}", known.df, known.t, known.p);
}

}  // namespace

std::string Counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

// u = s / sqrt(n)
std::optional<double> StandardUncertaintyOf(const dsp::OneSample& sample) {
  if (!sample.standard_deviation) return std::nullopt;
  return *sample.standard_deviation / std::sqrt(static_cast<double>(sample.n));
}

// half width over Student's critical value
double StandardUncertaintyOf(const dsp::Interval& interval, double df) {
  return (interval.upper - interval.lower) / 2 / dsp::StudentCritical(df);
}

// two significant digits of the standard uncertainty
double ResolutionBy(std::optional<double> standard_uncertainty) {
  const double known = standard_uncertainty.value_or(0);
  return known > 0 ? std::pow(10, std::floor(std::log10(known)) - 1) : 0;
}

void AddLabelsAlike(const std::string& label, const std::vector<std::string>& names,
                    StudyFindings& findings) {
  for (const AlikeNames& pair : NamesAlike(names)) {
    findings.Doubt(StudyFinding::kLabelsAlike, {{"label", label},
                                                {"one", pair.one},
                                                {"other", pair.other},
                                                {"how", std::string(WordsOf(pair.likeness))}});
  }
}

void AddDeviations(const std::vector<StudyTrial>& trials, StudyFindings& findings) {
  const auto answered =
      static_cast<std::size_t>(std::ranges::count_if(trials, &StudyTrial::answered));
  for (Deviation& deviation : FindDeviations(trials)) {
    // number of trials that it concerns, and their files unless it concerns all
    FindingOf<StudyFinding>& finding = deviation.finding;
    finding.numbers.emplace_back("trials", deviation.files.size());
    finding.numbers.emplace_back("of_trials", answered);
    if (deviation.files.size() < answered) {
      finding.subject = fmt::format("{}", fmt::join(deviation.files, ", "));
    }
    findings.Add(std::move(finding));
  }
}

void AddEqualFiles(const std::vector<std::string>& paths, StudyFindings& findings) {
  std::map<std::string, std::size_t> places;  // by SHA-256
  std::vector<std::vector<std::string>> groups;
  for (const std::string& path : paths) {
    const std::string sha256 = document::HashOfInput(path);
    if (sha256.empty()) continue;
    const auto [place, is_new] = places.try_emplace(sha256, groups.size());
    if (is_new) groups.emplace_back();
    groups[place->second].push_back(Printable(path));
  }
  for (const std::vector<std::string>& group : groups) {
    if (group.size() < 2) continue;
    findings.Add({Severity::kDoubt,
                  StudyFinding::kEqualFiles,
                  {{"files", group.size()}},
                  fmt::format("{}", fmt::join(group, ", "))});
  }
}

void RefuseUntested(const std::string& subject, const dsp::OneSample& sample,
                    StudyFindings& findings) {
  if (sample.test) return;
  // fewer than two subjects, or equal values of all subjects: no test
  const bool is_few = sample.n < 2;
  findings.Add({Severity::kRefusal,
                is_few ? StudyFinding::kTooFewSubjects : StudyFinding::kNoSpread,
                {{"subjects", sample.n}},
                subject});
}

Item& AddMean(Section& section, const Key& key, const dsp::OneSample& sample) {
  Item& item =
      section.Add(key, sample.n > 0 ? Value(sample.mean) : Value(), StandardUncertaintyOf(sample));
  if (sample.test) item.interval = sample.test->mean;
  return item;
}

// ratio = exp(mean of logarithms)
Item& AddRatio(Section& section, const Key& key, const dsp::OneSample& logarithms) {
  Item& item = AddMean(section, key, logarithms);
  if (logarithms.n == 0) return item;
  const double ratio = std::exp(logarithms.mean);
  item.value = ratio;
  // u(r) = r u(ln r)
  if (item.standard_uncertainty) *item.standard_uncertainty *= ratio;
  // the interval of a ratio is not symmetric
  if (item.interval) {
    item.interval = Range{std::exp(item.interval->lower), std::exp(item.interval->upper)};
  }
  return item;
}

void AddTest(Section& section, std::string_view label,
             const std::optional<dsp::StudentTest>& test) {
  const std::string text = TestText(section, test);
  section.Add({"", label}, test ? Value(text) : Value());
}

void AddTest(Section& section, std::string_view label, const std::optional<dsp::StudentTest>& test,
             const std::optional<double>& p_holm) {
  std::string text = TestText(section, test);
  section.Add({"p_holm"}, p_holm);
  if (p_holm) text += fmt::format(", after Holm {:.3g}", *p_holm);
  section.Add({"", label}, test ? Value(text) : Value());
}

}  // namespace haptometer::tools
