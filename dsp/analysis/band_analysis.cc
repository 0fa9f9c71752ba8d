#include "dsp/analysis/band_analysis.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "base/check.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/raw_summary.h"
#include "dsp/analysis/segments.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/tone.h"
#include "trial/sensor_head.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kUmPerM = 1e6;
// a sample's time must be known to this part of a period
constexpr double kTimeUncertaintyPeriods = 0.1;
// the shortest window, in periods of the lower corner
constexpr double kLeastWindowPeriods = 2;
constexpr int kLowestFallbackOrder = 2;
// leaked power that changes an RMS by 1 %
constexpr double kLeakedPowerLimit = 0.02;

double SettledSeconds(const BandSignal& signal) {
  return static_cast<double>(signal.settled_end() - signal.settled_begin()) / signal.rate_hz();
}

Result<std::vector<double>> ReadSettled(const BandSignal& signal) {
  std::vector<double> samples(signal.settled_end() - signal.settled_begin());
  if (auto read = signal.Read(signal.settled_begin(), samples); !read) {
    return std::unexpected(read.error());
  }
  return samples;
}

Result<std::size_t> DisplacementOf(const trial::Record& head) {
  const trial::Channel* channel = head.Find(trial::ChannelRole::kDisplacement);
  if (channel == nullptr) {
    return CannotAnswer("", "holds no displacement channel", "name one displacement_m");
  }
  if (channel->unit != "m") {
    return CannotAnswer("", fmt::format("its displacement has the unit '{}'", channel->unit),
                        "convert it to metres");
  }
  return static_cast<std::size_t>(channel - head.channels.data());
}

// "late 100, over 20": every status that is no measurement, and values that are no numbers
std::string Unmeasured(const BandAnalysis& analysis) {
  std::string text;
  std::size_t named = 0;
  for (std::size_t s = 0; s < analysis.by_status.size(); ++s) {
    const auto status = static_cast<SampleStatus>(s);
    if (trial::IsMeasurement(status) || analysis.by_status[s] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", trial::Name(status),
                        analysis.by_status[s]);
    named += analysis.by_status[s];
  }
  const std::size_t rest = analysis.rows - analysis.measured - named;
  if (rest > 0) text += fmt::format("{}not a number {}", text.empty() ? "" : ", ", rest);
  return text;
}

// offset, peak to peak, rates and counts: what every record tells
void DescribeRecord(const trial::Record& record, const Segments& segments,
                    const RawSummary& summary, BandAnalysis& analysis) {
  analysis.rows = record.rows;
  analysis.measured = segments.measured;
  analysis.bridged = segments.bridged;
  analysis.segments = segments.parts.size();
  analysis.by_status = segments.by_status;
  if (summary.measured == 0) return;
  analysis.offset_m = summary.mean;
  analysis.peak_to_peak_m = summary.most - summary.least;

  const auto longest = std::ranges::max_element(record.stretches, {}, &trial::Stretch::rows);
  analysis.rate_hz = longest->rate_hz;
  for (const trial::Stretch& stretch : record.stretches) {
    analysis.duration_s += static_cast<double>(stretch.rows) / stretch.rate_hz;
  }
  const auto repeated = segments.by_status[static_cast<std::size_t>(SampleStatus::kRepeated)];
  analysis.fresh_rate_hz = analysis.rate_hz * (1 - static_cast<double>(repeated) /
                                                       static_cast<double>(segments.measured));
  analysis.observable_upper_hz = analysis.fresh_rate_hz / kLeastRatePerUpperCorner;

  if (analysis.measured < analysis.rows) {
    analysis.remarks.push_back(fmt::format("left out: {} of {} readings ({})",
                                           analysis.rows - analysis.measured, analysis.rows,
                                           Unmeasured(analysis)));
  }
  if (repeated > 0) {
    analysis.remarks.push_back(fmt::format("{} of {} readings were handed out a second time",
                                           repeated, analysis.measured));
  }
}

