// The filters against pole by pole in long double.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/zero_phase.h"
#include "tests/search/band_reference.h"
#include "tests/search/draws.h"

namespace haptometer::search {
namespace {

struct Filter {
  dsp::BandPass band{};
  double rate_hz = 0;
  BandReference reference{};
};

// `narrowest`: of lower corner and width, over the rate
Filter DrawFilter(double narrowest) {
  Filter filter{.rate_hz = Decades("rate_hz", 1e3, 1e6)};
  filter.band.order = Whole("order", 1, dsp::kHighestOrder);
  filter.band.lower_hz = Decades("lower_hz", narrowest * filter.rate_hz, 0.4 * filter.rate_hz);
  const double width_hz = Decades("width_hz", narrowest * filter.rate_hz, 0.4 * filter.rate_hz);
  filter.band.upper_hz = std::min(filter.band.lower_hz + width_hz, 0.49 * filter.rate_hz);
  const bool together = Flag("together");
  filter.band.corners = together ? dsp::Corners::kWhole : dsp::Corners::kEach;
  filter.reference = MakeBandReference(filter.band.order, filter.band.lower_hz,
                                       filter.band.upper_hz, filter.rate_hz, together);
  return filter;
}

// sines anywhere below half the rate, or an impulse; an offset of up to 1000 times that
std::vector<double> DrawSignal() {
  std::vector<double> x(static_cast<std::size_t>(Whole("samples", 1, 20'000)));
  const int sines = Whole("sines", 0, 3);
  for (int k = 0; k < sines; ++k) {
    const double amplitude = Decades("amplitude", 1e-3, 1);
    const double turns = Decades("turns_per_sample", 1e-6, 0.5);
    for (std::size_t n = 0; n < x.size(); ++n) {
      x[n] += amplitude * std::sin(2 * std::numbers::pi * turns * static_cast<double>(n));
    }
  }
  if (sines == 0) x[x.size() / 2] = 1;
  const double offset = Flag("has_offset") ? Decades("offset", 1e-3, 1e3) : 0;
  for (double& value : x) value += offset;
  return x;
}

// The bar. A state is rounded by u = 2^-53 of itself in each sample. What that adds to a slope is
// carried on for 1/lowest samples, so that it becomes so many times larger, and dies away in
// 1/slowest samples, over which it adds up as a random walk. Coefficients rounded by u move a pole
// by u of its frequency, which is w0/bw of the band's width. Each section does so; 8 stands for the
// few roundings of a section, and for the largest of many samples.
double Bar(const BandReference& band, double peak, int passes) {
  const Real carried = 1 / std::min(band.lowest, Real{1});
  const Real walk = carried / std::sqrt(band.slowest) + band.narrowness;
  return 8 * 0x1p-53 * passes * band.order * static_cast<double>(walk) * peak;
}

double Worst(std::span<const double> ours, std::span<const Real> truth) {
  Real worst = 0;
  for (std::size_t k = 0; k < ours.size(); ++k) {
    if (!std::isfinite(ours[k])) return std::numeric_limits<double>::quiet_NaN();
    worst = std::max(worst, std::abs(Long(ours[k]) - truth[k]));
  }
  return static_cast<double>(worst);
}

double PeakFrom(std::span<const double> x, double level) {
  double peak = 0;
  for (const double value : x) peak = std::max(peak, std::abs(value - level));
  return peak;
}

bool SameBytes(std::span<const double> a, std::span<const double> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

void CheckOnePass() {
  const Filter filter = DrawFilter(1e-5);
  const std::vector<double> x = DrawSignal();
  const bool from_first = Flag("from_first");
  const auto design = dsp::DesignBandPass(filter.band, filter.rate_hz);
  Require("a band that is possible is designed", design.has_value());
  const double level = from_first ? x[0] : 0;
  std::vector<double> ours(x.size());
  std::vector<double> pieces = x;
  dsp::Cascade whole(*design);
  dsp::Cascade split(*design);
  if (from_first) {
    whole.StartFrom(level);
    split.StartFrom(level);
  }
  whole.Process(x, ours);
  Noise lengths(Whole("split_seed", 0, 1'000'000));
  for (std::span<double> rest = pieces; !rest.empty();) {
    const auto piece = rest.first(std::min(rest.size(), lengths.Below(500)));
    split.Process(piece, piece);
    rest = rest.subspan(piece.size());
  }
  Require("any split gives the same bytes", SameBytes(ours, pieces));
  std::vector<Real> truth(x.begin(), x.end());
  for (Real& value : truth) value -= Long(level);
  FilterOnce(filter.reference, truth);
  Hold("one pass", Worst(ours, truth), Bar(filter.reference, PeakFrom(x, level), 1));
}

// the signal turned about its end points, and beyond what that gives its last value
std::vector<Real> Continued(std::span<const double> x, std::size_t more) {
  std::vector<Real> all(x.size() + 2 * more);
  std::ranges::copy(x, all.begin() + static_cast<std::ptrdiff_t>(more));
  for (std::size_t k = 1; k <= more; ++k) {
    const std::size_t far = std::min(k, x.size() - 1);
    all[more - k] = 2 * Long(x.front()) - Long(x[far]);
    all[more + x.size() - 1 + k] = 2 * Long(x.back()) - Long(x[x.size() - 1 - far]);
  }
  return all;
}

// a pass that begins as if its first value had stood for ever; a band-pass takes that away
void PassFromFirst(const BandReference& band, std::vector<Real>& x) {
  const Real first = x[0];
  for (Real& value : x) value -= first;
  FilterOnce(band, x);
}

void CheckZeroPhase() {
  const Filter filter = DrawFilter(2e-3);
  const std::vector<double> x = DrawSignal();
  const auto design = dsp::DesignBandPass(filter.band, filter.rate_hz);
  Require("a band that is possible is designed", design.has_value());
  const std::vector<double> ours = dsp::FilterZeroPhase(*design, x);
  Require("two threads give the same bytes", SameBytes(ours, dsp::FilterZeroPhase(*design, x, 2)));
  // e^-45 = 3e-20
  const auto more = static_cast<std::size_t>(45 / filter.reference.slowest);
  std::vector<Real> truth = Continued(x, more);
  PassFromFirst(filter.reference, truth);
  std::ranges::reverse(truth);
  PassFromFirst(filter.reference, truth);
  std::ranges::reverse(truth);
  // a turned signal is up to three times as far from its end point
  Hold("two passes", Worst(ours, std::span(truth).subspan(more, x.size())),
       Bar(filter.reference, 2 * PeakFrom(x, x[0]), 2));
}

}  // namespace

bool FilterCase() {
  if (Flag("two_passes")) {
    CheckZeroPhase();
  } else {
    CheckOnePass();
  }
  return true;
}

}  // namespace haptometer::search
