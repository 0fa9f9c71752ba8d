// What is said of a sensor's options before anything is touched.
#include "tools/acquire/sensor_options.h"

#include <gtest/gtest.h>

#include <string>

namespace haptometer::tools {
namespace {

SensorOptions On(const std::string& sensor) {
  SensorOptions wanted;
  wanted.port = "port";
  wanted.sensor = sensor;
  return wanted;
}

std::string Complaint(const SensorOptions& wanted) {
  const auto checked = CheckSensor(wanted);
  if (checked) return "";
  EXPECT_EQ(checked.error().cause, Cause::kUsage);
  return checked.error().Text();
}

TEST(SensorOptions, OfEverySensorAreFineWithoutMore) {
  for (const char* sensor : {"keyence-en1", "keyence-il", "keyence-lkg", "replay", "stream"}) {
    EXPECT_EQ(Complaint(On(sensor)), "") << sensor;
  }
}

TEST(SensorOptions, OfAnIlAreReadBeforeThePortIsOpened) {
  SensorOptions wanted = On("keyence-il");
  wanted.settings = {"sampling=0.33ms", "averaging=7"};
  EXPECT_EQ(Complaint(wanted),
            "<set>: an IL amplifier has no averaging '7'; use one of 1, 2, 4, 8, 16, 32, 64, 128, "
            "256, 512, 1024, 2048, 4096, difference, high-pass");
  wanted.settings = {"averaging=8"};
  EXPECT_EQ(Complaint(wanted), "");
  wanted.command = "m2";
  EXPECT_EQ(Complaint(wanted),
            "--command: m2 is a command of the LK-G series; use m0, or ms to record the outputs "
            "too");
  wanted.command = "ms";
  EXPECT_EQ(Complaint(wanted), "");
  wanted.baud = 115200;
  EXPECT_EQ(Complaint(wanted),
            "--baud: a DL-RS1A has no 115200 baud; use 2400, 4800, 9600, 19200 or 38400");
}

TEST(SensorOptions, AveragingIsStatedOfWhatDoesNotReportIt) {
  SensorOptions stream = On("stream");
  stream.averages = 1;
  EXPECT_EQ(Complaint(stream), "");
  stream.averages = 16;
  EXPECT_EQ(Complaint(stream),
            "--sampling: is missing: the period of the samples that are averaged; give it, e.g. "
            "--sampling 1ms");
  stream.sampling_s = 1e-3;
  EXPECT_EQ(Complaint(stream), "");
  SensorOptions il = On("keyence-il");
  il.averages = 1;
  EXPECT_EQ(Complaint(il),
            "--averaging: is for a stream and for samples; leave it out: other sensors report it, "
            "or state it in their file");
}

TEST(SensorOptions, OfAnotherSensorAreNotIgnored) {
  SensorOptions lkg = On("keyence-lkg");
  lkg.command = "ms";
  EXPECT_EQ(Complaint(lkg),
            "--command: ms is a command of the IL series; use m1, m2 or m0 (both outputs)");
  lkg.command = "m2";
  lkg.decimals = 4;
  EXPECT_EQ(Complaint(lkg), "");
  lkg.device_zero = true;
  EXPECT_EQ(Complaint(lkg), "--device-zero: is for the amplifiers of the IL series; leave it out");

  SensorOptions stream = On("stream");
  stream.rate_hz = 50;
  EXPECT_EQ(
      Complaint(stream),
      "--rate: is for samples, and for polled sensors: the others have their own; leave it out");
  stream = On("stream");
  stream.settings = {"averaging=8"};
  EXPECT_EQ(Complaint(stream), "--set: is for the amplifiers of the IL series; leave it out");
  stream = On("stream");
  stream.command = "ms";
  EXPECT_EQ(Complaint(stream),
            "--command: is for keyence-en1, keyence-il and keyence-lkg; leave it out");
}

TEST(SensorOptions, ForAReconnectionChangeNothing) {
  SensorOptions wanted = On("keyence-il");
  wanted.settings = {"averaging=8"};
  wanted.device_zero = true;
  wanted.command = "ms";
  const SensorOptions again = WithoutChanges(wanted);
  EXPECT_TRUE(again.settings.empty());
  EXPECT_FALSE(again.device_zero);
  EXPECT_EQ(again.command, "ms");
}

}  // namespace
}  // namespace haptometer::tools
