#include "acquire/emulator/dl_en1_unit.h"

#include <utility>

#include "acquire/protocol/keyence/dl_en1.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr int kBaud = 125'000'000;  // 100 Mbit/s as characters of 10 bits

// a datum of an IL amplifier has its own five digits of special values
std::string FormatDataValue(const Value& value) {
  constexpr std::int32_t kMost = 99'999;
  switch (value.status) {
    case trial::SampleStatus::kOver:
      return dl_en1::FormatNumber(kMost);
    case trial::SampleStatus::kUnder:
      return dl_en1::FormatNumber(-kMost);
    case trial::SampleStatus::kDeviceError:
      return dl_en1::FormatNumber(kMost + 1);
    case trial::SampleStatus::kOk:
    case trial::SampleStatus::kRepeated:
      return dl_en1::FormatNumber(value.counts);
    default:
      return dl_en1::FormatNumber(-(kMost - 1));
  }
}

const DlModel& Model() {
  static const DlModel kModel{
      .spelling = dl_en1::Spelling(),
      .first_unit = dl_en1::kFirstUnit,
      .longest_line = dl_en1::kLongestLine,
      .no_such_unit = dl_en1::kUnitNumber,
      .no_such_number = dl_en1::kDataNumber,
      .out_of_range = dl_en1::kOutOfRange,
      .read_only = dl_en1::kWriteProtected,
      .write_locked = dl_en1::kWriteProtected,
      .too_long = dl_en1::kFormat,
      .faulty = dl_en1::kNotExecutable,
      .format_number = [](int number, int /*digits*/) { return dl_en1::FormatNumber(number); },
      .format_data_value = FormatDataValue};
  return kModel;
}

}  // namespace

Result<void> Validate(const DlEn1Setup& setup) {
  if (setup.heads.empty() || setup.heads.size() > dl::kMostUnits) {
    return Usage("--amplifiers", "a DL-EN1 has 1 to 15", "give as many");
  }
  for (const MovingHead& head : setup.heads) {
    if (auto valid = ValidateIlHead(head.head); !valid) return valid;
  }
  return {};
}

DlEn1Unit::DlEn1Unit(DlEn1Setup setup)
    : DlUnit(Model(), kBaud, std::move(setup.heads),
             {.polled_ns = setup.processing_ns,
              .direct_ns = setup.processing_ns,
              .to_all_ns = setup.processing_ns,
              .refresh_ns = setup.refresh_ns},
             setup.is_writable, setup.faults) {}

}  // namespace haptometer::acquire::emulator
