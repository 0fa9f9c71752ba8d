#include "dsp/spectrum/fft.h"

#include <fftw3.h>

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <numbers>
#include <type_traits>
#include <utility>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kLongestComplex = 65536;  // half a MB

// FFTW's planner is not thread-safe; execution is
std::mutex& PlannerMutex() {
  static std::mutex mutex;
  return mutex;
}

struct FreeFftw {
  void operator()(double* memory) const { fftw_free(memory); }
};

struct DestroyPlan {
  void operator()(fftw_plan plan) const {
    const std::scoped_lock lock(PlannerMutex());
    fftw_destroy_plan(plan);
  }
};

using Plan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, DestroyPlan>;
using Complex = std::complex<double>;

// without the checks for infinity of the operator
Complex Product(const Complex& a, const Complex& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// How samples lie in the buffer.
enum class Layout : std::uint8_t {
  kPaired,   // an even number as half as many complex ones
  kComplex,  // an odd number as complex ones
  kReal,     // many: FFTW's own transform of real samples
};

}  // namespace

// Both plans work in place on one buffer. Paired, with M = size / 2 and w = exp(-2 pi j / size),
//
//   Z[k] = sum over n of (x[2n] + j x[2n+1]) w^2nk,
//   E[k] = (Z[k] + Z*[M-k])/2,   O[k] = -j (Z[k] - Z*[M-k])/2,   X[k] = E[k] + w^k O[k]
struct RealFft::Plans {
  std::size_t size = 0;
  Layout layout = Layout::kReal;
  std::unique_ptr<double, FreeFftw> buffer;
  Plan forward;
  Plan inverse;                // made when it is first asked for
  std::vector<Complex> turns;  // paired: w^k up to a quarter turn

  explicit Plans(std::size_t samples)
      : size(samples),
        layout(size > kLongestComplex ? Layout::kReal
               : size % 2 == 0        ? Layout::kPaired
                                      : Layout::kComplex),
        buffer(fftw_alloc_real(2 * (layout == Layout::kComplex ? size : bins()))) {
    HAPTOMETER_CHECK(buffer, "no memory for {} samples", size);
    const double turn = -2 * std::numbers::pi / static_cast<double>(size);
    for (std::size_t k = 0; layout == Layout::kPaired && 4 * k <= size; ++k) {
      turns.push_back(std::polar(1.0, turn * static_cast<double>(k)));
    }
    MakePlan(forward, true);
  }

  [[nodiscard]] std::size_t bins() const { return size / 2 + 1; }
  [[nodiscard]] fftw_complex* pairs() const {
    return reinterpret_cast<fftw_complex*>(buffer.get());
  }
  [[nodiscard]] Complex Pair(std::size_t k) const {
    return {buffer.get()[2 * k], buffer.get()[2 * k + 1]};
  }
  void SetPair(std::size_t k, const Complex& pair) const {
    buffer.get()[2 * k] = pair.real();
    buffer.get()[2 * k + 1] = pair.imag();
  }
  // E + j O of bins, and of M - k the conjugates; of the first and the last the real parts
  void SetPairs(std::span<const Complex> in) const {
    const std::size_t half = size / 2;
    SetPair(0, {0.5 * (in[0].real() + in[half].real()), 0.5 * (in[0].real() - in[half].real())});
    for (std::size_t k = 1; k < turns.size(); ++k) {
      const Complex even = 0.5 * (in[k] + std::conj(in[half - k]));
      const Complex odd = Product(0.5 * (in[k] - std::conj(in[half - k])), std::conj(turns[k]));
      SetPair(k, {even.real() - odd.imag(), even.imag() + odd.real()});
      SetPair(half - k, {even.real() + odd.imag(), odd.real() - even.imag()});
    }
  }
  // an estimated plan: no measurement, so equal input gives equal bits in every run
  void MakePlan(Plan& plan, bool is_forward) const {
    const auto n = static_cast<int>(layout == Layout::kPaired ? size / 2 : size);
    const std::scoped_lock lock(PlannerMutex());
    if (layout != Layout::kReal) {
      plan.reset(fftw_plan_dft_1d(n, pairs(), pairs(), is_forward ? FFTW_FORWARD : FFTW_BACKWARD,
                                  FFTW_ESTIMATE));
    } else if (is_forward) {
      plan.reset(fftw_plan_dft_r2c_1d(n, buffer.get(), pairs(), FFTW_ESTIMATE));
    } else {
      plan.reset(fftw_plan_dft_c2r_1d(n, pairs(), buffer.get(), FFTW_ESTIMATE));
    }
    HAPTOMETER_CHECK(plan, "no plan for {} samples", size);
  }
};

