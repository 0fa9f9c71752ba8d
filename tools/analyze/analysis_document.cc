#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/mapped.h"
#include "tools/analyze/analyze.h"
#include "tools/analyze/halving.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_dsp.h"
#include "tools/document/keys.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Form;
using document::Item;
using document::Key;
using document::Section;
using document::Unit;
using document::Value;

// keys that are used in more than one section
constexpr Key kToneAmplitude{"tone_amplitude_m", "amplitude of the tone", document::kMetre,
                             Form::kInterval};
constexpr Key kThd{"thd", "THD", document::kShare, Form::kUncertain};
constexpr Key kStandardUncertainty{"standard_uncertainty_m", "standard uncertainty",
                                   document::kMetre};

constexpr double kPartOfMotion = 1e-6;
constexpr double kPartOfStep = 0.1;  // of the input's step: a mean of many readings resolves it
constexpr double kFarTimeS = 1e5;    // six digits of it show no fraction of a second
// limits of LatencyVerdict(), s
constexpr double kLatencyCostsS = 0.025;
constexpr double kLatencyPerceivedS = 0.050;

// the number where the condition holds
Value If(bool condition, std::optional<double> number) {
  return condition ? Value(number) : Value();
}

// words in place of a number, shown in text only
void AddWords(Section& section, std::string_view label, std::string words) {
  section.Add({"", label}, std::move(words));
}

document::Range RangeOf(const dsp::TimeWindow& window) { return {window.begin_s, window.end_s}; }

// begin and end of each window, s
std::vector<std::vector<double>> PairsOf(const std::vector<dsp::TimeWindow>& windows) {
  return Mapped(windows, [](const dsp::TimeWindow& window) {
    return std::vector{window.begin_s, window.end_s};
  });
}

// frequency at begin and end of a sweep in the window
std::optional<document::Range> MovesOf(const dsp::BandAnalysis& analysis) {
  using enum dsp::FindingKind;
  const bool moves =
      analysis.findings.Has(kFrequencyMoves) || analysis.findings.Has(kFrequencyDrifts);
  if (!analysis.numbers || !moves) return {};
  const dsp::StateInterval& state = analysis.numbers->part.state;
  return document::Range{state.from_hz, state.to_hz};
}

std::string BandName(const dsp::BandPass& band) {
  return fmt::format("{:g}-{:g} Hz", band.lower_hz, band.upper_hz);
}

std::string FilterText(const dsp::BandPass& band) {
  return fmt::format("{}, Butterworth of order {}, forward and backward, -3 dB of {}",
                     BandName(band), band.order,
                     band.corners == dsp::Corners::kWhole ? "both together" : "each");
}

// a length in a note, to three digits
std::string AboutText(double metres) { return document::QuantityText(metres, document::kMetre, 3); }

// Lengths and times of the section show no digit that the input cannot hold.
// file.step_m of lengths, 1 / rate of times; a resolution that is set already has priority
void LimitDigits(const AnalyzedFile& file, Section& section) {
  const double rate_hz = file.analysis ? file.analysis->record.rate_hz : 0;
  for (Item& item : section.items) {
    if (item.resolution > 0) continue;
    if (item.unit.ending == document::kMetre.ending) item.resolution = kPartOfStep * file.step_m;
    if (item.unit.ending == document::kSecond.ending && rate_hz > 0) {
      item.resolution = kPartOfStep / rate_hz;
    }
  }
  for (Section& inner : section.sections) LimitDigits(file, inner);
}

// Far times, as of a record whose times count from an epoch: text shows them in words, to a sample,
// because six digits do not distinguish them. The numbers stay under their names.
void SpellFarTimes(double rate_hz, Section& section) {
  const int places = static_cast<int>(std::ceil(std::log10(std::max(rate_hz, 1.0))));
  const auto spell = [&](const Item& item) -> std::string {
    if (item.label.empty() || item.unit.ending != document::kSecond.ending) return {};
    if (const auto* time = std::get_if<double>(&item.value); time && *time >= kFarTimeS) {
      return fmt::format("{:.{}f} s", *time, places);
    }
    const auto* range = std::get_if<document::Range>(&item.value);
    if (!range || range->upper < kFarTimeS) return {};
    return fmt::format("{:.{}f} to {:.{}f} s", range->lower, places, range->upper, places);
  };
  std::vector<Item> items;
  for (Item& item : section.items) {
    std::string words = spell(item);
    if (!words.empty()) {
      items.push_back({.label = std::exchange(item.label, ""),
                       .value = std::move(words),
                       .note = std::exchange(item.note, "")});
    }
    items.push_back(std::move(item));
  }
  section.items = std::move(items);
  for (Section& inner : section.sections) SpellFarTimes(rate_hz, inner);
}

