#include "dsp/filter/butterworth.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;

// the band on the axis of the bilinear transform
struct WarpedBand {
  double center_square = 0;  // w0^2
  double width = 0;          // bw
};

// tan(b) - tan(a) = sin(b - a) / (cos a cos b): no digits lost in a narrow band
WarpedBand Warp(const BandPass& band, double rate_hz) {
  const double lower = kPi * band.lower_hz / rate_hz;
  const double upper = kPi * band.upper_hz / rate_hz;
  WarpedBand warped;
  warped.center_square = Tan(lower) * Tan(upper);
  warped.width = Sin(kPi * (band.upper_hz - band.lower_hz) / rate_hz) / (Cos(lower) * Cos(upper));
  // both passes have -3 dB where one has -1.5 dB: (bw' / bw)^(2N) = 1 / (sqrt(2) - 1)
  if (band.corners == Corners::kWhole) {
    warped.width /= Pow(std::numbers::sqrt2 - 1, 1.0 / (2 * band.order));
  }
  return warped;
}

// the section with analog poles at the roots of s^2 - 2 re s + square, by s = (z - 1)/(z + 1)
// d = 1 - 2 re + square: e = 4 square / d, f = -4 re / d; a low-pass section has gain 1 at 0
DeltaSection SectionOf(SectionKind kind, double re, double square) {
  const double d = 1 - 2 * re + square;
  return {kind, 4 * square / d, -4 * re / d, kind == SectionKind::kLowPass ? square / d : 1 / d};
}

// the two sections that a conjugate pair of prototype poles becomes; low-pass has the larger pole
struct Pair {
  DeltaSection high;
  DeltaSection low;
  double low_square = 0;  // |pole|^2 of the low-pass section
};

// low-pass to band-pass: a prototype pole p gives the roots q of q^2 - bw p q + w0^2 = 0
Pair PairOf(std::complex<double> prototype_pole, const WarpedBand& warped) {
  // q + w0^2/q = 2 h has two roots; the larger one without cancellation, the other by their product
  const std::complex<double> h = prototype_pole * (warped.width / 2);
  const std::complex<double> root = Sqrt(h * h - warped.center_square);
  const std::complex<double> sum = h + root;
  const std::complex<double> difference = h - root;
  const std::complex<double> large = std::norm(sum) >= std::norm(difference) ? sum : difference;
  const std::complex<double> small = warped.center_square / large;
  return {SectionOf(SectionKind::kHighPass, small.real(), std::norm(small)),
          SectionOf(SectionKind::kLowPass, large.real(), std::norm(large)), std::norm(large)};
}

Result<void> Check(const BandPass& band, double rate_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) {
    return Usage("sample rate", fmt::format("is {} Hz", rate_hz), "give a positive rate");
  }
  if (band.order < 1 || band.order > kHighestOrder) {
    return Usage("order", fmt::format("{} is not possible", band.order),
                 fmt::format("choose 1 to {}", kHighestOrder));
  }
  if (!(band.lower_hz > 0) || !(band.upper_hz > band.lower_hz) || !std::isfinite(band.upper_hz)) {
    return Usage("band", fmt::format("{}-{} Hz is not a band", band.lower_hz, band.upper_hz),
                 "give a lower corner above 0 and an upper corner above it, as 20-500Hz");
  }
  if (!(band.upper_hz < rate_hz / 2)) {
    return Usage("band",
                 fmt::format("its upper corner of {} Hz is not below half the rate of {} Hz",
                             band.upper_hz, rate_hz),
                 fmt::format("lower the corner below {} Hz", rate_hz / 2));
  }
  return {};
}

// s and c are the sine and cosine of pi f / rate, so that 1 - 1/z has no cancellation near f = 0
std::complex<double> SectionResponse(const DeltaSection& section, double s, double c) {
  // denominator e + f u + u^2 z with u = 1 - 1/z = 2 s (s + j c); numerators times z as well
  const std::complex<double> denominator(section.e - 4 * s * s + 2 * section.f * s * s,
                                         2 * section.f * s * c);
  switch (section.kind) {
    case SectionKind::kHighPass:
      return -4 * section.b * s * s / denominator;
    case SectionKind::kBandPass:
      return std::complex<double>(0, 4 * section.b * s * c) / denominator;
    case SectionKind::kLowPass:
      return 4 * section.b * c * c / denominator;
  }
  HAPTOMETER_CHECK(false, "section kind {}", static_cast<int>(section.kind));
}

// -ln of the larger pole radius
double DecayPerSample(const DeltaSection& section) {
  const double sum = section.e + section.f;  // poles 1 + delta: delta^2 + (e + f) delta + e = 0
  const double discriminant = sum * sum - 4 * section.e;
  // a conjugate pair has radius^2 = 1 - f
  if (discriminant <= 0) return -0.5 * Log1p(-section.f);
  // two real poles 1 - delta, in a wide band that ends near half the rate below 0; the smaller
  // delta as a quotient, free of cancellation
  const double larger = (sum + std::sqrt(discriminant)) / 2;
  const auto decay = [](double delta) { return -Log1p(delta < 1 ? -delta : delta - 2); };
  return std::min(decay(section.e / larger), decay(larger));
}

}  // namespace

Result<FilterDesign> DesignBandPass(const BandPass& band, double rate_hz) {
  HAPTOMETER_TRY(Check(band, rate_hz));
  const WarpedBand warped = Warp(band, rate_hz);
  const int n = band.order;

  // prototype poles of the upper half plane, exp(j pi (2k + n + 1) / 2n), most damped first: their
  // high-pass poles then come in order of size, and so do the low-pass ones when taken backwards
  std::vector<Pair> pairs;
  pairs.reserve(static_cast<std::size_t>(n / 2));
  for (int k = n / 2 - 1; k >= 0; --k) {
    const double angle = kPi * (2 * k + 1) / (2 * n);
    pairs.push_back(PairOf({-Sin(angle), Cos(angle)}, warped));
  }

  FilterDesign design{n, {}, rate_hz};
  design.sections.reserve(static_cast<std::size_t>(n));
  // H = bw^n s^n / product of denominators; low-pass sections already have |pole|^2 as numerator
  double gain = Pow(warped.width, n);
  for (const Pair& pair : pairs) {
    design.sections.push_back(pair.high);
    gain /= pair.low_square;
  }
  // the real prototype pole -1 of an odd order: s^2 + bw s + w0^2
  if (n % 2 == 1) {
    design.sections.push_back(
        SectionOf(SectionKind::kBandPass, -warped.width / 2, warped.center_square));
  }
  for (auto pair = pairs.rbegin(); pair != pairs.rend(); ++pair) {
    design.sections.push_back(pair->low);
  }
  // all of the gain in the last section, where an offset is already removed
  design.sections.back().b *= gain;
  return design;
}

std::complex<double> Response(const FilterDesign& design, double frequency_hz) {
  // z = exp(2 j pi f / rate) by half its angle
  const double half_angle = kPi * frequency_hz / design.rate_hz;
  const auto [s, c] = SinCos(half_angle);
  std::complex<double> product = 1;
  for (const DeltaSection& section : design.sections) product *= SectionResponse(section, s, c);
  return product;
}

double Magnitude(const FilterDesign& design, double frequency_hz) {
  return Abs(Response(design, frequency_hz));
}

double SlowestDecayPerS(const FilterDesign& design) {
  double slowest = DecayPerSample(design.sections.front());
  for (const DeltaSection& section : design.sections) {
    slowest = std::min(slowest, DecayPerSample(section));
  }
  return slowest * design.rate_hz;
}

}  // namespace haptometer::dsp
