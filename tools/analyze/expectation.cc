#include "tools/analyze/expectation.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "trial/import/table_cells.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kOption = "--expect";
constexpr std::string_view kForm =
    "write it as tone=225Hz+-1Hz, amplitude=20um+-2um, rms=14um+-1um, change<5% or source=device, "
    "with commas between";

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
    {kChanges,
     {"larger-change-than-expected",
      "the amplitude changes by {change %} over the window; less than {most %} is expected"}},
    {kOtherSource, {"other-source-than-expected", "the data are {source}; {expected} is expected"}},
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
  const auto quantity = ParseQuantity(text, dimension, kOption);
  if (!quantity) return std::unexpected(quantity.error());
  if (quantity->exact()) return Wrong(part, "states no tolerance");
  into = *quantity;
  return {};
}

// "5%": a share
Result<void> TakeChange(std::string_view part, std::string_view text, Expectation& expected) {
  if (expected.most_change) return Wrong(part, "stands in it twice");
  if (!text.ends_with('%')) return Wrong(part, "is not in percent");
  const auto percent = ParseQuantity(text.substr(0, text.size() - 1), Dimension::kNone, kOption);
  if (!percent) return std::unexpected(percent.error());
  if (!(percent->value > 0)) return Wrong(part, "is not above 0");
  expected.most_change = percent->value / 100;
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
  const std::size_t sign = part.find_first_of("=<");
  if (sign == std::string_view::npos) return Wrong(part, "is not an expectation");
  const std::string_view name = trial::Trimmed(part.substr(0, sign));
  const std::string_view text = trial::Trimmed(part.substr(sign + 1));
  if (part[sign] == '<') {
    return name == "change" ? TakeChange(part, text, expected)
                            : Wrong(part, "is not an expectation");
  }
  if (name == "tone") return TakeQuantity(part, text, Dimension::kFrequency, expected.tone_hz);
  if (name == "rms") return TakeQuantity(part, text, Dimension::kLength, expected.rms_m);
  if (name == "source") return TakeSource(part, text, expected);
  if (name == "amplitude") {
    return TakeQuantity(part, text, Dimension::kLength, expected.amplitude_m);
  }
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
    if (auto taken = TakePart(trial::Trimmed(rest.substr(0, comma)), expected); !taken) {
      return std::unexpected(taken.error());
    }
    if (comma == std::string_view::npos) return expected;
    rest.remove_prefix(comma + 1);
  }
}

ExpectationFindings DeviationsFrom(const Expectation& expected, const dsp::BandAnalysis& analysis,
                                   const std::vector<trial::DataSource>& sources) {
  ExpectationFindings findings;
  const auto* numbers = analysis.answered && analysis.numbers ? &*analysis.numbers : nullptr;
  const auto* tone = numbers != nullptr && numbers->tone ? &*numbers->tone : nullptr;
  // a quantity that is not determined cannot be as expected
  const auto compare = [&](const std::optional<Quantity>& wanted, std::string_view name,
                           std::optional<double> value, ExpectationFinding kind,
                           std::array<std::string_view, 3> keys) {
    if (!wanted) return;
    if (!value) return findings.Doubt(kNotDetermined, {{"quantity", std::string(name)}});
    if (std::abs(*value - wanted->value) <= wanted->standard_uncertainty) return;
    findings.Doubt(
        kind,
        {{keys[0], *value}, {keys[1], wanted->value}, {keys[2], wanted->standard_uncertainty}});
  };
  const auto of = [](const auto* from, const auto& number) {
    return from == nullptr ? std::nullopt : std::optional<double>(number(*from));
  };
  compare(expected.tone_hz, "the frequency of the tone",
          of(tone, [](const auto& t) { return t.fit.frequency_hz; }), kOtherTone,
          {"frequency_hz", "expected_hz", "tolerance_hz"});
  compare(expected.amplitude_m, "the amplitude of the tone",
          of(tone, [](const auto& t) { return t.amplitude_m; }), kOtherAmplitude,
          {"amplitude_m", "expected_m", "tolerance_m"});
  compare(expected.rms_m, "the RMS", of(numbers, [](const auto& n) { return n.rms.rms_m; }),
          kOtherRms, {"rms_m", "expected_m", "tolerance_m"});
  // change of the amplitude: of the state that the window lies in
  if (expected.most_change && (numbers == nullptr || !numbers->part.from_drive)) {
    findings.Doubt(kNotDetermined, {{"quantity", std::string("the change of the amplitude")}});
  } else if (expected.most_change && std::abs(numbers->part.state.drift) >= *expected.most_change) {
    findings.Doubt(kChanges,
                   {{"change", numbers->part.state.drift}, {"most", *expected.most_change}});
  }
  // all of the data must be of the source, of an interrupted recording too
  for (const trial::DataSource source : sources) {
    const bool is_source = source != trial::DataSource::kInterrupted;
    if (!expected.source || !is_source || source == *expected.source) continue;
    findings.Doubt(kOtherSource, {{"source", std::string(NameOf(source))},
                                  {"expected", std::string(NameOf(*expected.source))}});
  }
  if (expected.source && sources.empty()) {
    findings.Doubt(kNotDetermined, {{"quantity", std::string("the source of the data")}});
  }
  return findings;
}

}  // namespace haptometer::tools