// what speaks against the band before any filtering
void CheckObservable(const trial::Record& record, const Segments& segments, const BandPass& band,
                     BandAnalysis& analysis) {
  const double needed_hz = kLeastRatePerUpperCorner * band.upper_hz;
  if (analysis.fresh_rate_hz < needed_hz) {
    analysis.reasons.push_back(fmt::format(
        "{:.4g} new readings/s show vibration up to {:.4g} Hz; {:g}-{:g} Hz needs {:g}/s: "
        "use a free-running output, or the analog output and a DAQ",
        analysis.fresh_rate_hz, analysis.observable_upper_hz, band.lower_hz, band.upper_hz,
        needed_hz));
  }
  // a reading that was asked for is of unknown age; a free-running source has a clock of its own,
  // however its arrivals scatter
  if (record.timing != trial::Timing::kPolled) return;
  const double limit_s = kTimeUncertaintyPeriods / band.upper_hz;
  for (const Segment& segment : segments.parts) {
    if (segment.time_uncertainty_s < limit_s) continue;
    analysis.reasons.push_back(
        fmt::format("each reading's time is uncertain by {:.3g} ms; motion at {:g} Hz needs less "
                    "than {:.3g} ms: "
                    "use a sensor that samples on a clock of its own",
                    segment.time_uncertainty_s * 1e3, band.upper_hz, limit_s * 1e3));
    break;
  }
}

// a record's displacement, and how many threads may filter it
struct Displacement {
  const trial::RowSource& source;
  std::size_t channel = 0;
  int threads = 1;
};

// every segment that is fast enough, filtered on its own
Result<std::vector<BandSignal>> FilterAll(const Displacement& displacement,
                                          const Segments& segments, const BandPass& band) {
  std::vector<BandSignal> all;
  for (const Segment& segment : segments.parts) {
    if (segment.rate_hz < kLeastRatePerUpperCorner * band.upper_hz) continue;
    Result<FilterDesign> design = DesignBandPass(band, segment.rate_hz);
    HAPTOMETER_CHECK(design, "{}", design.error().Text());
    auto signal = BandSignal::Filter({displacement.source, displacement.channel, segment}, *design,
                                     displacement.threads);
    if (!signal) return std::unexpected(signal.error());
    all.push_back(std::move(*signal));
  }
  return all;
}

// `all` is not empty
const BandSignal& LongestSettled(const std::vector<BandSignal>& all) {
  return *std::ranges::max_element(all, {}, SettledSeconds);
}

// the strongest tone below the band, and what two passes leave of it
Result<std::optional<BelowBand>> FindBelowBand(const BandSignal& signal, double lower_hz) {
  const double duration_s = static_cast<double>(signal.size()) / signal.rate_hz();
  const double least_hz = 2 / duration_s;
  if (least_hz >= lower_hz) return std::nullopt;
  std::vector<double> samples(signal.size());
  if (auto read = signal.samples().Read(0, samples); !read) return std::unexpected(read.error());
  const auto tone = StrongestTone(samples, {signal.rate_hz(), least_hz, lower_hz, 0});
  if (!tone) return std::nullopt;
  const double gain = std::norm(Response(signal.design(), tone->frequency_hz));
  return BelowBand{tone->frequency_hz, tone->amplitude,
                   tone->amplitude * gain / std::numbers::sqrt2};
}

// whether what leaks from below the band is small enough to answer all the same
Result<bool> LeaksLittle(const BandSignal& signal, double lower_hz) {
  const auto below = FindBelowBand(signal, lower_hz);
  if (!below) return std::unexpected(below.error());
  if (!*below) return true;
  const auto square_sum = signal.SquareSum(signal.settled_begin(), signal.settled_end());
  if (!square_sum) return std::unexpected(square_sum.error());
  const double leaked_rms_m = (*below)->leaked_rms_m;
  const auto count = static_cast<double>(signal.settled_end() - signal.settled_begin());
  return leaked_rms_m * leaked_rms_m <= kLeakedPowerLimit * *square_sum / count;
}

