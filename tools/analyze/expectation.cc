#include "tools/analyze/expectation.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "trial/import/table/table_cells.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kOption = "--expect";
constexpr std::string_view kForm =
    "write it as tone=225Hz+-1Hz, amplitude=20um+-2um, rms=14um+-1um, distance=30mm+-2mm, "
    "change<5%, bad<1%, tremor<20um, steady>2s, averaging=16, source=device or, of a session, "
    "repeats<10%, with commas between";

struct Row {
  ExpectationFinding kind;
  document::Sentence sentence;
};

using enum ExpectationFinding;

constexpr auto kRows = std::to_array<Row>({
    {kOtherTone,
     {"other-tone-than-expected",
      "the tone is at {frequency_hz}; {expected_hz} +- {tolerance_hz} is expected"}},
    {kOtherAmplitude,
     {"other-amplitude-than-expected",
      "the amplitude of the tone is {amplitude_m}; {expected_m} +- {tolerance_m} is expected"}},
    {kOtherRms,
     {"other-rms-than-expected",
      "the vibration is {rms_m} RMS; {expected_m} +- {tolerance_m} is expected"}},
    {kOtherDistance,
     {"other-distance-than-expected",
      "the distance is {distance_m}; {expected_m} +- {tolerance_m} is expected"}},
    {kOtherScale,
     {"other-scale-than-expected",
      "{quantity} is {factor} times what is expected: check the unit, the scale and the "
      "calibration of the channel"}},
    {kOtherSign,
     {"other-sign-than-expected",
      "the distance is {distance_m} and {expected_m} is expected: check the polarity of the "
      "channel"}},
    {kChanges,
     {"larger-change-than-expected",
      "the amplitude changes by {change %} over the window; less than {most %} is expected"}},
    {kBadSamples,
     {"more-bad-samples-than-expected",
      "{share %} of the samples are no measurements; less than {most %} is expected"}},
    {kShort,
     {"shorter-than-expected",
      "{steady_s} of steady vibration can be used; more than {least_s} is expected"}},
    {kTremor,
     {"larger-tremor-than-expected",
      "the tremor is {tremor_m} RMS; less than {most_m} is expected"}},
    {kOtherAveraging,
     {"other-averaging-than-expected",
      "the sensor averages {averages} samples; {expected} is expected"}},
    {kOtherSource, {"other-source-than-expected", "the data are {source}; {expected} is expected"}},
    {kOtherThanRepeats,
     {"other-than-earlier-repeats",
      "the RMS differs by {deviation %} from the median of the earlier repeats, {repeats_m}; less "
      "than {most %} is expected"}},
    {kNotDetermined,
     {"expected-quantity-not-determined",
      "{quantity} is not determined, although a value is expected"}},
});

// one row for each kind
static_assert(kRows.size() == static_cast<std::size_t>(kNotDetermined) + 1);

std::unexpected<Error> Wrong(std::string_view part, std::string_view what) {
  return Usage(std::string(kOption), fmt::format("'{}' {}", part, what), std::string(kForm));
}

// "225Hz+-1Hz": a value and the largest difference permitted
Result<void> TakeQuantity(std::string_view part, std::string_view text, Dimension dimension,
                          std::optional<Quantity>& into) {
  if (into) return Wrong(part, "stands in it twice");
  HAPTOMETER_LET(const auto quantity, ParseQuantity(text, dimension, kOption));
  if (quantity.exact()) return Wrong(part, "states no tolerance");
  into = quantity;
  return {};
}

// "5%": a share
Result<void> TakeShare(std::string_view part, std::string_view text, std::optional<double>& into) {
  if (into) return Wrong(part, "stands in it twice");
  if (!text.ends_with('%')) return Wrong(part, "is not in percent");
  HAPTOMETER_LET(const auto percent,
                 ParseQuantity(text.substr(0, text.size() - 1), Dimension::kNone, kOption));
  if (!(percent.value > 0)) return Wrong(part, "is not above 0");
  into = percent.value / 100;
  return {};
}

// "2s": a limit, without a tolerance
Result<void> TakeLimit(std::string_view part, std::string_view text, Dimension dimension,
                       std::optional<double>& into) {
  if (into) return Wrong(part, "stands in it twice");
  const auto quantity = ParseQuantity(text, dimension, kOption);
  if (!quantity) return std::unexpected(quantity.error());
  if (!quantity->exact() || !(quantity->value > 0)) return Wrong(part, "is no limit above 0");
  into = quantity->value;
  return {};
}