// --- the answer ---

// the corrections between measured and reported RMS; empty where there is none
std::string CorrectionText(const dsp::BandNumbers& numbers) {
  std::string text;
  if (numbers.rms.floor_m) {
    text = fmt::format("noise floor of {} subtracted in power", AboutText(*numbers.rms.floor_m));
  }
  if (numbers.sensor.divided_out && numbers.sensor.gain_at_tone) {
    text += fmt::format("{}corrected for the sensor's gain of {:.4g} at the tone",
                        text.empty() ? "" : "; ", *numbers.sensor.gain_at_tone);
  }
  return text;
}

// the RMS with its interval, or its upper or lower limit
void AddRms(const dsp::BandAnalysis& analysis, const dsp::BandNumbers& numbers, Section& section) {
  const dsp::RmsEstimate& rms = numbers.rms;
  const std::string band = "in " + BandName(analysis.band);
  // clipped in the window: the RMS is a lower limit only
  const bool is_number = !numbers.is_lower_limit;
  const bool is_shown = is_number && !rms.below_floor;
  const auto add = [&](const Key& key, bool is_known) {
    Item& item = section.Add(key, If(is_known, rms.rms_m));
    item.note = band;
    if (!is_number) return;
    if (!rms.below_floor) item.standard_uncertainty = rms.standard_uncertainty_m;
    item.interval = {rms.lower_m, rms.upper_m};
  };
  // text shows one of four: an answer, an estimate (no answer), an upper or a lower limit
  add({document::kBandRms.name, is_shown ? "vibration (RMS)" : "", document::kMetre,
       Form::kInterval},
      is_shown && analysis.answered);
  add({"band_rms_estimate_m", is_shown ? "estimate (RMS), no answer" : "", document::kMetre},
      is_number && !analysis.answered);
  section
      .Add({"band_rms_at_most_m", "vibration (RMS) at most", document::kMetre},
           If(is_number && rms.below_floor, rms.at_most_m))
      .note = fmt::format("{} (95 %): not above the noise floor of {}", band,
                          AboutText(rms.floor_m.value_or(0)));
  section
      .Add({"band_rms_at_least_m", "vibration (RMS) at least", document::kMetre},
           If(numbers.is_lower_limit, rms.lower_m))
      .note = band + ": clipped, so that no upper limit is known";
  // the RMS before the corrections, shown in text where there is one
  const std::string correction = CorrectionText(numbers);
  section
      .Add({"band_rms_as_measured_m", correction.empty() ? "" : "as measured", document::kMetre},
           rms.as_measured_m)
      .note = correction;
}

// strongest tone: frequency in Hz, amplitude in m (peak), each with uncertainty and interval
void AddTone(const dsp::BandAnalysis& analysis, const dsp::BandNumbers& numbers, Section& section) {
  const dsp::ToneNumbers tone = numbers.tone.value_or(dsp::ToneNumbers{});
  const bool is_number = numbers.tone && !numbers.is_lower_limit;
  Item& frequency =
      section.Add({document::kToneFrequency.name, "", document::kHertz, Form::kInterval},
                  If(numbers.tone.has_value(), tone.fit.frequency_hz));
  if (numbers.tone) {
    frequency.standard_uncertainty = tone.fit.frequency_uncertainty_hz;
    frequency.interval = {tone.frequency_lower_hz, tone.frequency_upper_hz};
    section.Add({"", "strongest tone", document::kHertz}, tone.fit.frequency_hz,
                tone.fit.frequency_uncertainty_hz);
  } else {
    AddWords(section, "strongest tone",
             MovesOf(analysis) ? "none: the frequency changes" : "none above the noise");
  }
  // amplitude as answer, as estimate (no answer) or as lower limit (clipped)
  const auto add = [&](const Key& key, bool is_known) {
    Item& item = section.Add(key, If(is_known, tone.amplitude_m));
    if (!is_number) return;
    item.standard_uncertainty = tone.amplitude_uncertainty_m;
    item.interval = {tone.amplitude_lower_m, tone.amplitude_upper_m};
  };
  add(kToneAmplitude, is_number && analysis.answered);
  add({"tone_amplitude_estimate_m", "estimate of the tone's amplitude", document::kMetre},
      is_number && !analysis.answered);
  section.Add({"tone_amplitude_at_least_m", "amplitude of the tone at least", document::kMetre},
              If(numbers.tone && !is_number, tone.amplitude_lower_m));
}