// why nothing is answered after filtering, and what would help
std::string TooShort(const BandPass& band, double rate_hz, double settled_s, bool leaks) {
  const auto design = DesignBandPass(band, rate_hz);
  HAPTOMETER_CHECK(design, "{}", design.error().Text());
  const double ringing_s = static_cast<double>(RingingSamples(*design, 1e-12)) / rate_hz;
  const double least_s = kLeastWindowPeriods / band.lower_hz;
  std::string text =
      fmt::format("only {:.3f} s of it have settled in a filter of order {}; {:.3g} s are needed",
                  settled_s, band.order, least_s);
  if (leaks) {
    text += fmt::format(", and a lower order lets too much of the motion below {:g} Hz through",
                        band.lower_hz);
  }
  return text + fmt::format(": record at least {:.1f} s without a gap", 2 * ringing_s + least_s);
}

// Filters with the asked order, or with the highest lower one that leaves enough settled. Says in
// `analysis` which, or why none does; then nothing is returned.
Result<std::vector<BandSignal>> FilterSettledEnough(const Displacement& displacement,
                                                    const Segments& segments,
                                                    const BandQuestion& question,
                                                    BandAnalysis& analysis) {
  const int asked = question.band.order;
  const int lowest = question.may_lower_order ? std::min(kLowestFallbackOrder, asked) : asked;
  double asked_settled_s = 0;
  bool leaks = false;
  for (int order = asked; order >= lowest && !leaks; --order) {
    analysis.band.order = order;
    auto all = FilterAll(displacement, segments, analysis.band);
    if (!all || all->empty()) {
      if (!all) return all;
      break;
    }
    const BandSignal& longest = LongestSettled(*all);
    if (order == asked) asked_settled_s = SettledSeconds(longest);
    if (SettledSeconds(longest) < kLeastWindowPeriods / question.band.lower_hz) continue;
    if (order == asked) return all;
    const auto leaks_little = LeaksLittle(longest, question.band.lower_hz);
    if (!leaks_little) return std::unexpected(leaks_little.error());
    leaks = !*leaks_little;
    if (leaks) continue;
    analysis.remarks.push_back(
        fmt::format("filter order lowered from {} to {}: of order {} only "
                    "{:.3f} s had settled",
                    asked, order, asked, asked_settled_s));
    return all;
  }
  analysis.band = question.band;
  analysis.reasons.push_back(TooShort(question.band, analysis.rate_hz, asked_settled_s, leaks));
  return std::vector<BandSignal>{};
}

// RMS of everything that was filtered, unsettled ends included
double WholeRms(const std::vector<BandSignal>& all) {
  double square_sum = 0;
  double count = 0;
  for (const BandSignal& signal : all) {
    for (const BandCell& cell : signal.cells()) square_sum += cell.square_sum;
    count += static_cast<double>(signal.size());
  }
  return std::sqrt(square_sum / count);
}

// samples of `signal`'s settled part that hold whole periods of the tone
std::size_t WholePeriods(const BandSignal& signal, const std::optional<SineFit>& tone) {
  const std::size_t settled = signal.settled_end() - signal.settled_begin();
  if (!tone) return settled;
  const double periods = std::floor(SettledSeconds(signal) * tone->frequency_hz);
  if (periods < 1) return settled;
  const double rows = std::round(periods / tone->frequency_hz * signal.rate_hz());
  return std::min(settled, static_cast<std::size_t>(rows));
}

// u of the RMS of a tone in band-limited noise, see AnalyzeBand
double RmsUncertainty(double rms, double amplitude, double noise_rms, double bandwidth_hz,
                      double duration_s) {
  const double noise_square = noise_rms * noise_rms;
  const double power_variance =
      (amplitude * amplitude * noise_square + noise_square * noise_square) /
      (bandwidth_hz * duration_s);
  return rms > 0 ? std::sqrt(power_variance) / (2 * rms) : 0;
}

