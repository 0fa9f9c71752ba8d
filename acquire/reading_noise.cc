#include "acquire/reading_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace haptometer::acquire {

double NoiseDensity(const ReadingNoise& noise, double frequency_hz) {
  HAPTOMETER_CHECK(noise.rate_hz > 0, "rate_hz = {}", noise.rate_hz);
  const double white = 2 * noise.noise_rms_m * noise.noise_rms_m / noise.rate_hz;
  // readings in a span: what is less than one apart overlaps
  const double overlapping = noise.rate_hz * noise.span_s;
  double sum = 1;
  for (int j = 1; j < overlapping; ++j) {
    sum += 2 * (1 - j / overlapping) *
           std::cos(2 * std::numbers::pi * frequency_hz * j / noise.rate_hz);
  }
  return white * sum;
}

std::vector<FoldedImage> ImagesInBand(const HeldOutput& output, double lower_hz, double upper_hz,
                                      double least) {
  HAPTOMETER_CHECK(output.sampling_s > 0 && output.daq_rate_hz > 0 && least > 0, "{} s, {} Hz, {}",
                   output.sampling_s, output.daq_rate_hz, least);
  const double tone_hz = output.frequency_hz;
  std::vector<FoldedImage> images;
  // f / (k / T - f) >= least up to this k
  const double most = tone_hz * output.sampling_s * (1 + 1 / least);
  for (int k = 1; k <= most; ++k) {
    for (const double side : {-1.0, 1.0}) {
      const double image_hz = k / output.sampling_s + side * tone_hz;
      const double folded_hz = std::abs(std::remainder(image_hz, output.daq_rate_hz));
      const bool is_folded = 2 * image_hz > output.daq_rate_hz;
      const double relative = tone_hz / image_hz;
      if (!is_folded || relative < least || folded_hz < lower_hz || folded_hz > upper_hz) continue;
      images.push_back({image_hz, folded_hz, relative});
    }
  }
  std::ranges::sort(images, std::ranges::greater(), &FoldedImage::relative);
  return images;
}

double UnfoldedRateHz(HeldOutput output, double lower_hz, double upper_hz, double least,
                      double least_rate_hz) {
  constexpr std::array<double, 3> kDigits{1, 2, 5};
  double decade = std::pow(10, std::floor(std::log10(least_rate_hz)));
  // ends at twice the highest image
  while (true) {
    for (const double digit : kDigits) {
      output.daq_rate_hz = digit * decade;
      if (output.daq_rate_hz < least_rate_hz) continue;
      if (ImagesInBand(output, lower_hz, upper_hz, least).empty()) return output.daq_rate_hz;
    }
    decade *= 10;
  }
}

}  // namespace haptometer::acquire