// Latency for a user (Lindsay 2013, p. 4): from 25 ms on it causes errors, from 50 ms on it is
// perceived.
std::string_view LatencyVerdict(double latency_s) {
  if (latency_s < kLatencyCostsS) return "below 25 ms, where it begins to cause errors";
  if (latency_s < kLatencyPerceivedS) return "above 25 ms, where it causes errors; below 50 ms";
  return "above 50 ms, where it is perceived";
}

// onset at the low level of the edge, rise time or its upper limit, latency after the drive
Section OnsetSection(const std::optional<dsp::OnsetNumbers>& found) {
  const dsp::OnsetNumbers onset = found.value_or(dsp::OnsetNumbers{});
  const dsp::Edge& edge = onset.edge;
  Section section{.name = "onset", .is_known = found.has_value()};
  section
      .Add({document::kTime.name, "onset", document::kSecond, Form::kUncertain}, edge.time_s,
           edge.time_uncertainty_s)
      .note =
      fmt::format("where {:.0f} % of the steady amplitude are reached", 100 * edge.low_level);
  section.Add({"level_of_steady"}, edge.low_level);
  section.Add(document::kRise.As(Form::kUncertain), edge.rise_s,
              edge.rise_s ? std::optional(edge.rise_uncertainty_s) : std::nullopt);
  section.Add({document::kRiseAtMost.name, edge.rise_s ? "" : document::kRiseAtMost.label,
               document::kSecond},
              edge.rise_at_most_s);
  // neither a rise nor a limit of it: noise covers the edge's begin
  if (!edge.rise_s && !edge.rise_at_most_s) {
    AddWords(section, "rise", "not determined: the noise masks its beginning");
  }
  section.Add({"drive_s"}, onset.drive_s);
  // latency = onset - begin of the drive: needs a drive channel or a trigger
  if (onset.latency_s) {
    section
        .Add({document::kLatency.name, "latency", document::kSecond, Form::kUncertain},
             *onset.latency_s, onset.latency_uncertainty_s)
        .note = LatencyVerdict(*onset.latency_s);
  } else {
    section.Add({document::kLatency.name, "", document::kSecond, Form::kUncertain}, Value());
    AddWords(section, "latency", "not known: no drive channel or trigger");
  }
  return section;
}

// the numbers of the window; all keys exist without analysis too, with empty values
Section AnswerSection(const dsp::BandAnalysis& analysis, const dsp::BandNumbers& numbers) {
  Section section{.is_known = analysis.numbers.has_value()};
  dsp::Finding why = numbers.part.why;
  if (numbers.part.window.end_s >= kFarTimeS) why.numbers.clear();  // its times, to four digits
  const std::string because = document::TextOf(why);
  AddRms(analysis, numbers, section);
  section.Add(document::kWindowS, RangeOf(numbers.part.window)).note = because;
  section.Add({"window_because"}, because);
  section.Add({"excluded_s"}, PairsOf(numbers.excluded));
  section.Add({"band_rms_whole_m", "whole record (RMS)", document::kMetre}, numbers.whole_rms_m)
      .note = "including filter transients at the ends, and pauses";
  AddTone(analysis, numbers, section);
  section.sections.push_back(OnsetSection(numbers.onset));
  SpellFarTimes(analysis.record.rate_hz, section);
  return section;
}

// --- the record ---

Section BandSection(const AnalyzedFile& file, const dsp::BandPass& band) {
  Section section{.name = document::kBand.name, .is_known = file.analysis.has_value()};
  section.Add(document::kLowerHz, band.lower_hz);
  section.Add(document::kUpperHz, band.upper_hz);
  section.Add(document::kOrder, band.order);
  section.Add(document::kCorner, band.corners == dsp::Corners::kWhole ? "whole" : "each");
  return section;
}

// headings by dsp::FaultKind
constexpr std::array<std::string_view, dsp::kFaultKindCount> kArtifacts{
    "clipped segments", "held readings", "spikes", "steps"};

