#include "dsp/analysis/floor_remarks.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

namespace haptometer::dsp {
namespace {

constexpr double kUmPerM = 1e6;
constexpr double kSameRate = 0.01;       // relative
constexpr double kSameFrequency = 0.01;  // relative: a drive is set again no better

}  // namespace

std::vector<std::string> FloorDoubts(const BandNumbers& numbers, double rate_hz) {
  std::vector<std::string> doubts;
  if (!numbers.floor || !(numbers.floor->rate_hz > 0)) return doubts;
  const NoiseFloor& floor = *numbers.floor;
  doubts.reserve(floor.doubts.size() + 2);
  for (const std::string& doubt : floor.doubts) {
    doubts.push_back(fmt::format("the floor {}: {}", floor.source, doubt));
  }
  if (std::abs(floor.rate_hz - rate_hz) > kSameRate * rate_hz) {
    doubts.push_back(fmt::format(
        "the floor {} has {:.4g} readings a second and this trial {:.4g}: a sensor's noise in the "
        "band depends on its rate; take one of the same settings",
        floor.source, floor.rate_hz, rate_hz));
  }
  if (!floor.tone_hz) return doubts;
  const bool is_same = numbers.tone && std::abs(*floor.tone_hz - numbers.tone->fit.frequency_hz) <=
                                           kSameFrequency * numbers.tone->fit.frequency_hz;
  doubts.push_back(fmt::format(
      "the floor {} holds a tone, {:.3g} um at {:.4g} Hz{}: it is taken off as noise; was the "
      "drive off?",
      floor.source, floor.tone_amplitude_m * kUmPerM, *floor.tone_hz,
      is_same ? ", as this trial does" : ""));
  return doubts;
}

void RemarkFloor(const BandNumbers& numbers, BandAnalysis* analysis) {
  if (!numbers.floor) {
    analysis->remarks.emplace_back(
        "noise floor not known: no settled quiet part of 0.1 s beside the window; --floor FILE "
        "takes a drive-off trial");
    return;
  }
  for (std::string& doubt : FloorDoubts(numbers, analysis->record.rate_hz)) {
    analysis->remarks.push_back(std::move(doubt));
  }
  const double floor_um = *numbers.rms.floor_m * kUmPerM;
  if (numbers.rms.floor_contradicts) {
    analysis->reasons.push_back(fmt::format(
        "the floor of {:.3g} um ({}) is above the {:.3g} um that were measured: take one of the "
        "same sensor, settings and rate, drive off",
        floor_um, numbers.floor->source, numbers.rms.as_measured_m * kUmPerM));
  } else if (numbers.rms.below_floor) {
    analysis->remarks.push_back(fmt::format("below the floor of {:.3g} um: at most {:.3g} um",
                                            floor_um, numbers.rms.at_most_m * kUmPerM));
  }
}

}  // namespace haptometer::dsp
