#include "dsp/analysis/sweep_analysis.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "base/band.h"
#include "dsp/analysis/band_question.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/readings/clean_rows.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {

namespace {

// what is measured: a piece of the record without holes
struct SweepPiece {
  double start_s = 0;
  double rate_hz = 0;
  std::vector<double> displacement_m;
  std::vector<double> drive;      // as many samples in the channel's unit, or none
  std::size_t drive_channel = 0;  // its number, where `drive` is there
};

// limit of memory: some ten copies of the piece are made
constexpr std::size_t kMostSamples = std::size_t{1} << 24U;

// [first, last) of the longest run of measured values
std::pair<std::size_t, std::size_t> LongestRun(std::span<const double> values,
                                               std::span<const trial::SampleStatus> statuses) {
  std::pair<std::size_t, std::size_t> longest{0, 0};
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= values.size(); ++k) {
    if (k < values.size() && IsMeasured(values[k], statuses[k])) continue;
    if (k - begin > longest.second - longest.first) longest = {begin, k};
    begin = k + 1;
  }
  return longest;
}

void Crop(std::vector<double>& values, std::size_t first, std::size_t last) {
  values = {values.begin() + static_cast<std::ptrdiff_t>(first),
            values.begin() + static_cast<std::ptrdiff_t>(last)};
}

// adds the drive beside the displacement, both cut to where the drive is measured
Result<void> AddDrive(const trial::RowSource& source, std::size_t channel, std::size_t first_row,
                      SweepPiece& piece, Findings& findings) {
  std::vector<double> values(piece.displacement_m.size());
  std::vector<trial::SampleStatus> statuses(values.size());
  HAPTOMETER_TRY(source.Read(channel, first_row, values, statuses));
  const auto [first, last] = LongestRun(values, statuses);
  const trial::Channel& drive = source.head().channels[channel];
  // a constant channel is no excitation: the sweep is then analysed without it
  const auto moves = [&] {
    const auto run = std::span(values).subspan(first, last - first);
    return !run.empty() && std::ranges::min(run) < std::ranges::max(run);
  };
  if (!moves()) {
    findings.Note(FindingKind::kDriveConstant, {{"channel", drive.name}});
    return {};
  }
  if (last - first < values.size()) {
    findings.Note(FindingKind::kDriveGaps, {{"channel", drive.name}});
  }
  Crop(values, first, last);
  Crop(piece.displacement_m, first, last);
  piece.start_s += static_cast<double>(first) / piece.rate_hz;
  piece.drive = std::move(values);
  piece.drive_channel = channel;
  return {};
}

// The longest of `segments`, kMostSamples at most, and beside it the drive; where that has holes,
// both are cut to its longest measured run. Empty where there is no segment.
Result<SweepPiece> ReadSweepPiece(const trial::RowSource& source, std::size_t channel,
                                  const Segments& segments, Findings& findings) {
  // longest in time, since rates may differ
  const auto longest = std::ranges::max_element(
      segments.parts, {}, [](const Segment& s) { return static_cast<double>(s.size) / s.rate_hz; });
  if (longest == segments.parts.end()) return SweepPiece{};
  if (segments.parts.size() > 1) {
    findings.Note(FindingKind::kLongestSegment, {{"segments", segments.parts.size()}});
  }
  if (longest->size > kMostSamples) {
    findings.Note(FindingKind::kSamplesLimited,
                  {{"samples", longest->size}, {"used", kMostSamples}});
  }
  SweepPiece piece;
  piece.start_s = longest->start_s;
  piece.rate_hz = longest->rate_hz;
  piece.displacement_m.resize(std::min(longest->size, kMostSamples));
  const SegmentSamples samples(source, channel, *longest);
  HAPTOMETER_TRY(samples.Read(0, piece.displacement_m));
  // a trigger has no amplitude to divide by
  const auto drive = DriveChannel(source.head());
  if (drive && source.head().channels[*drive].role != trial::ChannelRole::kTrigger) {
    HAPTOMETER_TRY(AddDrive(source, *drive, longest->first_row, piece, findings));
  }
  return piece;
}

