// The number of all nines is none: a line cannot hold more.
#include <gtest/gtest.h>

#include "acquire/protocol/stream_line.h"

namespace haptometer::acquire {
namespace {

using trial::SampleStatus;

TEST(StreamLine, AllNinesAreOverOrUnder) {
  const StreamFormat millimetres = ParseStreamFormat("+00.0000,mm,CR").value();
  EXPECT_EQ(ParseStreamLine(millimetres, "+99.9999"), (Value{999'999, 4, SampleStatus::kOver}));
  EXPECT_EQ(ParseStreamLine(millimetres, "-99.9999"), (Value{-999'999, 4, SampleStatus::kUnder}));
  EXPECT_EQ(ParseStreamLine(millimetres, "+99.9998"), (Value{999'998, 4, SampleStatus::kOk}));
  EXPECT_EQ(ParseStreamLine(millimetres, "-99.9998"), (Value{-999'998, 4, SampleStatus::kOk}));
  const StreamFormat numbered = ParseStreamFormat("000,000000,0.1um,LF").value();
  EXPECT_EQ(ParseStreamLine(numbered, "999,999999"), (Value{999'999, 0, SampleStatus::kOver}));
  EXPECT_EQ(ParseStreamLine(numbered, "999,000000"), (Value{0, 0, SampleStatus::kOk}));
}

}  // namespace
}  // namespace haptometer::acquire
