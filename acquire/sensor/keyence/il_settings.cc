#include "acquire/sensor/keyence/il_settings.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "acquire/protocol/keyence/dl_line.h"

namespace haptometer::acquire::il_setting {
namespace {

// a setting by its name in <set>
struct Key {
  std::string_view name;
  int number;
  std::ptrdiff_t codes;  // 0 to codes - 1
};

constexpr std::array kKeys = {
    Key{"sampling", dl_rs1a::kSamplingCycle, 1 + std::ssize(dl_rs1a::kSamplings_s)},
    Key{"averaging", dl_rs1a::kAveraging, 15}, Key{"hold", dl_rs1a::kHold, 6},
    Key{"high-pass", dl_rs1a::kHighPassCutoff, 10}};
constexpr std::string_view kOff = "off";

// the name of a code; "" where there is none
std::string CodeName(int number, int code) {
  switch (number) {
    case dl_rs1a::kSamplingCycle:
      if (code == 0) return "default";
      if (const auto s = dl_rs1a::SamplingSeconds(code)) return fmt::format("{:g}ms", *s * 1e3);
      return {};
    case dl_rs1a::kAveraging:
      if (code == dl_rs1a::kDifferenceFilter) return "difference";
      if (code == dl_rs1a::kHighPassFilter) return "high-pass";
      if (const auto averages = dl_rs1a::Averages(code)) return fmt::to_string(*averages);
      return {};
    case dl_rs1a::kHold: {
      std::string name(dl_rs1a::HoldName(code));
      std::ranges::replace(name, ' ', '-');
      return name;
    }
    case dl_rs1a::kHighPassCutoff:
      if (const auto hz = dl_rs1a::HighPassHz(code)) return fmt::format("{:g}Hz", *hz);
      return {};
    default:
      return {};
  }
}

// all values that <set> accepts for a key
std::vector<std::string> Values(const Key& key) {
  std::vector<std::string> values;
  if (key.number == dl_rs1a::kHighPassCutoff) values.emplace_back(kOff);
  for (int code = 0; code < key.codes; ++code) values.push_back(CodeName(key.number, code));
  return values;
}

}  // namespace

Result<std::vector<Write>> Parse(std::string_view text) {
  // KEY=VALUE; "auto peak" and "auto-peak" are the same
  const std::size_t equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  const auto key = std::ranges::find(kKeys, name, &Key::name);
  if (equals == std::string_view::npos || key == kKeys.end()) {
    return Usage("<set>", fmt::format("'{}' is not a setting of an IL amplifier", text),
                 "write sampling=..., averaging=..., hold=... or high-pass=...");
  }
  std::string value(text.substr(equals + 1));
  std::ranges::replace(value, ' ', '-');
  const bool is_high_pass = key->number == dl_rs1a::kHighPassCutoff;
  // off: averaging is set to code 0 (1 average) where it selects the high-pass filter now
  if (is_high_pass && value == kOff) {
    return std::vector{Write{std::string(name), dl_rs1a::kAveraging, 0, dl_rs1a::kHighPassFilter}};
  }
  for (int code = 0; code < key->codes; ++code) {
    if (CodeName(key->number, code) != value) continue;
    std::vector writes{Write{std::string(name), key->number, code}};
    // the corner has an effect only while averaging selects the high-pass filter
    if (is_high_pass) {
      writes.push_back({std::string(name), dl_rs1a::kAveraging, dl_rs1a::kHighPassFilter});
    }
    return writes;
  }
  return Usage("<set>", fmt::format("an IL amplifier has no {} '{}'", name, value),
               fmt::format("use one of {}", fmt::join(Values(*key), ", ")));
}

std::string Describe(int number, int code) {
  const std::string name = CodeName(number, code);
  return name.empty() ? fmt::to_string(code) : name;
}

}  // namespace haptometer::acquire::il_setting