// count and readings of each kind (shown where above 0), and each artifact with row and size
Section ArtifactSection(const AnalyzedFile& file, const dsp::Faults& faults) {
  Section section{.name = "faults", .is_known = file.analysis.has_value()};
  for (std::size_t k = 0; k < dsp::kFaultKindCount; ++k) {
    const auto kind = static_cast<dsp::FaultKind>(k);
    Section& one = section.sections.emplace_back();
    one.name = dsp::Name(kind);
    const bool is_shown = faults.Count(kind) > 0;
    one.Add({document::kCount.name, is_shown ? kArtifacts[k] : ""}, faults.Count(kind)).note =
        fmt::format("{} readings in all", faults.Rows(kind));
    one.Add({document::kReadings.name}, faults.Rows(kind));
  }
  Section list{.name = document::kList.name, .shape = Section::Shape::kArray};
  for (const dsp::Fault& fault : faults.list) {
    Section& one = list.sections.emplace_back();
    one.Add(document::kKind, dsp::Name(fault.kind));
    one.Add({document::kFirstRow.name}, fault.first_row);
    one.Add({document::kRows.name}, fault.rows);
    one.Add({"size_m"}, fault.size);
  }
  section.sections.push_back(std::move(list));
  return section;
}

// drift in m/s and tremor (3 to 13 Hz) in m RMS, below the band
void AddSlowMotion(const std::optional<dsp::SlowMotion>& found, Section& section) {
  const dsp::SlowMotion slow = found.value_or(dsp::SlowMotion{});
  section.Add({"drift_m_per_s", "drift", document::kMetrePerSecond},
              If(found.has_value(), slow.drift_per_s), slow.drift_uncertainty_per_s);
  section
      .Add({"tremor_rms_m", "tremor (RMS)", document::kMetre}, slow.tremor_rms,
           slow.tremor_rms_uncertainty)
      .note = fmt::format("between 3 and 13 Hz, about {:.3g} Hz", slow.tremor_frequency_hz);
  section.Add({"tremor_frequency_hz"}, If(slow.tremor_rms.has_value(), slow.tremor_frequency_hz));
}

// whose recording it is, and what of, for a page
Section OriginSection(const trial::Metadata& metadata) {
  Section section{.detail = Detail::kPage};
  for (const auto& [label, text] : metadata.labels) {
    section.Add({"", label}, document::TextOrNotKnown(text));
  }
  section.Add({"", "recorded"}, document::TextOrNotKnown(metadata.utc_start));
  section.Add({"", "sensor"},
              document::TextOrNotKnown(fmt::format(
                  "{}{}{}", metadata.sensor,
                  metadata.sensor.empty() || metadata.head.empty() ? "" : " ", metadata.head)));
  return section;
}

// shown in the short form only where there are no numbers of the band
Section RecordSection(const AnalyzedFile& file, const dsp::BandAnalysis& analysis) {
  const dsp::RecordFacts& record = analysis.record;
  Section section{.heading = analysis.numbers ? "record" : "",
                  .detail = analysis.numbers ? Detail::kAll : Detail::kShort,
                  .is_known = file.analysis.has_value()};
  const std::string& source = file.metadata.source;
  if (!source.empty()) AddWords(section, "source", source);
  section.Add(document::kReadings, record.rows);
  section.Add({document::kMeasured.name, "of which measured"}, record.measured);
  section.Add({"bridged", "interpolated"}, record.bridged);
  section.Add({"segments", "segments"}, record.segments);
  section.Add(document::kDuration, record.duration_s);
  section.Add(document::kSampleRate, record.rate_hz);
  section.Add(document::kNewReadings, record.fresh_rate_hz);
  section.Add(document::kObservableUpper, record.observable_upper_hz);
  // what rounding leaves of an offset of 0 is below a millionth of the motion
  section.Add(document::kOffsetM, record.offset_m).resolution =
      std::max(kPartOfStep * file.step_m, kPartOfMotion * record.peak_to_peak_m);
  section.Add({"peak_to_peak_m", "peak to peak", document::kMetre}, record.peak_to_peak_m).note =
      "unfiltered";
  AddSlowMotion(analysis.slow_motion, section);
  const auto moves_hz = MovesOf(analysis);
  section.Add({"frequency_moves_hz", "frequency changes", document::kHertz},
              moves_hz ? Value(*moves_hz) : Value());
  section.sections = {BandSection(file, analysis.band), ArtifactSection(file, analysis.faults)};
  return section;
}

