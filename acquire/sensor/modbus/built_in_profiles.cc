// What the makers' manuals say, and no more: a figure that was not at hand is left out.
#include <array>

#include "acquire/sensor/modbus/sensor_profile.h"

namespace haptometer::acquire {
namespace {

// A partly read block is refused ("number of registers must correspond"); 202 with two registers is
// the other request that the manual allows. The distance is NaN once the hold time (800) is over.
SensorProfile BaumerOm20() {
  SensorProfile profile{.name = "baumer-om20",
                        .maker = "Baumer",
                        .model = "OM20/OM30 RS485",
                        .manual = "Baumer OM20/OM30 Modbus RTU manual, p. 14, 22-26, 34"};
  profile.wire.baud = 57600;
  profile.function = 4;
  profile.address = 200;
  profile.count = 13;
  profile.is_exact = true;
  profile.check_address = 202;
  profile.check_count = 2;
  profile.value_address = 202;
  profile.type = RegisterType::kF32;
  profile.order = WordOrder::kCdab;
  profile.status_address = 201;
  profile.status_mask = 0x0002;     // alarm; bit 0 is the switching output
  profile.timestamp_address = 209;  // seconds and microseconds, two registers each
  profile.timestamp_count = 4;
  return profile;
}

// One firmware family. D is 16384 at the end of the range S, which stands in register 5 in mm.
// Whether the printed numbers count from 0 or 1 the manual does not settle.
SensorProfile Triangulator(std::string name, std::string maker, std::string model,
                           std::string manual) {
  SensorProfile profile{.name = std::move(name),
                        .maker = std::move(maker),
                        .model = std::move(model),
                        .manual = std::move(manual),
                        .advice =
                            "set its protocol to Modbus RTU first (parameter 39 = 2; it is "
                            "delivered with the maker's own), and where it answers with an "
                            "exception write a profile with address_base = 1"};
  profile.fastest_rate_hz = 200;  // sampling period as delivered, 5 ms
  profile.function = 4;
  profile.address = 6;
  profile.count = 1;
  profile.check_address = 5;
  profile.check_count = 2;
  profile.value_address = 6;
  profile.scale = 1.0 / 16384;
  profile.scale_address = 5;
  profile.invalid_bits = {0};  // no target; likely, not printed
  profile.most_number = 16384;
  return profile;
}

// Where the strength is below its threshold the sensor gives a configured distance; 4500 cm is the
// manual's example. Times of the reading stand at 3 and 4, behind a register that is not described.
SensorProfile BenewakeTf() {
  SensorProfile profile{.name = "benewake-tf-i",
                        .maker = "Benewake",
                        .model = "TF02-i/TFmini-i RS-485",
                        .manual = "Benewake TF02-i RS-485 manual, p. 9-11"};
  profile.fastest_rate_hz = 100;  // as delivered
  profile.wire.baud = 115200;
  profile.wire.parity = Parity::kNone;
  profile.count = 2;  // distance, strength
  profile.check_address = 0;
  profile.check_count = 1;
  profile.unit_m = 1e-2;
  profile.resolution_m = 1e-2;
  profile.invalid_bits = {4500};
  return profile;
}

SensorProfile Wt53r() {
  SensorProfile profile{.name = "wt53r",
                        .maker = "WIT-motion, DFRobot",
                        .model = "WT53R-485 (SEN0491, SEN0492)",
                        .manual = "WIT-motion WT53R manual, p. 24-25; DFRobot wiki, SEN0492"};
  profile.wire.baud = 115200;
  profile.wire.parity = Parity::kNone;
  profile.wire.slave = 0x50;
  profile.address = 0x34;
  profile.value_address = 0x34;
  profile.resolution_m = 1e-3;
  return profile;
}

}  // namespace

std::span<const SensorProfile> BuiltInProfiles() {
  static const std::array kProfiles{
      BaumerOm20(),
      Triangulator("riftek-rf602", "RIFTEK", "RF602", "RIFTEK RF602 manual, p. 11-19"),
      Triangulator("acuity-ar100", "Acuity (Schmitt)", "AR100", "Acuity AR100 manual, p. 22-23"),
      BenewakeTf(), Wt53r()};
  return kProfiles;
}

}  // namespace haptometer::acquire