Result<void> TakeSource(std::string_view part, std::string_view text, Expectation& expected) {
  using enum trial::DataSource;
  if (expected.source) return Wrong(part, "stands in it twice");
  // that a recording was interrupted is no source of its data
  for (const auto source : {kDevice, kEmulated, kSimulated, kImported}) {
    if (NameOf(source) == text) expected.source = source;
  }
  if (!expected.source) return Wrong(part, "is not a source of data");
  return {};
}

Result<void> TakePart(std::string_view part, Expectation& expected) {
  const std::size_t sign = part.find_first_of("=<>");
  if (sign == std::string_view::npos) return Wrong(part, "is not an expectation");
  // "change<": the quantity with its sign
  const std::string name = std::string(trial::Trimmed(part.substr(0, sign))) + part[sign];
  const std::string_view text = trial::Trimmed(part.substr(sign + 1));
  if (name == "tone=") return TakeQuantity(part, text, Dimension::kFrequency, expected.tone_hz);
  if (name == "amplitude=") {
    return TakeQuantity(part, text, Dimension::kLength, expected.amplitude_m);
  }
  if (name == "rms=") return TakeQuantity(part, text, Dimension::kLength, expected.rms_m);
  if (name == "distance=") return TakeQuantity(part, text, Dimension::kLength, expected.distance_m);
  if (name == "change<") return TakeShare(part, text, expected.most_change);
  if (name == "bad<") return TakeShare(part, text, expected.most_bad);
  if (name == "repeats<") return TakeShare(part, text, expected.most_off_repeats);
  if (name == "tremor<") return TakeLimit(part, text, Dimension::kLength, expected.most_tremor_m);
  if (name == "steady>") return TakeLimit(part, text, Dimension::kTime, expected.least_steady_s);
  if (name == "averaging=") return TakeLimit(part, text, Dimension::kNone, expected.averages);
  if (name == "source=") return TakeSource(part, text, expected);
  return Wrong(part, "is not an expectation");
}

}  // namespace

document::Sentence SentenceOf(ExpectationFinding kind) {
  return std::ranges::find(kRows, kind, &Row::kind)->sentence;
}

Result<Expectation> ParseExpectation(const std::string& text) {
  Expectation expected;
  std::string_view rest = text;
  // parts between commas, each read once
  while (true) {
    const std::size_t comma = rest.find(',');
    HAPTOMETER_TRY(TakePart(trial::Trimmed(rest.substr(0, comma)), expected));
    if (comma == std::string_view::npos) return expected;
    rest.remove_prefix(comma + 1);
  }
}

namespace {

// what an analysis gives of the quantities that can be expected
struct Measured {
  std::optional<double> tone_hz, amplitude_m, rms_m, change, bad, steady_s, tremor_m, averages;
  double distance_m = 0;
};

Measured MeasuredOf(const dsp::BandAnalysis& analysis) {
  Measured measured;
  measured.distance_m = analysis.record.offset_m;
  if (analysis.record.rows > 0) {
    measured.bad = 1 - static_cast<double>(analysis.record.measured) /
                           static_cast<double>(analysis.record.rows);
  }
  if (analysis.slow_motion) measured.tremor_m = analysis.slow_motion->tremor_rms;
  if (!analysis.answered || !analysis.numbers) return measured;
  const dsp::BandNumbers& numbers = *analysis.numbers;
  measured.rms_m = numbers.rms.rms_m;
  measured.steady_s = numbers.part.window.duration_s();
  if (numbers.tone) {
    measured.tone_hz = numbers.tone->fit.frequency_hz;
    measured.amplitude_m = numbers.tone->amplitude_m;
  }
  // of the state that the window lies in
  if (numbers.part.from_drive) measured.change = numbers.part.state.drift;
  const dsp::SensorAveraging& averaging = numbers.sensor.averaging;
  if (averaging.knowledge != dsp::SensorKnowledge::kUnknown) measured.averages = averaging.averages;
  return measured;
}

// a value against what is expected of it; one that is not determined cannot be as expected
class Comparison {
 public:
  explicit Comparison(ExpectationFindings& findings) : findings_(findings) {}

  void Near(const std::optional<Quantity>& wanted, std::string_view name,
            std::optional<double> value, ExpectationFinding kind,
            std::array<std::string_view, 3> keys) {
    if (!wanted || IsUnknown(name, value)) return;
    if (std::abs(*value - wanted->value) <= wanted->standard_uncertainty) return;
    findings_.Doubt(
        kind,
        {{keys[0], *value}, {keys[1], wanted->value}, {keys[2], wanted->standard_uncertainty}});
    // so far off that the channel itself may be read wrongly
    const double factor = std::abs(*value / wanted->value);
    if (kind == kOtherTone || wanted->value == 0) return;
    if (factor < kOtherScaleFactor && factor * kOtherScaleFactor > 1) return;
    findings_.Doubt(kOtherScale, {{"quantity", std::string(name)}, {"factor", factor}});
  }

