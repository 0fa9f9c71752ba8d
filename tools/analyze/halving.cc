#include "tools/analyze/halving.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dsp/analysis/window/window_remarks.h"
#include "tools/document/findings_dsp.h"

namespace haptometer::tools {
namespace {

// narrower intervals are narrow enough to say nothing
constexpr double kWorthSaying = 0.01;

// squares of the budget's parts, m2
struct Parts {
  double noise = 0;
  double floor = 0;
  double rest = 0;
};

}  // namespace

Halving HowToHalve(const dsp::BandNumbers& numbers) {
  Parts parts;
  std::vector<dsp::UncertaintyLine> fixed;
  for (const dsp::UncertaintyLine& line : numbers.rms.budget) {
    const double square = std::pow(line.standard_uncertainty_m, 2);
    // a beat falls with the length, faster than noise
    if (line.cause == dsp::RmsCause::kNoise || line.cause == dsp::RmsCause::kBeat) {
      parts.noise += square;
    } else if (line.cause == dsp::RmsCause::kNoiseFloor) {
      parts.floor += square;
    } else {
      parts.rest += square;
      fixed.push_back(line);
    }
  }
  const bool has_file = numbers.floor && numbers.floor->from == dsp::NoiseSource::kFile;
  // without a file the noise is the record's own
  if (!has_file) parts.noise += std::exchange(parts.floor, 0);
  const double wanted = (parts.noise + parts.floor + parts.rest) / 4;
  const double window_s = numbers.part.window.end_s - numbers.part.window.begin_s;
  const double for_window = wanted - parts.floor - parts.rest;
  const double for_floor = wanted - parts.noise - parts.rest;
  Halving halving;
  if (!fixed.empty()) halving.largest = dsp::LargestLine(fixed).cause;
  if (for_window > 0) halving.window_s = window_s * parts.noise / for_window;
  if (has_file && for_floor > 0)
    halving.floor_s = numbers.floor->duration_s * parts.floor / for_floor;
  return halving;
}

void AddHalving(const dsp::BandAnalysis& analysis, const std::string& subject,
                document::Section& section) {
  if (!analysis.answered || !analysis.numbers) return;
  const dsp::RmsEstimate& rms = analysis.numbers->rms;
  if (analysis.numbers->is_lower_limit || rms.below_floor) return;
  if (!(0.5 * (rms.upper_m - rms.lower_m) > kWorthSaying * rms.rms_m)) return;
  const Halving halving = HowToHalve(*analysis.numbers);
  if (halving.window_s) {
    std::vector<FindingNumber> numbers{{"length_s", *halving.window_s}};
    if (halving.floor_s) numbers.emplace_back("floor_s", *halving.floor_s);
    section.Find(Severity::kNote, "interval-halved-by-length",
                 "a steady drive of {length_s}[, or a floor record of {floor_s},] would halve the "
                 "interval",
                 std::move(numbers), subject);
  } else if (halving.floor_s) {
    section.Find(Severity::kNote, "interval-halved-by-floor",
                 "a floor record (--floor) of {floor_s} would halve the interval",
                 {{"floor_s", *halving.floor_s}}, subject);
  } else {
    section.Find(Severity::kNote, "interval-not-halved",
                 "no length alone would halve the interval; what none changes is due to {cause} "
                 "most",
                 {{"cause", std::string(document::TextOf(halving.largest).name)}}, subject);
  }
}

}  // namespace haptometer::tools