// amplitude at the drive's known frequency, of a record too slow for the band
Section KnownToneSection(const std::optional<dsp::KnownTone>& found) {
  const dsp::KnownTone known = found.value_or(dsp::KnownTone{});
  Section section{.name = "known_tone", .is_known = found.has_value()};
  section.Add({document::kFrequency.name, "at the drive's frequency", document::kHertz},
              known.fit.frequency_hz);
  section.Add(document::kAmplitude, known.fit.amplitude, known.fit.amplitude_uncertainty).note =
      known.aliased ? "as an alias" : "";
  section.Add({kStandardUncertainty.name}, known.fit.amplitude_uncertainty);
  section.Add({"aliased"}, known.aliased);
  return section;
}

// --- details of the answer ---

Section BelowBandSection(const std::optional<dsp::BelowBand>& found) {
  const dsp::BelowBand below = found.value_or(dsp::BelowBand{});
  Section section{.name = "below_band",
                  .heading = "strongest tone below the band",
                  .is_known = found.has_value()};
  section.Add(document::kFrequency, below.frequency_hz);
  section.Add(document::kAmplitude, below.amplitude_m);
  section.Add({"leaked_rms_m", "of which in the band (RMS)", document::kMetre}, below.leaked_rms_m);
  section.Add({"modelled", "modelled and subtracted"}, below.modelled);
  return section;
}

// states of the drive in order of time, and the delay of the vibration after the drive channel
Section DriveSection(const dsp::BandAnalysis& analysis, const dsp::BandNumbers& numbers) {
  Section section{.name = "drive", .heading = "drive"};
  section.Add({"window_is_of_the_drive", "window is in a state that is on"},
              numbers.part.from_drive);
  const dsp::DriveDelay delay = numbers.delay.value_or(dsp::DriveDelay{});
  section.Add({"delay_s", "vibration after the drive channel", document::kSecond, Form::kUncertain},
              If(numbers.delay.has_value(), delay.delay_s), delay.uncertainty_s);
  section.Add({"quiet_s"}, PairsOf(numbers.part.quiet));
  Section states{.name = "states", .shape = Section::Shape::kTable};
  for (const dsp::StateInterval& one : analysis.states) {
    Section& row = states.sections.emplace_back();
    row.Add({"from_s", "from", document::kSecond}, one.time.begin_s);
    row.Add({"to_s", "to", document::kSecond}, one.time.end_s);
    row.Add({document::kState.name, "state"}, Name(one.state));
    row.Add({document::kRms.name, "RMS", document::kMetre}, one.rms_m);
    row.Add({"drift", "change of amplitude", document::kShare}, one.drift);
  }
  section.sections.push_back(std::move(states));
  SpellFarTimes(analysis.record.rate_hz, section);
  return section;
}

// hum of the mains that is subtracted, with frequency and amplitude of each line
Section HumSection(const std::vector<dsp::SteadyLine>& lines) {
  Section hum{.name = "hum", .heading = "hum, subtracted", .shape = Section::Shape::kTable};
  for (const dsp::SteadyLine& line : lines) {
    Section& row = hum.sections.emplace_back();
    row.Add(document::kFrequency, line.frequency_hz);
    row.Add(document::kAmplitude, line.amplitude_m());
  }
  return hum;
}

// quantities of the filtered record: peak to peak, residual, noise floor, interpolation error
Section VibrationSection(const dsp::BandAnalysis& analysis, const dsp::BandNumbers& numbers) {
  Section section{.heading = "filter and noise",
                  .detail = Detail::kAll,
                  .is_known = analysis.numbers.has_value()};
  AddWords(section, "filter", FilterText(analysis.band));
  section.Add({"band_peak_to_peak_m", "peak to peak in the window", document::kMetre},
              numbers.peak_to_peak_m);
  section.Add({document::kResidualRms.name, "without the tone (RMS)", document::kMetre},
              numbers.residual_rms_m);
  // u(rms) = u(mean square) / (2 rms)
  std::optional<double> floor_uncertainty_m;
  if (numbers.floor && numbers.rms.floor_m > 0) {
    floor_uncertainty_m = std::sqrt(numbers.floor->power.variance) / 2 / *numbers.rms.floor_m;
  }
  section
      .Add({document::kNoiseRms.name, "noise floor (RMS)", document::kMetre}, numbers.rms.floor_m,
           floor_uncertainty_m)
      .note = numbers.floor ? "from " + document::SourceOf(*numbers.floor) : "";
  if (!numbers.floor) AddWords(section, "noise floor", "not known, not subtracted");
  section.Add({"noise_from"}, numbers.floor ? Value(document::SourceOf(*numbers.floor)) : Value());
  section.Add({"bridged_rms_m", "error of interpolation (RMS) at most", document::kMetre},
              numbers.bridged_rms_m);
  section.sections = {BelowBandSection(numbers.below_band), DriveSection(analysis, numbers),
                      HumSection(numbers.hum)};
  return section;
}

