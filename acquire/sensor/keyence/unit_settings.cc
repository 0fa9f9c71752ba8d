#include "acquire/sensor/keyence/unit_settings.h"

#include <fmt/core.h>

#include "acquire/protocol/keyence/dl_line.h"

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
  return SamplingSeconds().value_or(0) * Averages().value_or(0);
}

std::vector<std::string> UnitSettings::Remarks() const {
  std::vector<std::string> remarks;
  if (const auto sampling_s = SamplingSeconds(), averages = std::optional<double>(Averages());
      sampling_s && averages && *averages > 1) {
    remarks.push_back(fmt::format(
        "the amplifier averages {} samples of {:g} ms: a vibration at {:.1f} Hz is 3 dB too small",
        *averages, *sampling_s * 1e3, kMeanCorner / (*averages * *sampling_s)));
  }
  const auto averaging = Code(dl_rs1a::kAveraging);
  if (averaging == dl_rs1a::kDifferenceFilter) {
    remarks.emplace_back(
        "the amplifier's difference-count filter is on: small steps are swallowed");
  }
  if (const auto cutoff = Code(dl_rs1a::kHighPassCutoff);
      averaging == dl_rs1a::kHighPassFilter && cutoff && dl_rs1a::HighPassHz(*cutoff)) {
    remarks.push_back(fmt::format("the amplifier's high-pass filter at {:g} Hz is on",
                                  *dl_rs1a::HighPassHz(*cutoff)));
  }
  if (const auto hold = Code(dl_rs1a::kHold); hold && *hold != 0) {
    remarks.push_back(fmt::format("the amplifier holds ({}): readings are not the displacement now",
                                  dl_rs1a::HoldName(*hold)));
  }
  if (const auto flags = Code(dl_rs1a::kErrorFlags); flags && *flags != 0) {
    remarks.push_back(
        fmt::format("the amplifier reports an error (flags {})", Text(dl_rs1a::kErrorFlags)));
  }
  return remarks;
}

}  // namespace haptometer::acquire
