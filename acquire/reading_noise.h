#pragma once

#include <vector>

namespace haptometer::acquire {

/// Readings whose noise is not white where they overlap: each is a mean over `span_s`, and they
/// follow each other every 1 / rate_hz.
struct ReadingNoise {
  double rate_hz = 0;      ///< of the readings, > 0
  double noise_rms_m = 0;  ///< of one reading
  double span_s = 0;       ///< averages x sampling period of white raw samples; 0: nothing overlaps
};

/// The one-sided density of the noise at `frequency_hz` (0 to rate / 2), in m2/Hz, what folds
/// included:
///
///   S(f) = 2 s^2 / rate (1 + 2 sum over j of (1 - j / (rate span)) cos(2 pi f j / rate)),
///   j < rate span,
///
/// the transform of the autocorrelation of a moving mean, s^2 (1 - lag / span) (Bendat and Piersol,
/// Random Data, 4th ed., 5.2.1). Of a staircase that a converter samples it is the same, linear
/// between its steps. Readings that do not overlap: 2 s^2 / rate. Cost: rate x span cosines.
[[nodiscard]] double NoiseDensity(const ReadingNoise& noise, double frequency_hz);

/// A tone's image in an output that is renewed every `sampling_s`, as a converter takes it.
struct FoldedImage {
  double image_hz = 0;   ///< k / sampling_s - f or + f
  double folded_hz = 0;  ///< where it is found after sampling
  double relative = 0;   ///< its amplitude, relative to the tone's
};

/// An output held between its renewals, as a converter samples it without a filter before it.
struct HeldOutput {
  double sampling_s = 0;    ///< > 0: renewed so often
  double frequency_hz = 0;  ///< of the tone, > 0 and below half the rate of renewal
  double daq_rate_hz = 0;   ///< > 0
};

/// The images that a converter folds into `lower_hz` to `upper_hz` and that have `least` (> 0) of
/// the tone's amplitude, the largest first.
///
/// A staircase of steps of length T holds the tone f at k / T - f and k / T + f too. The hold
/// weights each by sinc(frequency T), so relative to the tone an image has f / (k / T -+ f). A
/// converter folds it to its distance from the next multiple of its rate.
[[nodiscard]] std::vector<FoldedImage> ImagesInBand(const HeldOutput& output, double lower_hz,
                                                    double upper_hz, double least);

/// The lowest rate of a converter in 1, 2, 5, 10, ... Hz, at least `least_rate_hz`, at which
/// ImagesInBand() are none; `output.daq_rate_hz` is ignored.
[[nodiscard]] double UnfoldedRateHz(HeldOutput output, double lower_hz, double upper_hz,
                                    double least, double least_rate_hz);

}  // namespace haptometer::acquire