// the tone as it was before the filter
void DescribeTone(const trial::Metadata& metadata, const BandSignal& longest, const SineFit& tone,
                  BandAnalysis& analysis) {
  analysis.tone = tone;
  const double gain = std::norm(Response(longest.design(), tone.frequency_hz));
  analysis.tone->amplitude /= gain;
  analysis.tone->amplitude_uncertainty /= gain;
  // the rate is a line through times: each of its ends may be off by their uncertainty
  const double segment_s = static_cast<double>(longest.size()) / longest.rate_hz();
  const double rate_share = std::numbers::sqrt2 * longest.segment().time_uncertainty_s / segment_s;
  analysis.tone->frequency_uncertainty_hz =
      std::hypot(analysis.tone->frequency_uncertainty_hz, tone.frequency_hz * rate_share);
  if (metadata.sampling_s && metadata.averages) {
    analysis.sensor_gain_at_tone =
        trial::AveragingGain(tone.frequency_hz, *metadata.sampling_s, *metadata.averages);
  }
}

// window, RMS and tone from the longest settled piece
Result<void> DescribeBand(const trial::Metadata& metadata, const std::vector<BandSignal>& all,
                          BandAnalysis& analysis) {
  const BandSignal& longest = LongestSettled(all);
  const double bandwidth_hz = analysis.band.upper_hz - analysis.band.lower_hz;
  const auto settled = ReadSettled(longest);
  if (!settled) return std::unexpected(settled.error());
  const auto tone = StrongestTone(
      *settled, {longest.rate_hz(), analysis.band.lower_hz, analysis.band.upper_hz, bandwidth_hz});

  // the window in rows and in seconds
  const std::size_t begin = longest.settled_begin();
  analysis.window_first_row = longest.first_row() + begin;
  analysis.window_rows = WholePeriods(longest, tone);
  const double begin_s = longest.start_s() + static_cast<double>(begin) / longest.rate_hz();
  const auto window_rows = static_cast<double>(analysis.window_rows);
  const double window_s = window_rows / longest.rate_hz();
  analysis.window = TimeWindow{begin_s, begin_s + window_s};

  // what it holds
  const auto square_sum = longest.SquareSum(begin, begin + analysis.window_rows);
  if (!square_sum) return std::unexpected(square_sum.error());
  const double rms = std::sqrt(*square_sum / window_rows);
  analysis.band_rms_m = rms;
  analysis.band_rms_whole_m = WholeRms(all);
  const auto extremes = longest.ExtremesOf(begin, begin + analysis.window_rows);
  if (!extremes) return std::unexpected(extremes.error());
  analysis.band_peak_to_peak_m = extremes->most - extremes->least;
  analysis.residual_rms_m = tone ? tone->residual_rms : rms;
  analysis.band_rms_uncertainty_m = RmsUncertainty(
      rms, tone ? tone->amplitude : 0, *analysis.residual_rms_m, bandwidth_hz, window_s);
  analysis.bridged_rms_m = std::sqrt(longest.segment().bridged_error_square_sum / window_rows);
  const auto below_band = FindBelowBand(longest, analysis.band.lower_hz);
  if (!below_band) return std::unexpected(below_band.error());
  analysis.below_band = *below_band;
  if (tone) DescribeTone(metadata, longest, *tone, analysis);
  return {};
}

