#include "tests/search/band_reference.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace haptometer::search {
namespace {

using Complex = std::complex<Real>;

constexpr Real kPi = std::numbers::pi_v<Real>;

}  // namespace

BandReference MakeBandReference(int order, double lower_hz, double upper_hz, double rate_hz,
                                bool together) {
  const Real low = std::tan(kPi * Long(lower_hz) / Long(rate_hz));
  const Real high = std::tan(kPi * Long(upper_hz) / Long(rate_hz));
  const Real centre_squared = low * high;
  Real width = high - low;
  if (together) width /= std::pow(std::numbers::sqrt2_v<Real> - 1, Real{1} / (2 * order));
  BandReference band{.order = order, .gain = std::pow(width, Real(order)), .slowest = 1};
  band.narrowness = std::sqrt(centre_squared) / width;
  std::vector<Complex> poles;
  for (int k = 0; k < order; ++k) {
    const Complex half = std::polar(width / 2, kPi * (2 * k + order + 1) / (2 * order));
    const Complex root = std::sqrt(half * half - centre_squared);
    // the larger root without cancellation; the other by their product
    const bool is_sum = std::norm(half + root) > std::norm(half - root);
    const Complex larger = is_sum ? half + root : half - root;
    poles.insert(poles.end(), {larger, centre_squared / larger});
  }
  // conjugates stand together, slow ones first: rounding between sections is then not amplified
  std::ranges::sort(poles, {}, [](const Complex& s) { return std::norm(s); });
  Complex product = 1;
  for (const Complex& s : poles) {
    band.less_one.push_back(Real{2} * s / (Real{1} - s));
    product *= Real{1} - s;
    // 1 - |z| = (1 - |z|^2) / (1 + |z|), and 1 - |z|^2 = -4 Re s / |1 - s|^2
    band.slowest = std::min(band.slowest, -2 * s.real() / std::norm(Real{1} - s));
  }
  band.gain /= product.real();
  band.lowest = std::abs(band.less_one.front());
  return band;
}

void FilterOnce(const BandReference& band, std::vector<Real>& x) {
  std::vector<Complex> values(x.begin(), x.end());
  for (std::size_t k = 0; k < band.less_one.size(); ++k) {
    const Complex q = band.less_one[k];
    // zeros at 1 for the slower half, at -1 for the faster
    const Real zero = k < static_cast<std::size_t>(band.order) ? -1 : 1;
    Complex before;
    Complex state;
    for (Complex& value : values) {
      const Complex in = value + zero * before;
      before = value;
      state += Complex(q.real() * state.real() - q.imag() * state.imag() + in.real(),
                       q.real() * state.imag() + q.imag() * state.real() + in.imag());
      value = state;
    }
  }
  std::ranges::transform(values, x.begin(), [&](const Complex& y) { return band.gain * y.real(); });
}

Real GainOfTwo(const BandReference& band, double frequency_hz, double rate_hz) {
  const Complex z = std::polar(Real{1}, 2 * kPi * Long(frequency_hz) / Long(rate_hz));
  Complex response = band.gain;
  for (const Complex& q : band.less_one) response /= (z - Real{1}) - q;
  for (int k = 0; k < band.order; ++k) response *= z * z - Real{1};
  return std::norm(response);
}

}  // namespace haptometer::search