constexpr double kLongestSegmentS = 4;
constexpr double kSegmentsInRecord = 4;  // end to end
// Of a complex mode z' = -p z + 1, p = g + j d, whose distance d from resonance moves by r rad/s^2:
// z = (1 + j r / p^2 - 3 r^2 / p^4 - 15 j r^3 / p^6 + ...) / p, by z_n+1 = -z_n' / p. At resonance
// r / p^2 is k = r / g^2 = 2 rate Q^2 / (pi f0^2). The third term is 5 k times the second: beyond
// 1/5 no number of terms is enough.
constexpr double kFastest = 0.2;

Result<void> CheckQuestion(const SweepQuestion& question) {
  if (!(question.lower_hz > 0 && question.upper_hz > question.lower_hz)) {
    return Usage("band",
                 fmt::format("{:g} Hz to {:g} Hz is none", question.lower_hz, question.upper_hz),
                 "give its lower, then its upper frequency");
  }
  if (question.resolution_hz && !(*question.resolution_hz > 0)) {
    return Usage("resolution", "is not above 0", "give some hertz");
  }
  return {};
}

// rate, window, drive and unit of the answer
void TakePiece(const trial::Record& head, const SweepPiece& piece, SweepAnswer& answer) {
  answer.rate_hz = piece.rate_hz;
  answer.window = {piece.start_s, piece.start_s + static_cast<double>(piece.displacement_m.size()) /
                                                      piece.rate_hz};
  if (piece.drive.empty()) return;
  const trial::Channel& drive = head.channels[piece.drive_channel];
  answer.drive = drive.name;
  answer.amplitude_unit = drive.unit.empty() ? "m per unit of the drive" : "m/" + drive.unit;
}

// rate without repeated readings
double FreshRate(const Segments& segments, double rate_hz) {
  const auto count = [&](trial::SampleStatus status) {
    return static_cast<double>(segments.by_status[static_cast<std::size_t>(status)]);
  };
  const double fresh = count(trial::SampleStatus::kOk);
  return rate_hz * fresh / std::max(1.0, fresh + count(trial::SampleStatus::kRepeated));
}

// 1 where the sensor's gain is not known
double GainOr1(const SensorAveraging& sensor, double frequency_hz) {
  return GainAt(sensor, frequency_hz).value_or(1);
}

// highest frequency with enough readings per period and a sensor's gain of a half or more
double UpperOf(const SweepQuestion& question, double fresh_rate_hz, SweepAnswer& answer) {
  // a doubt where frequencies remain, else a refusal
  // of nothing that is left there is no answer
  const auto limit = [&](FindingKind kind, double to_hz, std::vector<FindingNumber> numbers) {
    answer.findings.Add(
        {.severity = to_hz > question.lower_hz ? Severity::kDoubt : Severity::kRefusal,
         .kind = kind,
         .numbers = std::move(numbers)});
  };
  double upper_hz = question.upper_hz;
  if (!Observes(fresh_rate_hz, upper_hz)) {
    upper_hz = HighestObservableHz(fresh_rate_hz);
    limit(FindingKind::kSweepRateLimit, upper_hz,
          {{"upper_hz", upper_hz},
           {"new_readings_per_s", fresh_rate_hz},
           {"needed_per_s", NeededRateHz(question.upper_hz)}});
  }
  if (GainOr1(answer.sensor, upper_hz) >= kLeastSensorGain) return upper_hz;
  // the gain falls from 1 at 0 Hz; bisection to where it is a half
  double passed_hz = 0;
  for (int step = 0; step < 60; ++step) {
    const double middle_hz = (passed_hz + upper_hz) / 2;
    (GainOr1(answer.sensor, middle_hz) >= kLeastSensorGain ? passed_hz : upper_hz) = middle_hz;
  }
  limit(FindingKind::kSweepSensorLimit, passed_hz, {{"upper_hz", passed_hz}});
  return passed_hz;
}