// standard uncertainty of each component, m; those below a hundredth of the combined one round to 0
Section BudgetSection(const dsp::BandAnalysis& analysis, const dsp::BandNumbers& numbers) {
  const bool is_known = analysis.numbers && !numbers.is_lower_limit;
  const double whole_m = numbers.rms.standard_uncertainty_m;
  Section budget{
      .name = "uncertainty_budget", .shape = Section::Shape::kTable, .is_known = is_known};
  for (const dsp::UncertaintyLine& line : numbers.rms.budget) {
    const document::CauseText text = document::TextOf(line.cause);
    Section& row = budget.sections.emplace_back();
    row.Add({document::kName.name, "cause"}, text.name);
    row.Add(document::kType, line.evaluation == dsp::Evaluation::kStatistical ? "A" : "B");
    row.Add(kStandardUncertainty, line.standard_uncertainty_m).resolution = whole_m / 100;
    row.Add({"how", "how it is evaluated"}, text.how);
  }
  Section section{
      .heading = "uncertainty of the RMS", .detail = Detail::kAll, .sections = {budget}};
  section.Add({"", "standard uncertainty, combined", document::kMetre}, If(is_known, whole_m))
      .resolution = whole_m / 10;
  if (!is_known) section.heading.clear();
  return section;
}

// THD = root of the harmonics' power over the fundamental's, or its upper limit
Section HarmonicsSection(const std::optional<dsp::Harmonics>& found, bool is_known) {
  const dsp::Harmonics harmonics = is_known ? *found : dsp::Harmonics{};
  Section section{.name = "harmonics", .is_known = is_known && harmonics.converged};
  // an uncertainty only with a value: a limit has none
  Item& thd = section.Add(kThd, harmonics.thd);
  if (harmonics.thd) thd.standard_uncertainty = harmonics.thd_uncertainty;
  thd.at_most = harmonics.thd_at_most;
  section.Add({"thd_at_most"}, harmonics.thd_at_most);
  Section list{
      .name = document::kList.name, .heading = "harmonics", .shape = Section::Shape::kTable};
  for (const dsp::Harmonic& harmonic : harmonics.harmonics) {
    Section& row = list.sections.emplace_back();
    row.Add({document::kOrder.name, "order"}, harmonic.order);
    row.Add(document::kFrequency, harmonic.frequency_hz);
    row.Add(document::kAmplitude.As(Form::kUncertain), harmonic.amplitude,
            harmonic.amplitude_uncertainty);
    row.Add({document::kPhase.name}, harmonic.phase_rad);
    row.Add({"stands_out", "above the noise"}, harmonic.stands_out);
  }
  section.sections.push_back(std::move(list));
  return section;
}

Section ToneSection(const dsp::BandNumbers& numbers) {
  // clipping changes amplitude and harmonics: no numbers of the tone then
  const bool is_known = numbers.tone && !numbers.is_lower_limit;
  const bool has_harmonics = numbers.harmonics && !numbers.is_lower_limit;
  const dsp::ToneNumbers tone = numbers.tone.value_or(dsp::ToneNumbers{});
  Section section{.heading = is_known ? "tone" : "", .detail = Detail::kAll};
  section.Add({"", "sine fit (RMS)", document::kMetre}, If(is_known, tone.sine_rms_m));
  section.Add({"tone_share_of_rms", "share of the filtered RMS", document::kShare},
              If(is_known, tone.share_of_rms));
  // v = 2 pi f A and a = (2 pi f)^2 A of the tone, computed in dsp
  section.Add({"tone_velocity_m_per_s", "amplitude of velocity", document::kMetrePerSecond},
              If(is_known, tone.velocity_m_per_s));
  section.Add(
      {"tone_acceleration_m_per_s2", "amplitude of acceleration", document::kMetrePerSecondSquared},
      If(is_known, tone.acceleration_m_per_s2));
  section.Add({kThd.name}, has_harmonics ? numbers.harmonics->thd : std::nullopt);
  section.sections = {HarmonicsSection(numbers.harmonics, has_harmonics)};
  return section;
}

