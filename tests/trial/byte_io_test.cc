// The oracle is zlib, and the check value that every catalogue of CRCs has.
#include "trial/byte_io.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <vector>

#include "trial/block.h"

namespace haptometer::trial {
namespace {

std::uint32_t ByZlib(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

TEST(Crc32, OfTheNineDigits) { EXPECT_EQ(Crc32(BytesOfText("123456789")), 0xcbf4'3926U); }

TEST(Crc32, IsZlibsForEveryLengthAndPlace) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(1000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  for (std::size_t size = 0; size <= 800; ++size) {
    for (const std::size_t first : {0U, 1U, 7U, 16U, 33U}) {
      const auto part = std::span(bytes).subspan(first, size);
      EXPECT_EQ(Crc32(part), ByZlib(part)) << size << " from " << first;
    }
  }
}

TEST(Crc32, IsZlibsForZerosOnesAndSingleBits) {
  for (const std::size_t size : {64U, 100U, 128U, 65'536U, 1'000'003U}) {
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(Crc32(bytes), ByZlib(bytes)) << size;
    bytes[size / 3] = std::byte{0x10};
    EXPECT_EQ(Crc32(bytes), ByZlib(bytes)) << size;
    bytes.assign(size, std::byte{0xff});
    EXPECT_EQ(Crc32(bytes), ByZlib(bytes)) << size;
  }
}

}  // namespace
}  // namespace haptometer::trial
