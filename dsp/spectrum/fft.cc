#include "dsp/spectrum/fft.h"

#include <fftw3.h>

#include <algorithm>
#include <mutex>
#include <type_traits>

#include "base/check.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kLongestKept = 65536;  // half a MB

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

}  // namespace

// both plans work in place on one buffer: samples, or bins as pairs of real and imaginary part
struct RealFft::Plans {
  std::size_t size = 0;
  std::unique_ptr<double, FreeFftw> buffer;
  Plan forward;
  Plan inverse;  // made when it is first asked for: making one costs as much as executing it

  [[nodiscard]] std::size_t bins() const { return size / 2 + 1; }
};

RealFft::RealFft(std::size_t size) : plans_(std::make_unique<Plans>()) {
  HAPTOMETER_CHECK(size >= 1 && size <= kLongestTransform, "size = {}", size);
  plans_->size = size;
  plans_->buffer.reset(fftw_alloc_real(2 * plans_->bins()));
  double* const values = plans_->buffer.get();
  HAPTOMETER_CHECK(values != nullptr, "no memory for {} samples", size);
  auto* const spectrum = reinterpret_cast<fftw_complex*>(values);
  const std::scoped_lock lock(PlannerMutex());
  plans_->forward.reset(
      fftw_plan_dft_r2c_1d(static_cast<int>(size), values, spectrum, FFTW_ESTIMATE));
  HAPTOMETER_CHECK(plans_->forward, "no plan for {} samples", size);
}

RealFft::~RealFft() = default;
RealFft::RealFft(RealFft&&) noexcept = default;
RealFft& RealFft::operator=(RealFft&&) noexcept = default;

std::size_t RealFft::size() const { return plans_->size; }
std::size_t RealFft::bins() const { return plans_->bins(); }

void RealFft::Forward(std::span<const double> in, std::span<std::complex<double>> out) {
  HAPTOMETER_CHECK(in.size() == size() && out.size() == bins(), "{} samples, {} bins for size {}",
                   in.size(), out.size(), size());
  const double* const values = plans_->buffer.get();
  std::ranges::copy(in, plans_->buffer.get());
  fftw_execute(plans_->forward.get());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = {values[2 * k], values[2 * k + 1]};
}

void RealFft::Inverse(std::span<const std::complex<double>> in, std::span<double> out) {
  HAPTOMETER_CHECK(in.size() == bins() && out.size() == size(), "{} bins, {} samples for size {}",
                   in.size(), out.size(), size());
  double* const values = plans_->buffer.get();
  if (!plans_->inverse) {
    auto* const spectrum = reinterpret_cast<fftw_complex*>(values);
    const std::scoped_lock lock(PlannerMutex());
    plans_->inverse.reset(
        fftw_plan_dft_c2r_1d(static_cast<int>(size()), spectrum, values, FFTW_ESTIMATE));
    HAPTOMETER_CHECK(plans_->inverse, "no plan for {} samples", size());
  }
  for (std::size_t k = 0; k < in.size(); ++k) {
    values[2 * k] = in[k].real();
    values[2 * k + 1] = in[k].imag();
  }
  fftw_execute(plans_->inverse.get());
  const auto n = static_cast<double>(size());
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = values[k] / n;
}

std::vector<std::complex<double>> RealSpectrum(std::span<const double> samples) {
  // a plan takes several times as long to make as to execute: the last small one is kept
  thread_local std::unique_ptr<RealFft> kept;
  std::unique_ptr<RealFft> own;
  auto& fft = samples.size() <= kLongestKept ? kept : own;
  if (!fft || fft->size() != samples.size()) fft = std::make_unique<RealFft>(samples.size());
  std::vector<std::complex<double>> bins(fft->bins());
  fft->Forward(samples, bins);
  return bins;
}

}  // namespace haptometer::dsp