// gain of the sensor's averaging at the tone and over the band, and whether it is corrected for
Section SensorSection(const dsp::BandAnalysis& analysis, const dsp::SensorNumbers& sensor) {
  Section section{
      .heading = "sensor", .detail = Detail::kAll, .is_known = analysis.numbers.has_value()};
  section.Add(document::kSensorAveraging, document::TextOf(sensor.averaging));
  section.Add({"sensor_gain_at_tone", "gain at the tone"}, sensor.gain_at_tone).note =
      sensor.divided_out ? "corrected for" : "";
  section.Add({"sensor_gain_in_band", "gain in the band"},
              sensor.gain_in_band ? Value(document::Range{sensor.gain_in_band->least,
                                                          sensor.gain_in_band->greatest})
                                  : Value());
  section.Add({"sensor_gain_divided_out"}, sensor.divided_out);
  section.Add({"calibration_relative_standard_uncertainty",
               "relative standard uncertainty of the calibration", document::kShare},
              analysis.gain_uncertainty);
  section.Add(document::kAmplitudeVerified, sensor.amplitude_verified);
  return section;
}

Section MotionSection(const std::optional<dsp::Kinematics>& found) {
  const dsp::Kinematics motion = found.value_or(dsp::Kinematics{});
  Section section{.name = "motion",
                  .heading = "motion in the band",
                  .detail = Detail::kAll,
                  .is_known = found.has_value()};
  section.Add({"velocity_rms_m_per_s", "velocity (RMS)", document::kMetrePerSecond},
              motion.velocity_rms);
  section.Add({"velocity_peak_m_per_s", "velocity (peak)", document::kMetrePerSecond},
              motion.velocity_peak);
  section.Add({"acceleration_rms_m_per_s2", "acceleration (RMS)", document::kMetrePerSecondSquared},
              motion.acceleration_rms);
  section.Add(
      {"acceleration_peak_m_per_s2", "acceleration (peak)", document::kMetrePerSecondSquared},
      motion.acceleration_peak);
  section.Add({"relative_error", "relative error at most", document::kShare},
              motion.relative_error);
  return section;
}

// at the tone's frequency: V RMS, A RMS, W, VA, phase in rad, and Z = R + jX in ohm
Section ElectricalSection(const std::optional<dsp::ElectricalState>& found) {
  const dsp::ElectricalState state = found.value_or(dsp::ElectricalState{});
  Section section{.name = "electrical",
                  .heading = "electrical, at the tone",
                  .detail = Detail::kAll,
                  .is_known = found.has_value()};
  const auto add = [&](const Key& key, const dsp::Estimate& estimate) {
    Section& one = section.sections.emplace_back();
    one.name = key.name;
    one.Add({document::kValue.name, key.label, key.unit}, estimate.value, estimate.uncertainty);
    one.Add(document::kStandardUncertainty, estimate.uncertainty);
  };
  add({"voltage_rms_v", "voltage (RMS)", document::kVolt}, state.voltage_rms_v);
  add(document::kCurrentRms, state.current_rms_a);
  add({"real_power_w", "real power", document::kWatt}, state.real_power_w);
  add({"apparent_power_va", "apparent power", document::kVoltAmpere}, state.apparent_power_va);
  add(document::kPhase, state.phase_rad);
  add({document::kResistance.name, "resistance", document::kOhm}, state.resistance_ohm);
  add({"reactance_ohm", "reactance", document::kOhm}, state.reactance_ohm);
  return section;
}

// --- findings of the analysis ---

// reasons: refusals of the analysis, or the error that prevented it
void AddFindings(const AnalyzedFile& file, bool is_alone, Section& section) {
  std::vector<std::string> reasons;
  if (file.analysis) {
    reasons = document::RefusalsOf(file.analysis->findings);
    document::AddFindings(section, file.analysis->findings);
  } else if (file.error) {
    reasons.push_back(cli::WithOptions(file.error->Text()));
    section.findings.push_back(
        {.kind = "error", .severity = Severity::kRefusal, .text = reasons.front(), .subject = ""});
  }
  document::AddFindings(section, file.findings);
  document::AddFindings(section, file.deviations);
  section.Add(document::kReasons, std::move(reasons));
  // with several trials each finding names its file
  for (document::Finding& finding : section.findings) {
    if (!is_alone && finding.subject.empty()) finding.subject = file.path;
  }
}

}  // namespace