// what the reader of the numbers must know of how they came about
void AddRemarks(const std::vector<BandSignal>& all, BandAnalysis& analysis) {
  const BandSignal& longest = LongestSettled(all);
  const double rate_hz = longest.rate_hz();
  if (all.size() > 1) {
    analysis.remarks.push_back(fmt::format(
        "gaps split the record into {} pieces; the window is in the one that settles longest",
        all.size()));
  }
  const std::size_t after = longest.size() - longest.settled_end();
  analysis.remarks.push_back(fmt::format(
      "ends not settled: {:.3f} s and {:.3f} s of a piece of {:.3f} s",
      static_cast<double>(longest.settled_begin()) / rate_hz, static_cast<double>(after) / rate_hz,
      static_cast<double>(longest.size()) / rate_hz));
  if (analysis.bridged > 0) {
    analysis.remarks.push_back(fmt::format("{} readings bridged; this adds about {:.2g} um at most",
                                           analysis.bridged, *analysis.bridged_rms_m * kUmPerM));
  }
  if (analysis.below_band) {
    analysis.remarks.push_back(
        fmt::format("{:.4g} um at {:.3g} Hz lie below the band; {:.2g} um RMS of that leak into it",
                    analysis.below_band->amplitude_m * kUmPerM, analysis.below_band->frequency_hz,
                    analysis.below_band->leaked_rms_m * kUmPerM));
  }
  if (analysis.sensor_gain_at_tone && *analysis.sensor_gain_at_tone < 1) {
    analysis.remarks.push_back(
        fmt::format("the sensor's averaging passes {:.4g} of the tone; it is not divided out",
                    *analysis.sensor_gain_at_tone));
  }
}

// the filtered signal beside the record's rows
Result<void> KeepFiltered(const std::vector<BandSignal>& all, BandAnalysis& analysis) {
  analysis.filtered_m.assign(analysis.rows, std::numeric_limits<double>::quiet_NaN());
  for (const BandSignal& signal : all) {
    const std::span rows = std::span(analysis.filtered_m).subspan(signal.first_row());
    if (auto read = signal.Read(0, rows.first(signal.size())); !read) return read;
  }
  return {};
}

// filters, and describes the band where enough settles
Result<void> AnswerBand(const Displacement& displacement, const Segments& segments,
                        const BandQuestion& question, BandAnalysis& analysis) {
  const auto all = FilterSettledEnough(displacement, segments, question, analysis);
  if (!all) return std::unexpected(all.error());
  if (all->empty()) return {};
  if (auto done = DescribeBand(displacement.source.head().metadata, *all, analysis); !done) {
    return done;
  }
  AddRemarks(*all, analysis);
  if (auto kept = KeepFiltered(*all, analysis); !kept) return kept;
  analysis.answered = true;
  return {};
}

}  // namespace

Result<BandAnalysis> AnalyzeBand(const trial::Record& record, const BandQuestion& question) {
  return AnalyzeBand(trial::RecordRows(record), question);
}

Result<BandAnalysis> AnalyzeBand(const trial::RowSource& source, const BandQuestion& question,
                                 int threads) {
  // the band must be possible at some rate; whether the record's will do is an answer, not an error
  if (const auto possible = DesignBandPass(question.band, 4 * question.band.upper_hz); !possible) {
    return std::unexpected(possible.error());
  }
  const trial::Record& head = source.head();
  const auto channel = DisplacementOf(head);
  if (!channel) return std::unexpected(channel.error());

  // one pass over all rows
  BandAnalysis analysis;
  analysis.band = question.band;
  RawSummarizer summarizer(head);
  const auto segments = SplitIntoSegments(
      source, *channel, question.band.upper_hz,
      [&](std::size_t /*first_row*/, std::span<const double> values,
          std::span<const SampleStatus> statuses) { summarizer.Feed(values, statuses); });
  if (!segments) return std::unexpected(segments.error());
  DescribeRecord(head, *segments, summarizer.Finish(), analysis);
  if (analysis.measured == 0) {
    return CannotAnswer("",
                        fmt::format("none of its {} readings is a measurement ({})", analysis.rows,
                                    Unmeasured(analysis)),
                        "check the target and the sensor's range");
  }

  CheckObservable(head, *segments, question.band, analysis);
  if (!analysis.reasons.empty()) return analysis;
  const Displacement displacement{source, *channel, threads};
  if (auto done = AnswerBand(displacement, *segments, question, analysis); !done) {
    return std::unexpected(done.error());
  }
  return analysis;
}

}  // namespace haptometer::dsp
