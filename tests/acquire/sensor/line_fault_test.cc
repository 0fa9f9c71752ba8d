// Every fault of the emulators against every line protocol: the status that a reading gets, and
// that the readings after it are sound and its own. Sensor and emulator in one thread on a manual
// clock.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/lkg_unit.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/sensor/keyence/keyence_lkg.h"
#include "tests/acquire/device_transport.h"
#include "tests/acquire/il_series_emulated.h"

namespace haptometer::acquire {
namespace {

using emulator::FaultPlan;
using emulator::StillHead;
using trial::SampleStatus;

struct Maker {
  std::string name;
  std::unique_ptr<emulator::Device> (*device)(FaultPlan faults);
  std::unique_ptr<Sensor> (*sensor)(std::unique_ptr<Transport> transport, Clock& clock);
  std::int32_t counts;  // of the still target
};

const Maker kMakers[] = {
    {"DlRs1a",
     [](FaultPlan faults) -> std::unique_ptr<emulator::Device> {
       return std::make_unique<emulator::DlRs1aUnit>(
           emulator::DlRs1aSetup{.baud = 38400, .head = StillHead(1.234e-3), .faults = faults});
     },
     [](std::unique_ptr<Transport> transport, Clock& clock) -> std::unique_ptr<Sensor> {
       return std::make_unique<KeyenceIl>(std::move(transport), KeyenceIlSetup{.baud = 38400},
                                          clock);
     },
     1234},
    {"DlEn1",
     [](FaultPlan faults) -> std::unique_ptr<emulator::Device> {
       return std::make_unique<emulator::DlEn1Unit>(
           emulator::DlEn1Setup{.heads = {StillHead(1.234e-3)}, .faults = faults});
     },
     [](std::unique_ptr<Transport> transport, Clock& clock) -> std::unique_ptr<Sensor> {
       return std::make_unique<KeyenceIl>(std::move(transport),
                                          KeyenceIlSetup{.unit = IlUnit::kDlEn1}, clock);
     },
     1234},
    {"Lkg",
     [](FaultPlan faults) -> std::unique_ptr<emulator::Device> {
       return std::make_unique<emulator::LkgUnit>(
           emulator::LkgSetup{.heads = {StillHead(1.234e-3)}, .faults = faults});
     },
     [](std::unique_ptr<Transport> transport, Clock& clock) -> std::unique_ptr<Sensor> {
       return std::make_unique<KeyenceLkg>(std::move(transport), KeyenceLkgSetup{}, clock);
     },
     12340}};

struct Strike {
  std::string fault;
  std::optional<SampleStatus> status;  // of the readings that it strikes; empty: none is lost
};

const Strike kStrikes[] = {{"silent", SampleStatus::kLate},
                           {"slow", SampleStatus::kLate},
                           {"late", SampleStatus::kLate},
                           {"byte-gap", SampleStatus::kBadFrame},
                           {"truncate", SampleStatus::kBadFrame},
                           {"garbage", SampleStatus::kBadFrame},
                           {"merged", SampleStatus::kLate},
                           {"error", SampleStatus::kDeviceError},
                           {"error-22", SampleStatus::kDeviceError},
                           {"invalid", SampleStatus::kInvalid},
                           {"over", SampleStatus::kOver},
                           {"under", SampleStatus::kUnder}};

using Case = std::tuple<Maker, Strike>;

class LineFaults : public ::testing::TestWithParam<Case> {
 protected:
  // started, and known well enough that its deadline is 50 ms
  void Start(const std::string& plan) {
    const auto& [maker, strike] = GetParam();
    device_ = maker.device(*emulator::ParseFaultPlan(plan));
    sensor_ = maker.sensor(std::make_unique<tests::DeviceTransport>(*device_, clock_), clock_);
    const auto started = sensor_->Start(stop_);
    ASSERT_TRUE(started) << started.error().Text();
    (void)sensor_->Begin();
  }

  std::optional<Reading> NextRow() {
    Reading reading;
    for (int call = 0; call < 10'000; ++call) {
      const Outcome outcome = sensor_->Next(reading);
      if (outcome == Outcome::kReading) return reading;
      if (outcome == Outcome::kGone) return std::nullopt;
    }
    ADD_FAILURE() << "no row";
    return std::nullopt;
  }

  const std::atomic<bool> stop_{false};
  ManualClock clock_;
  std::unique_ptr<emulator::Device> device_;
  std::unique_ptr<Sensor> sensor_;
};

TEST_P(LineFaults, GiveTheirStatusAndSpoilNoOther) {
  const auto& [maker, strike] = GetParam();
  Start(strike.fault + ":100");
  int struck = 0;
  int sound = 0;
  for (int row = 0; row < 500; ++row) {
    const auto reading = NextRow();
    ASSERT_TRUE(reading);
    if (IsMeasurement(RowStatus(*reading))) {
      ++sound;
      EXPECT_EQ(static_cast<std::int32_t>(reading->samples[0].raw.bits()), maker.counts);
    } else {
      ++struck;
      EXPECT_EQ(Name(RowStatus(*reading)), Name(*strike.status)) << row;
    }
  }
  // every hundredth answer, of which the step after a strike is one too
  EXPECT_GE(struck, 4);
  EXPECT_LE(struck, 6);
  EXPECT_EQ(struck + sound, 500);
}

std::string CaseName(const ::testing::TestParamInfo<Case>& made) {
  std::string name = std::get<0>(made.param).name + "_" + std::get<1>(made.param).fault;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Makers, LineFaults,
                         ::testing::Combine(::testing::ValuesIn(kMakers),
                                            ::testing::ValuesIn(kStrikes)),
                         CaseName);

// the faults whose effect differs between the makers

class LineFaultsByMaker : public LineFaults {};

TEST_P(LineFaultsByMaker, AnotherAmplifiersAnswerIsNoReading) {
  Start("wrong-id:100");
  int bad_frames = 0;
  for (int row = 0; row < 500; ++row) {
    const auto reading = NextRow();
    ASSERT_TRUE(reading);
    if (RowStatus(*reading) == SampleStatus::kBadFrame) ++bad_frames;
    // an LK-G answers for its other output: a line that was asked by nobody, and then silence
    const bool is_lost = RowStatus(*reading) == SampleStatus::kLate;
    if (is_lost) ++bad_frames;
  }
  EXPECT_GE(bad_frames, 4);
  EXPECT_LE(bad_frames, 6);
}

TEST_P(LineFaultsByMaker, ABrokenAmplifierIsADeviceError) {
  // an LK-G has no value of its own for that: it shows none
  const bool is_lkg = std::get<0>(GetParam()).name == "Lkg";
  const SampleStatus status = is_lkg ? SampleStatus::kInvalid : SampleStatus::kDeviceError;
  Start("amplifier-error:100");
  int struck = 0;
  for (int row = 0; row < 200; ++row) {
    struck += RowStatus(NextRow().value()) == status ? 1 : 0;
  }
  EXPECT_EQ(struck, 2);
}

TEST_P(LineFaultsByMaker, AHangUpEndsIt) {
  Start("disconnect:100");
  int rows = 0;
  while (NextRow()) ++rows;
  EXPECT_GE(rows, 80);  // some of the hundred answers were the start's
  EXPECT_LT(rows, 100);
}

INSTANTIATE_TEST_SUITE_P(Makers, LineFaultsByMaker,
                         ::testing::Combine(::testing::ValuesIn(kMakers),
                                            ::testing::Values(Strike{})),
                         [](const ::testing::TestParamInfo<Case>& made) {
                           return std::get<0>(made.param).name;
                         });

}  // namespace
}  // namespace haptometer::acquire