struct Band {
  double lower_hz = 0;
  double upper_hz = 0;
};

// samples of a segment: the required resolution, or a fourth of the record, 4 s at most
std::size_t SegmentSize(const SweepPiece& piece, const SweepQuestion& question) {
  const auto size = static_cast<double>(piece.drive.size());
  const double samples = question.resolution_hz
                             ? piece.rate_hz / *question.resolution_hz
                             : std::min(kLongestSegmentS * piece.rate_hz, size / kSegmentsInRecord);
  // even, so that half of it is a whole number
  return 2 * static_cast<std::size_t>(std::min(samples, 2 * size) / 2);
}

struct Response {
  std::size_t asked = 0;  // frequencies, before any was excluded
  std::vector<ResponsePoint> points;
  Resonance resonance;
};

// response by H1, the sensor's gain divided out, and the resonance through it
Result<Response> RespondBy(const SweepPiece& piece, std::size_t segment_size, const Band& band,
                           const SensorAveraging& sensor) {
  const WelchOptions options{piece.rate_hz, segment_size};
  HAPTOMETER_LET(auto points, MeasureResponse(piece.drive, piece.displacement_m, options,
                                              band.lower_hz, band.upper_hz));
  for (ResponsePoint& point : points) point.response /= GainOr1(sensor, point.frequency_hz);
  // segments that overlap by half
  const std::size_t whole = piece.drive.size() / segment_size;
  const auto segments = static_cast<double>(2 * whole - 1);
  Response response;
  response.asked = points.size();
  KeepSignificant(points, segments);
  response.resonance =
      FitResonance(IndependentPoints(points, piece.rate_hz / static_cast<double>(segment_size)));
  response.points = std::move(points);
  return response;
}

// the interval of a value: Student's t of its uncertainty, and `change` beside it
Interval IntervalOf(double value, double uncertainty, double freedom, double change) {
  const double reach = StudentCritical(freedom) * uncertainty + change;
  return {value - reach, value + reach};
}

// that no resonance is determined, and where the largest amplitude is
Finding NoResonance(const SweepAnswer& answer) {
  const auto& points = answer.points;
  const auto highest = std::ranges::max_element(points, {}, &SweepPoint::amplitude);
  // the largest amplitude within two bins of an end: the resonance lies beyond it
  const auto near = [&](const SweepPoint& end) {
    return std::abs(highest->frequency_hz - end.frequency_hz) <= 2 * answer.resolution_hz;
  };
  Finding found{.severity = Severity::kDoubt,
                .kind = FindingKind::kNoResonance,
                .numbers = {{"from_hz", points.front().frequency_hz},
                            {"to_hz", points.back().frequency_hz},
                            {"highest_hz", highest->frequency_hz}}};
  if (near(points.back()) || near(points.front())) {
    found.kind = near(points.back()) ? FindingKind::kResonanceAbove : FindingKind::kResonanceBelow;
    return found;
  }
  // a peak of three points or fewer above half power is narrower than the resolution
  const auto high = std::ranges::count_if(points, [&](const SweepPoint& point) {
    return point.amplitude > highest->amplitude / std::numbers::sqrt2;
  });
  if (high <= 3) {
    found.kind = FindingKind::kPeakTooNarrow;
    found.numbers.emplace_back("resolution_hz", answer.resolution_hz);
  }
  return found;
}

