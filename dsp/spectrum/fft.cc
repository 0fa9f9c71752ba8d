#include "dsp/spectrum/fft.h"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <numbers>
#include <type_traits>
#include <utility>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kLongestPaired = 65536;  // half a MB

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

}  // namespace

// Both plans work in place on one buffer: of bins as pairs of real and imaginary part, or, paired,
// of samples as half as many complex ones,
//
//   Z[k] = sum over n of (x[2n] + j x[2n+1]) w^2nk,   w = exp(-2 pi j / size),
//   E[k] = (Z[k] + Z*[M-k])/2,   O[k] = -j (Z[k] - Z*[M-k])/2,   X[k] = E[k] + w^k O[k],   M =
//   size/2
struct RealFft::Plans {
  std::size_t size = 0;
  std::unique_ptr<double, FreeFftw> buffer;
  Plan forward;
  Plan inverse;                // made when it is first asked for
  std::vector<Complex> turns;  // paired: w^k up to a quarter turn

  [[nodiscard]] bool is_paired() const { return !turns.empty(); }
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
  // an estimated plan: no measurement, so equal input gives equal bits in every run
  void MakePlan(Plan& plan, bool is_forward) const {
    const auto n = static_cast<int>(is_paired() ? size / 2 : size);
    const std::scoped_lock lock(PlannerMutex());
    if (is_paired()) {
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

RealFft::RealFft(std::size_t size) : plans_(std::make_unique<Plans>()) {
  HAPTOMETER_CHECK(size >= 1 && size <= kLongestTransform, "size = {}", size);
  plans_->size = size;
  plans_->buffer.reset(fftw_alloc_real(2 * plans_->bins()));
  HAPTOMETER_CHECK(plans_->buffer, "no memory for {} samples", size);
  const double turn = -2 * std::numbers::pi / static_cast<double>(size);
  for (std::size_t k = 0; size <= kLongestPaired && size % 2 == 0 && 4 * k <= size; ++k) {
    plans_->turns.push_back(std::polar(1.0, turn * static_cast<double>(k)));
  }
  plans_->MakePlan(plans_->forward, true);
}

RealFft::~RealFft() = default;

std::size_t RealFft::size() const { return plans_->size; }
std::size_t RealFft::bins() const { return plans_->bins(); }

void RealFft::Forward(std::span<const double> in, std::span<std::complex<double>> out) {
  HAPTOMETER_CHECK(in.size() == size() && out.size() == bins(), "{} samples, {} bins for size {}",
                   in.size(), out.size(), size());
  std::ranges::copy(in, plans_->buffer.get());
  fftw_execute(plans_->forward.get());
  if (!plans_->is_paired()) {
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
  auto scale = static_cast<double>(size());
  if (!plans_->is_paired()) {
    for (std::size_t k = 0; k < in.size(); ++k) plans_->SetPair(k, in[k]);
  } else {
    const std::size_t half = size() / 2;
    scale = static_cast<double>(half);
    plans_->SetPair(
        0, {0.5 * (in[0].real() + in[half].real()), 0.5 * (in[0].real() - in[half].real())});
    for (std::size_t k = 1; k < plans_->turns.size(); ++k) {
      const Complex even = 0.5 * (in[k] + std::conj(in[half - k]));
      const Complex odd =
          Product(0.5 * (in[k] - std::conj(in[half - k])), std::conj(plans_->turns[k]));
      // E + j O, and of M - k the conjugates
      plans_->SetPair(k, {even.real() - odd.imag(), even.imag() + odd.real()});
      plans_->SetPair(half - k, {even.real() + odd.imag(), odd.real() - even.imag()});
    }
  }
  fftw_execute(plans_->inverse.get());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = plans_->buffer.get()[k] / scale;
}

std::vector<std::complex<double>> RealSpectrum(std::span<const double> samples) {
  // making a plan takes longer than executing it: a thread's last small one is kept
  thread_local std::unique_ptr<RealFft> kept;
  std::unique_ptr<RealFft> own;
  auto& fft = samples.size() <= kLongestPaired ? kept : own;
  if (!fft || fft->size() != samples.size()) fft = std::make_unique<RealFft>(samples.size());
  std::vector<std::complex<double>> bins(fft->bins());
  fft->Forward(samples, bins);
  return bins;
}

}  // namespace haptometer::dsp
