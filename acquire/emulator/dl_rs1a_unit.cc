#include "acquire/emulator/dl_rs1a_unit.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr MonotonicNs kToAllNs = 57'000'000;  // T4 of AW

const DlModel& Model() {
  static const DlModel kModel{
      .spelling = dl_rs1a::Spelling(),
      .first_unit = 0,
      .longest_line = dl_rs1a::kLongestLine,
      .no_such_unit = dl_rs1a::kUnitNumber,
      .no_such_number = dl_rs1a::kParameter,
      .out_of_range = dl_rs1a::kParameter,
      .read_only = dl_rs1a::kParameter,
      .write_locked = dl_rs1a::kWriteControl,
      .too_long = dl_rs1a::kDataLength,
      .faulty = dl_rs1a::kCommunication,
      .format_number = [](int number, int digits) { return fmt::format("{:0{}}", number, digits); },
      .format_data_value = dl_rs1a::FormatValue};
  return kModel;
}

std::vector<MovingHead> AllHeads(const DlRs1aSetup& setup) {
  std::vector<MovingHead> heads{setup.head};
  heads.insert(heads.end(), setup.expansions.begin(), setup.expansions.end());
  return heads;
}

}  // namespace

Result<void> Validate(const DlRs1aSetup& setup) {
  if (std::ranges::find(dl_rs1a::kBauds, setup.baud) == dl_rs1a::kBauds.end()) {
    return Usage("--baud", fmt::format("a DL-RS1A has no {} baud", setup.baud),
                 fmt::format("give one of {}", fmt::join(dl_rs1a::kBauds, ", ")));
  }
  if (setup.expansions.size() >= dl_rs1a::kMostUnits) {
    return Usage("--amplifiers", "a DL-RS1A has no more than 15", "give 1 to 15");
  }
  for (const MovingHead& head : setup.expansions) {
    if (auto valid = ValidateIlHead(head.head); !valid) return valid;
  }
  return ValidateIlHead(setup.head.head);
}

DlRs1aUnit::DlRs1aUnit(const DlRs1aSetup& setup)
    : DlUnit(Model(), setup.baud, AllHeads(setup),
             {.polled_ns = setup.processing_ns,
              .direct_ns = setup.direct_processing_ns,
              .to_all_ns = kToAllNs,
              .refresh_ns = setup.refresh_ns},
             setup.is_writable, setup.faults) {
  HAPTOMETER_CHECK(Validate(setup).has_value(), "{}", Validate(setup).error().Text());
}

}  // namespace haptometer::acquire::emulator