// keeps the resonance, or the reason for none; `rate_hz_per_s` is that of a sweep without a drive
// channel
void TakeResonance(const Resonance& fit, const Resonance& other, double rate_hz_per_s,
                   SweepAnswer& answer) {
  if (answer.points.empty()) return;
  if (!fit.converged || !other.converged) return answer.findings.Add(NoResonance(answer));
  const double width_hz = fit.frequency_hz / fit.quality_factor;
  const double fast = 2 * rate_hz_per_s / (std::numbers::pi * width_hz * width_hz);
  if (fast > kFastest) {
    return answer.findings.Doubt(FindingKind::kSweepTooFast,
                                 {{"rate_hz_per_s", rate_hz_per_s},
                                  {"most_hz_per_s", rate_hz_per_s * kFastest / fast},
                                  {"frequency_hz", fit.frequency_hz}});
  }
  SweepResonance found{fit, {}, {}};
  // a sweep shows the resonance late, and wider by a part k^2
  const double late_hz = rate_hz_per_s / (std::numbers::pi * width_hz);
  // the change by segments of another length bounds the error of the window's width
  found.frequency_hz =
      IntervalOf(fit.frequency_hz, fit.frequency_uncertainty_hz, fit.degrees_of_freedom,
                 std::abs(fit.frequency_hz - other.frequency_hz) + late_hz);
  found.quality_factor = IntervalOf(
      fit.quality_factor, fit.quality_factor_uncertainty, fit.degrees_of_freedom,
      std::abs(fit.quality_factor - other.quality_factor) + fast * fast * fit.quality_factor);
  found.quality_factor.lower = std::max(0.0, found.quality_factor.lower);
  if (fit.residual_share > 1 - kExplained) {
    answer.findings.Doubt(FindingKind::kSeveralResonances, {{"left", fit.residual_share}});
  }
  answer.resonance = found;
}

Result<void> AnswerByDrive(const SweepPiece& piece, const SweepQuestion& question, const Band& band,
                           SweepAnswer& answer) {
  const std::size_t size = SegmentSize(piece, question);
  // at least two segments that overlap by half are required
  if (size < 8 || 3 * size > 2 * piece.drive.size()) {
    answer.findings.Refuse(FindingKind::kSweepTooShort,
                           {{"length_s", answer.window.duration_s()},
                            {"resolution_hz", 2 / answer.window.duration_s()}});
    return {};
  }
  answer.resolution_hz = piece.rate_hz / static_cast<double>(size);
  HAPTOMETER_LET(const auto response, RespondBy(piece, size, band, answer.sensor));
  HAPTOMETER_LET(const auto halved, RespondBy(piece, size / 2, band, answer.sensor));
  answer.points.reserve(response.points.size());
  for (const ResponsePoint& point : response.points) {
    answer.points.push_back(
        {point.frequency_hz, std::abs(point.response), std::arg(point.response), point.coherence});
  }
  if (const std::size_t left_out = response.asked - response.points.size(); left_out > 0) {
    answer.findings.Note(FindingKind::kFrequenciesExcluded,
                         {{"excluded", left_out}, {"frequencies", response.asked}});
  }
  if (answer.points.empty()) {
    answer.findings.Refuse(FindingKind::kNoResponse);
  }
  TakeResonance(response.resonance, halved.resonance, 0, answer);
  return {};
}

bool Sweeps(const std::vector<SweptPoint>& points) {
  if (points.size() < kFewest) return false;
  const auto [lowest, highest] = std::ranges::minmax_element(points, {}, &SweptPoint::frequency_hz);
  return highest->frequency_hz > (1 + kSweep) * lowest->frequency_hz;
}