document::Document AnalysisDocument(const std::string& first, std::size_t count) {
  document::Document document{
      .verb = "analyze",
      .title = count == 1 ? first : fmt::format("vibration of {} trials", count)};
  document.root.sections = {{.name = document::kTrials.name, .shape = Section::Shape::kArray}};
  return document;
}

Section TrialSection(const AnalyzedFile& file, bool is_alone) {
  // without an analysis the sections keep their keys, with empty values
  const dsp::BandAnalysis none;
  const dsp::BandNumbers no_numbers;
  const dsp::BandAnalysis& analysis = file.analysis ? *file.analysis : none;
  const dsp::BandNumbers& numbers = analysis.numbers ? *analysis.numbers : no_numbers;
  // an error is on standard error already, so text shows the trial with --all only
  Section trial{.heading = is_alone ? "" : file.path,
                .detail = file.analysis ? Detail::kShort : Detail::kAll};
  trial.Add(document::kFile, file.path);
  trial.Add(document::kAnswered, analysis.answered);
  trial.Add({document::kSource.name}, document::TextOrNotKnown(file.metadata.source));
  if (file.sources.empty()) trial.Add(document::kDataSources, Value());
  trial.sources = file.sources;
  trial.sections = {OriginSection(file.metadata),
                    AnswerSection(analysis, numbers),
                    Section{.figures = file.figures},
                    RecordSection(file, analysis),
                    KnownToneSection(analysis.known_tone),
                    VibrationSection(analysis, numbers),
                    BudgetSection(analysis, numbers),
                    ToneSection(numbers),
                    SensorSection(analysis, numbers.sensor),
                    MotionSection(numbers.kinematics),
                    ElectricalSection(numbers.electrical)};
  // after all sections are complete: digits are limited recursively
  LimitDigits(file, trial);
  AddFindings(file, is_alone, trial);
  AddHalving(analysis, is_alone ? "" : file.path, trial);
  return trial;
}

Section TableRow(const AnalyzedFile& file) {
  const dsp::BandAnalysis analysis = file.analysis.value_or(dsp::BandAnalysis{});
  const auto& numbers = analysis.numbers;
  const bool is_answered = analysis.answered && numbers && !numbers->rms.below_floor;
  const dsp::BandNumbers known = numbers.value_or(dsp::BandNumbers{});
  const dsp::ToneNumbers tone = known.tone.value_or(dsp::ToneNumbers{});
  const bool has_tone = analysis.answered && known.tone;
  Section row;
  row.Add(document::kFile, file.path);
  row.Add(document::kAnswered, static_cast<int>(analysis.answered));
  row.Add({document::kBandRms.name, "", document::kMetre, Form::kUncertain},
          If(is_answered, known.rms.rms_m),
          is_answered ? std::optional(known.rms.standard_uncertainty_m) : std::nullopt);
  row.Add({"band_rms_lower_m"}, If(is_answered, known.rms.lower_m));
  row.Add({"band_rms_upper_m"}, If(is_answered, known.rms.upper_m));
  row.Add(document::kNoiseRms, known.rms.floor_m);
  row.Add(document::kToneFrequency, If(has_tone, tone.fit.frequency_hz));
  row.Add({kToneAmplitude.name}, If(has_tone, tone.amplitude_m));
  row.Add({"window_from_s"}, If(numbers.has_value(), known.part.window.begin_s));
  row.Add({"window_to_s"}, If(numbers.has_value(), known.part.window.end_s));
  row.Add(document::kDataSources, document::SourcesText(file.sources));
  // kinds of all findings, refusals and errors first as they stand in the document
  Section found;
  AddFindings(file, true, found);
  const auto kinds = Mapped(found.findings, &document::Finding::kind);
  row.Add({"finding_kinds"}, fmt::format("{}", fmt::join(kinds, "; ")));
  return row;
}

Section ClosingSection(bool excludes_calibration, bool is_shown) {
  Section section;
  section.Add({"uncertainty_excludes", is_shown ? "uncertainty excludes" : ""},
              excludes_calibration ? Value("the sensor's calibration and linearity") : Value());
  return section;
}

}  // namespace haptometer::tools