  // not beyond a limit; `sign` -1: not below it
  void Within(const std::optional<double>& limit, std::string_view name,
              std::optional<double> value, ExpectationFinding kind,
              std::array<std::string_view, 2> keys, double sign = 1) {
    if (!limit || IsUnknown(name, value)) return;
    if (sign * *limit > sign * std::abs(*value)) return;
    findings_.Doubt(kind, {{keys[0], *value}, {keys[1], *limit}});
  }

  bool IsUnknown(std::string_view name, std::optional<double> value) {
    if (!value) findings_.Doubt(kNotDetermined, {{"quantity", std::string(name)}});
    return !value;
  }

 private:
  ExpectationFindings& findings_;
};

// all of the data must be of the source, of an interrupted recording too
void CompareSources(const Expectation& expected, const std::vector<trial::DataSource>& sources,
                    ExpectationFindings& findings) {
  if (!expected.source) return;
  for (const trial::DataSource source : sources) {
    const bool is_source = source != trial::DataSource::kInterrupted;
    if (!is_source || source == *expected.source) continue;
    findings.Doubt(kOtherSource, {{"source", std::string(NameOf(source))},
                                  {"expected", std::string(NameOf(*expected.source))}});
  }
  if (sources.empty()) {
    findings.Doubt(kNotDetermined, {{"quantity", std::string("the source of the data")}});
  }
}

void CompareRepeats(const Expectation& expected, std::optional<double> rms_m,
                    std::optional<double> repeats_m, ExpectationFindings& findings) {
  if (!expected.most_off_repeats || !rms_m || !repeats_m) return;
  const double deviation = *rms_m / *repeats_m - 1;
  if (std::abs(deviation) < *expected.most_off_repeats) return;
  findings.Doubt(
      kOtherThanRepeats,
      {{"deviation", deviation}, {"most", *expected.most_off_repeats}, {"repeats_m", *repeats_m}});
}

}  // namespace

ExpectationFindings DeviationsFrom(const Expectation& expected, const dsp::BandAnalysis& analysis,
                                   const std::vector<trial::DataSource>& sources,
                                   std::optional<double> repeats_m) {
  ExpectationFindings findings;
  Comparison compare(findings);
  const Measured measured = MeasuredOf(analysis);
  compare.Near(expected.tone_hz, "the frequency of the tone", measured.tone_hz, kOtherTone,
               {"frequency_hz", "expected_hz", "tolerance_hz"});
  compare.Near(expected.amplitude_m, "the amplitude of the tone", measured.amplitude_m,
               kOtherAmplitude, {"amplitude_m", "expected_m", "tolerance_m"});
  compare.Near(expected.rms_m, "the RMS", measured.rms_m, kOtherRms,
               {"rms_m", "expected_m", "tolerance_m"});
  compare.Near(expected.distance_m, "the distance", measured.distance_m, kOtherDistance,
               {"distance_m", "expected_m", "tolerance_m"});
  if (expected.distance_m && expected.distance_m->value * measured.distance_m < 0) {
    findings.Doubt(kOtherSign, {{"distance_m", measured.distance_m},
                                {"expected_m", expected.distance_m->value}});
  }
  compare.Within(expected.most_change, "the change of the amplitude", measured.change, kChanges,
                 {"change", "most"});
  compare.Within(expected.most_bad, "the share of bad samples", measured.bad, kBadSamples,
                 {"share", "most"});
  compare.Within(expected.least_steady_s, "the length of the steady vibration", measured.steady_s,
                 kShort, {"steady_s", "least_s"}, -1);
  compare.Within(expected.most_tremor_m, "the tremor", measured.tremor_m, kTremor,
                 {"tremor_m", "most_m"});
  if (expected.averages && !compare.IsUnknown("the sensor's averaging", measured.averages) &&
      *measured.averages != *expected.averages) {
    findings.Doubt(kOtherAveraging,
                   {{"averages", *measured.averages}, {"expected", *expected.averages}});
  }
  CompareSources(expected, sources, findings);
  CompareRepeats(expected, measured.rms_m, repeats_m, findings);
  return findings;
}

}  // namespace haptometer::tools
