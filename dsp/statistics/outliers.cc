#include "dsp/statistics/outliers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// a value that can be tested
struct Candidate {
  std::size_t group = 0;
  std::size_t place = 0;
  double residual = 0;
  double free = 1;   // 1 - leverage
  double least = 0;  // standard deviation
};

// residuals of a fit
struct Fit {
  std::vector<Candidate> candidates;
  double squares = 0;             // sum of squared residuals
  double degrees_of_freedom = 0;  // of it
  double tests = 0;               // values that do not deviate alike by construction
};

Outlier Studentized(const Candidate& of, const Fit& fit) {
  const double df = fit.degrees_of_freedom - 1;
  // without the value itself; rounding may leave less than nothing
  const double others = std::max(0.0, fit.squares - of.residual * of.residual / of.free) / df;
  const double t = of.residual / (std::sqrt(of.free) * std::max(std::sqrt(others), of.least));
  return {.group = of.group,
          .place = of.place,
          .deviation = of.residual / of.free,
          .t = t,
          .p = std::min(1.0, fit.tests * StudentTwoSidedP(t, df))};
}

// the value farthest out, with the one of its group that deviates alike; none within the rule
std::vector<Outlier> Farthest(const Fit& fit, double false_alarms) {
  if (!(fit.degrees_of_freedom > 1)) return {};
  std::vector<Outlier> found;
  for (const Candidate& candidate : fit.candidates) {
    const Outlier one = Studentized(candidate, fit);
    // equal but for rounding: the same group's only
    const bool is_alike = !found.empty() && found[0].group == one.group &&
                          std::abs(std::abs(one.deviation / found[0].deviation) - 1) < 1e-9;
    if (is_alike) {
      found.push_back(one);
    } else if (found.empty() || std::abs(one.t) > std::abs(found[0].t)) {
      found = {one};
    }
  }
  if (found.empty() || found[0].p > false_alarms) return {};
  return found;
}

Fit FitOfGroups(const std::vector<std::vector<double>>& groups,
                const std::vector<std::vector<double>>& least,
                const std::vector<std::vector<std::size_t>>& places) {
  Fit fit;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto n = static_cast<double>(groups[g].size());
    if (n < 2) continue;
    const double mean = Mean(groups[g]);
    for (std::size_t i = 0; i < groups[g].size(); ++i) {
      const double residual = groups[g][i] - mean;
      fit.squares += residual * residual;
      fit.candidates.push_back({.group = g,
                                .place = places[g][i],
                                .residual = residual,
                                .free = 1 - 1 / n,
                                .least = least[g][places[g][i]]});
    }
    fit.degrees_of_freedom += n - 1;
    fit.tests += n == 2 ? 1 : n;
  }
  return fit;
}

Fit FitOfTable(const CompleteTable& table, const CompleteTable& least,
               const std::vector<std::size_t>& subjects) {
  const std::size_t conditions = table.conditions();
  const auto n = static_cast<double>(subjects.size());
  const auto k = static_cast<double>(conditions);
  std::vector<double> means(conditions);
  for (const std::size_t s : subjects) {
    for (std::size_t c = 0; c < conditions; ++c) means[c] += table.At(s, c) / n;
  }
  const double grand = Mean(means);
  Fit fit{.candidates = {},
          .squares = 0,
          .degrees_of_freedom = (n - 1) * (k - 1),
          .tests = conditions == 2 ? n : n * k};
  for (const std::size_t s : subjects) {
    const double subject = Mean(table.Subject(s)) - grand;
    for (std::size_t c = 0; c < conditions; ++c) {
      const double residual = table.At(s, c) - subject - means[c];
      fit.squares += residual * residual;
      fit.candidates.push_back({.group = s,
                                .place = c,
                                .residual = residual,
                                .free = fit.degrees_of_freedom / (n * k),
                                .least = least.At(s, c)});
    }
  }
  return fit;
}

}  // namespace

std::vector<Outlier> OutliersOfGroups(std::vector<std::vector<double>> groups,
                                      const std::vector<std::vector<double>>& least,
                                      double false_alarms) {
  std::vector<std::vector<std::size_t>> places;
  places.reserve(groups.size());
  for (const std::vector<double>& group : groups) {
    std::vector<std::size_t>& of = places.emplace_back(group.size());
    std::iota(of.begin(), of.end(), std::size_t{0});
  }
  std::vector<Outlier> outliers;
  while (true) {
    const auto found = Farthest(FitOfGroups(groups, least, places), false_alarms);
    if (found.empty()) return outliers;
    for (const Outlier& one : found) {
      outliers.push_back(one);
      // without it, what else stands apart is no longer hidden by it
      const auto at = std::ranges::find(places[one.group], one.place) - places[one.group].begin();
      groups[one.group].erase(groups[one.group].begin() + at);
      places[one.group].erase(places[one.group].begin() + at);
    }
  }
}

std::vector<Outlier> OutliersOfTable(const CompleteTable& table, const CompleteTable& least,
                                     double false_alarms) {
  std::vector<std::size_t> subjects(table.subjects());
  std::iota(subjects.begin(), subjects.end(), std::size_t{0});
  std::vector<Outlier> outliers;
  while (subjects.size() >= 3 && table.conditions() >= 2) {
    const auto found = Farthest(FitOfTable(table, least, subjects), false_alarms);
    if (found.empty()) break;
    outliers.insert(outliers.end(), found.begin(), found.end());
    std::erase(subjects, found[0].group);
  }
  return outliers;
}

}  // namespace haptometer::dsp