// without a drive channel: amplitude over frequency of the band-passed displacement
Result<void> AnswerAlone(const SweepPiece& piece, const SweepQuestion& question, const Band& band,
                         SweepAnswer& answer) {
  answer.findings.Doubt(FindingKind::kNoDriveChannel);
  HAPTOMETER_LET(
      const auto design,
      DesignBandPass({.lower_hz = band.lower_hz, .upper_hz = band.upper_hz}, piece.rate_hz));
  const std::vector<double> filtered = FilterZeroPhase(design, piece.displacement_m);
  const auto measure = [&](double periods) {
    auto points =
        LongestSweep(SweptAmplitude(filtered, piece.rate_hz, band.lower_hz, band.upper_hz, periods),
                     periods / band.lower_hz);
    for (SweptPoint& point : points) {
      // two passes of the filter, gain |H|^2, and the sensor's gain
      const double gain = Magnitude(design, point.frequency_hz);
      point.amplitude /= gain * gain * GainOr1(answer.sensor, point.frequency_hz);
    }
    return points;
  };
  const double resolution_hz = question.resolution_hz.value_or(band.lower_hz / kLeastWindowPeriods);
  const double periods = band.lower_hz / resolution_hz;
  std::vector<SweptPoint> points = measure(periods);
  if (!Sweeps(points)) {
    answer.findings.Refuse(FindingKind::kNoSweep, {{"lower_hz", band.lower_hz},
                                                   {"upper_hz", band.upper_hz},
                                                   {"resolution_hz", resolution_hz},
                                                   {"block_s", 1 / resolution_hz}});
    return {};
  }
  answer.resolution_hz = resolution_hz;
  answer.findings.Note(FindingKind::kConstantDriveAssumed);
  const Resonance fit = FitResonance(std::span<const SweptPoint>(points));
  // blocks twice as long give the change by the method
  const Resonance longer = FitResonance(std::span<const SweptPoint>(measure(2 * periods)));
  const double rate_hz_per_s = SweepRate(points);
  std::ranges::sort(points, {}, &SweptPoint::frequency_hz);
  answer.points.reserve(points.size());
  for (const SweptPoint& point : points) {
    answer.points.push_back({point.frequency_hz, point.amplitude, {}, {}});
  }
  TakeResonance(fit, longer, rate_hz_per_s, answer);
  return {};
}

// the upper frequency first: it depends on new readings and on the sensor's averaging
Result<void> Answer(const trial::RowSource& source, const SweepPiece& piece,
                    const Segments& segments, const SweepQuestion& question, SweepAnswer& answer) {
  const double fresh_rate_hz = FreshRate(segments, piece.rate_hz);
  answer.sensor = AveragingOf(source.head().metadata, piece.rate_hz, fresh_rate_hz);
  answer.amplitude_verified = answer.sensor.knowledge != SensorKnowledge::kUnknown;
  if (!answer.amplitude_verified) {
    answer.findings.Doubt(FindingKind::kAveragingUnknown);
  }
  const Band band{question.lower_hz, UpperOf(question, fresh_rate_hz, answer)};
  if (!(band.upper_hz > band.lower_hz)) return {};
  return piece.drive.empty() ? AnswerAlone(piece, question, band, answer)
                             : AnswerByDrive(piece, question, band, answer);
}

}  // namespace

Result<SweepAnswer> AnalyzeSweep(const trial::RowSource& source, const SweepQuestion& question) {
  HAPTOMETER_TRY(CheckQuestion(question));
  HAPTOMETER_LET(const auto channel, AnalyzedChannel(source.head()));
  SweepAnswer answer;
  // a sweep requires a clocked record: uniform times, not polled
  if (source.head().times_are_known || source.head().timing == trial::Timing::kPolled) {
    answer.findings.Refuse(source.head().times_are_known ? FindingKind::kSweepUneven
                                                         : FindingKind::kSweepPolled);
    return answer;
  }
  HAPTOMETER_LET(const auto clean, Clean(source, channel));
  HAPTOMETER_LET(const auto piece,
                 ReadSweepPiece(*clean.rows, channel, clean.segments, answer.findings));
  if (piece.displacement_m.empty()) {
    answer.findings.Refuse(FindingKind::kNoMeasurement);
    return answer;
  }
  TakePiece(source.head(), piece, answer);
  HAPTOMETER_TRY(Answer(*clean.rows, piece, clean.segments, question, answer));
  answer.answered = !answer.points.empty();
  return answer;
}

}  // namespace haptometer::dsp