namespace haptometer::acquire {
namespace {

// a mean of n samples, T apart, is 3 dB down at 0.443 / (n T): sinc(x) = 1/sqrt(2) at x = 0.443
constexpr double kMeanCorner = 0.443;

}  // namespace

std::string UnitSettings::Text(int number) const {
  const auto found = data_.find(number);
  return found == data_.end() ? std::string{} : found->second;
}

std::optional<int> UnitSettings::Code(int number) const { return dl::NumberOf(Text(number)); }

std::optional<double> UnitSettings::SamplingSeconds() const {
  const auto code = Code(dl_rs1a::kSamplingCycle);
  return code ? dl_rs1a::SamplingSeconds(*code) : std::nullopt;
}

std::optional<int> UnitSettings::Averages() const {
  const auto code = Code(dl_rs1a::kAveraging);
  return code ? dl_rs1a::Averages(*code) : std::nullopt;
}

const dl_rs1a::Head* UnitSettings::head() const {
  const auto code = Code(dl_rs1a::kConnectedHead);
  return code ? dl_rs1a::FindHead(*code) : nullptr;
}

bool UnitSettings::is_emulated() const {
  return Text(dl_rs1a::kProductName).find("EMULATED") != std::string::npos;
}

void UnitSettings::Describe(trial::Metadata& metadata) const {
  if (const dl_rs1a::Head* known = head()) metadata.head = known->name;
  metadata.sampling_s = SamplingSeconds();
  metadata.averages = Averages();
  if (const auto hold = Code(dl_rs1a::kHold)) metadata.hold = dl_rs1a::HoldName(*hold);
}

void UnitSettings::AddFields(trial::Metadata& metadata, std::string_view suffix) const {
  for (const auto& [number, data] : data_) {
    metadata.fields[fmt::format("keyence_data_{:03}{}", number, suffix)] = data;
  }
}

double UnitSettings::ResponseSeconds() const {
  // the sampling cycle "default" is the head's: the slowest at most
  return SamplingSeconds().value_or(dl_rs1a::kSamplings_s.back()) * Averages().value_or(0);
}

Findings UnitSettings::Found() const {
  Findings found;
  // moving average: corner (-3 dB) = 0.443 / (averages * sampling cycle)
  if (const auto sampling_s = SamplingSeconds(), averages = std::optional<double>(Averages());
      sampling_s && averages && *averages > 1) {
    found.Note(FindingKind::kAveragingCorner,
               {{"averages", static_cast<int>(*averages)},
                {"sampling_s", *sampling_s},
                {"corner_hz", kMeanCorner / (*averages * *sampling_s)}});
  }
  const auto averaging = Code(dl_rs1a::kAveraging);
  // filters and hold change the displacement: each of them is a doubt
  if (averaging == dl_rs1a::kDifferenceFilter) found.Doubt(FindingKind::kDifferenceFilter);
  if (const auto cutoff = Code(dl_rs1a::kHighPassCutoff);
      averaging == dl_rs1a::kHighPassFilter && cutoff && dl_rs1a::HighPassHz(*cutoff)) {
    found.Doubt(FindingKind::kHighPassFilter, {{"corner_hz", *dl_rs1a::HighPassHz(*cutoff)}});
  }
  if (const auto hold = Code(dl_rs1a::kHold); hold && *hold != 0) {
    found.Doubt(FindingKind::kHold, {{"hold", std::string(dl_rs1a::HoldName(*hold))}});
  }
  // data 033: 0 without an error
  if (const auto flags = Code(dl_rs1a::kErrorFlags); flags && *flags != 0) {
    found.Doubt(FindingKind::kAmplifierError, {{"flags", std::string(Text(dl_rs1a::kErrorFlags))}});
  }
  return found;
}

namespace {

constexpr std::string_view kUnknown = "unknown";

// `code` as the data that were read look: a sign where they have one, and as many digits
std::string DataLike(const std::optional<std::string>& data, int code, const IlTalk& talk) {
  if (!data || data->empty()) return talk.traits().format_number(code);
  const bool is_signed = data->front() == '+' || data->front() == '-';
  const std::size_t digits = data->size() - (is_signed ? 1 : 0);
  return fmt::format("{}{:0{}}", is_signed ? "+" : "", code, digits);
}

// the setting's name, the data as sent where it has no code, or "unknown"
std::string TextOf(int number, const std::optional<std::string>& data) {
  if (!data) return std::string(kUnknown);
  const auto code = dl::NumberOf(*data);
  return code ? il_setting::Describe(number, *code) : *data;
}

// one setting of one amplifier; nothing where it held the code already
Result<std::optional<IlChange>> WriteOne(IlTalk& talk, int unit, const il_setting::Write& write) {
  // read first: what holds the code already is not written
  HAPTOMETER_LET(const auto before, talk.Read(unit, write.number));
  const auto code = before ? dl::NumberOf(*before) : std::nullopt;
  if (code == write.code || (write.only_where && code != write.only_where)) return std::nullopt;
  HAPTOMETER_TRY(talk.Write(unit, write.number, DataLike(before, write.code, talk)));
  // read back: an amplifier may acknowledge a code and keep the old one
  HAPTOMETER_LET(const auto after, talk.Read(unit, write.number));
  if (!after || dl::NumberOf(*after) != write.code) {
    return CannotAnswer(
        talk.name(),
        fmt::format("amplifier {:02} was set to {} = {} but reports {}", unit, write.key,
                    il_setting::Describe(write.number, write.code), TextOf(write.number, after)),
        "set it at the amplifier");
  }
  return IlChange{unit, write.key, TextOf(write.number, before), TextOf(write.number, after)};
}

// an error that names what had been changed before it
std::unexpected<Error> AfterChanges(Error error, const std::vector<IlChange>& changes) {
  for (const IlChange& change : changes) error.what += "; already changed: " + change.Text();
  return std::unexpected(std::move(error));
}

// data 054: 0 while the shift is in progress; without data 054, success is assumed
Result<void> WaitForShift(IlTalk& talk, int unit, Clock& clock) {
  constexpr int kFailed = 2;
  const MonotonicNs deadline = clock.Now() + kNsPerS;
  while (clock.Now() < deadline) {
    HAPTOMETER_LET(const auto result, talk.Read(unit, dl_rs1a::kZeroShiftResult));
    const auto code = result ? dl::NumberOf(*result) : std::nullopt;
    if (code == kFailed) {
      return CannotAnswer(talk.name(),
                          fmt::format("amplifier {:02} could not shift its zero", unit),
                          "bring the target into the range, and measure again");
    }
    if (code != 0) return {};
  }
  // no result within 1 s: success is assumed
  return {};
}

Result<IlChange> ShiftOne(IlTalk& talk, int unit, Clock& clock) {
  HAPTOMETER_LET(const auto before, talk.Read(unit, dl_rs1a::kPresentValue));
  const std::string off = talk.traits().format_number(0);
  // 0, 1, 0: some models act on the edge, some on the level
  for (const std::string& data : {off, talk.traits().format_number(1), off}) {
    auto done = talk.Write(unit, dl_rs1a::kZeroShift, data);
    if (done) continue;
    // an amplifier that acts on the level must not be left shifting: an interruption ends the
    // waiting, and this request still goes out
    Error error = done.error();
    // after an error the request must not remain at 1
    if (data != off && !talk.Write(unit, dl_rs1a::kZeroShift, off)) {
      error.what += fmt::format("; data 001 of amplifier {:02} may still be 1", unit);
    }
    return std::unexpected(std::move(error));
  }
  HAPTOMETER_TRY(WaitForShift(talk, unit, clock));
  // the present value after the shift, as sent
  HAPTOMETER_LET(const auto after, talk.Read(unit, dl_rs1a::kPresentValue));
  return IlChange{unit, "zero", before.value_or(std::string(kUnknown)),
                  after.value_or(std::string(kUnknown))};
}

}  // namespace

std::string AmplifierName(int unit) { return fmt::format("amplifier {:02}", unit); }

std::string IlChange::Text() const {
  return fmt::format("{}: {} {} -> {}", AmplifierName(unit), key, before, after);
}

Result<std::vector<IlChange>> WriteSettings(IlTalk& talk, std::span<const int> units,
                                            std::span<const il_setting::Write> writes) {
  std::vector<IlChange> changes;
  for (const int unit : units) {
    for (const il_setting::Write& write : writes) {
      auto change = WriteOne(talk, unit, write);
      // the first failure ends the writing; changes before it stay and are named
      if (!change) return AfterChanges(change.error(), changes);
      if (*change) changes.push_back(std::move(**change));
    }
  }
  return changes;
}

Result<std::vector<IlChange>> ShiftZeros(IlTalk& talk, std::span<const int> units, Clock& clock) {
  std::vector<IlChange> changes;
  for (const int unit : units) {
    auto change = ShiftOne(talk, unit, clock);
    if (!change) return AfterChanges(change.error(), changes);
    changes.push_back(std::move(*change));
  }
  return changes;
}

Result<bool> WaitUntilValid(IlTalk& talk, MonotonicNs refresh_ns, MonotonicNs longest_ns,
                            Clock& clock) {
  const MonotonicNs deadline = clock.Now() + longest_ns;
  clock.SleepUntil(clock.Now() + refresh_ns);  // until then the unit repeats the old value
  while (clock.Now() < deadline) {
    HAPTOMETER_LET(const auto reply, talk.Ask({}));
    if (!reply || reply->kind != dl::ReplyKind::kM0) continue;
    const auto values = std::span(reply->values).first(reply->units);
    // all amplifiers must show a valid value
    if (std::ranges::find(values, trial::SampleStatus::kInvalid, &Value::status) == values.end()) {
      return true;
    }
  }
  return false;
}

}  // namespace haptometer::acquire