RealFft::RealFft(std::size_t size) {
  HAPTOMETER_CHECK(size >= 1 && size <= kLongestTransform, "size = {}", size);
  plans_ = std::make_unique<Plans>(size);
}

RealFft::~RealFft() = default;

std::size_t RealFft::size() const { return plans_->size; }
std::size_t RealFft::bins() const { return plans_->bins(); }

void RealFft::Forward(std::span<const double> in, std::span<std::complex<double>> out) {
  HAPTOMETER_CHECK(in.size() == size() && out.size() == bins(), "{} samples, {} bins for size {}",
                   in.size(), out.size(), size());
  for (std::size_t k = 0; k < in.size(); ++k) {
    if (plans_->layout == Layout::kComplex) plans_->SetPair(k, in[k]);
    if (plans_->layout != Layout::kComplex) plans_->buffer.get()[k] = in[k];
  }
  fftw_execute(plans_->forward.get());
  if (plans_->layout != Layout::kPaired) {
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = plans_->Pair(k);
    return;
  }
  // bins k and M - k from the same pair; Z is periodic in M
  const std::size_t half = size() / 2;
  for (std::size_t k = 0; k < plans_->turns.size(); ++k) {
    const Complex mirrored = std::conj(plans_->Pair((half - k) % half));
    const Complex even = 0.5 * (plans_->Pair(k) + mirrored);
    const Complex difference = 0.5 * (plans_->Pair(k) - mirrored);
    const Complex odd{difference.imag(), -difference.real()};
    const Complex turned = Product(odd, plans_->turns[k]);
    out[k] = even + turned;
    out[half - k] = std::conj(even - turned);
  }
}

void RealFft::Inverse(std::span<const std::complex<double>> in, std::span<double> out) {
  HAPTOMETER_CHECK(in.size() == bins() && out.size() == size(), "{} bins, {} samples for size {}",
                   in.size(), out.size(), size());
  if (!plans_->inverse) plans_->MakePlan(plans_->inverse, false);
  // FFTW does not scale: forward and inverse together multiply by the number of values
  const bool is_paired = plans_->layout == Layout::kPaired;
  const auto scale = static_cast<double>(is_paired ? size() / 2 : size());
  if (is_paired) {
    plans_->SetPairs(in);
  } else {
    for (std::size_t k = 0; k < in.size(); ++k) plans_->SetPair(k, k > 0 ? in[k] : in[k].real());
    // of an odd number of complex values: the bins above are the conjugates of those below
    for (std::size_t k = 1; plans_->layout == Layout::kComplex && k < in.size(); ++k) {
      plans_->SetPair(size() - k, std::conj(in[k]));
    }
  }
  fftw_execute(plans_->inverse.get());
  const std::size_t stride = plans_->layout == Layout::kComplex ? 2 : 1;
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = plans_->buffer.get()[k * stride] / scale;
}

std::size_t FastTransformSize(std::size_t size) {
  constexpr std::size_t kShort = 256;
  if (size <= kShort) return size;
  for (size -= size % 2;; size -= 2) {
    std::size_t rest = size;
    for (const std::size_t factor : {2U, 3U, 5U, 7U}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return size;
  }
}

std::vector<std::complex<double>> RealSpectrum(std::span<const double> samples) {
  // making a plan takes longer than executing it: a thread's last small one is kept
  thread_local std::unique_ptr<RealFft> kept;
  std::unique_ptr<RealFft> own;
  auto& fft = samples.size() <= kLongestComplex ? kept : own;
  if (!fft || fft->size() != samples.size()) fft = std::make_unique<RealFft>(samples.size());
  std::vector<std::complex<double>> bins(fft->bins());
  fft->Forward(samples, bins);
  return bins;
}

}  // namespace haptometer::dsp
