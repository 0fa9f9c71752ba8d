// HDF5 files of other programs, made here by libhdf5.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/residual.h"
#include "tests/trial/trial_file.h"
#include "trial/export/object_names.h"
#include "trial/hdf5_id.h"
#include "trial/import/hdf5_file.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// a file that is being made
class Maker {
 public:
  explicit Maker(const std::string& path)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {}

  void Group(const char* name) {
    const Hdf5Id group(H5Gcreate2(file_.id(), name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                       H5Gclose);
    EXPECT_TRUE(group.ok());
  }

  void Numbers(const char* name, const std::vector<hsize_t>& shape,
               const std::vector<double>& numbers) {
    Write(name, shape, H5T_NATIVE_DOUBLE, numbers.data());
  }

  // `count` numbers of a byte, of which the first alone takes room in the file
  void FirstOf(const char* name, hsize_t count) {
    const hsize_t one = 1;
    const hsize_t first = 0;
    const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Id part(H5Screate_simple(1, &one, nullptr), H5Sclose);
    H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, &first, nullptr, &one, nullptr);
    const Hdf5Id made(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(made.id(), 1, &one);
    const Hdf5Id dataset(H5Dcreate2(file_.id(), name, H5T_NATIVE_UINT8, space.id(), H5P_DEFAULT,
                                    made.id(), H5P_DEFAULT),
                         H5Dclose);
    const unsigned char number = 7;
    EXPECT_GE(H5Dwrite(dataset.id(), H5T_NATIVE_UINT8, part.id(), space.id(), H5P_DEFAULT, &number),
              0);
  }

  // rows of a whole number and a double
  struct Row {
    int time_ms;
    double displacement_m;
  };
  void Rows(const char* name, const std::vector<Row>& rows) {
    const Hdf5Id type(H5Tcreate(H5T_COMPOUND, sizeof(Row)), H5Tclose);
    H5Tinsert(type.id(), "time_ms", HOFFSET(Row, time_ms), H5T_NATIVE_INT);
    H5Tinsert(type.id(), "displacement_m", HOFFSET(Row, displacement_m), H5T_NATIVE_DOUBLE);
    Write(name, {rows.size()}, type.id(), rows.data());
  }

 private:
  void Write(const char* name, const std::vector<hsize_t>& shape, hid_t type, const void* data) {
    const Hdf5Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       H5Sclose);
    const Hdf5Id dataset(
        H5Dcreate2(file_.id(), name, type, space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose);
    EXPECT_GE(H5Dwrite(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), 0);
  }

  Hdf5Id file_;
};

const ImportOptions kAtRate{.rate_hz = 10.0};

Record Parsed(const std::string& path, const std::string& name, const ImportOptions& options) {
  auto recording = ReadHdf5(path, name, options);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(recording->record) : Record{};
}

std::string ErrorOf(const std::string& path, const std::string& name = "") {
  const auto recording = ReadHdf5(path, name, kAtRate);
  return recording ? "was read" : recording.error().Text();
}

TEST(Hdf5Tables, TheLastPartOfADatasetsPathNamesItsColumn) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker maker(path);
    maker.Group("run");
    maker.Numbers("run/displacement_mm", {3}, {1, 2, 3});
    maker.Numbers("voltage_v", {3, 1}, {4, 5, 6});
  }
  const Record inner = Parsed(path, "run/displacement_mm", kAtRate);
  ASSERT_EQ(inner.channels.size(), 1U);
  EXPECT_EQ(inner.channels[0].name, "displacement");
  EXPECT_EQ(inner.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_THAT(inner.channels[0].values, ElementsAre(1e-3, 2e-3, 3e-3));
  EXPECT_EQ(Parsed(path, "voltage_v", kAtRate).channels.at(0).role, ChannelRole::kVoltage);
}

TEST(Hdf5Tables, AMatrixStandsByRows) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker(path).Numbers("m", {2, 3}, {0, 1, 2, 10, 11, 12});
  }
  const Record record = Parsed(path, "m", {.columns = {"a", "b", "c"}, .rate_hz = 10.0});
  ASSERT_EQ(record.channels.size(), 3U);
  EXPECT_THAT(record.channels[1].values, ElementsAre(1, 11));
}

// each of 2^28 numbers: as many as the fields that there are, times the rows
TEST(Hdf5Tables, ACompoundDatasetCountsItsOwnFields) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  constexpr int kRows = 70'000;
  {
    std::vector<Maker::Row> rows;
    for (int i = 0; i < kRows; ++i) rows.push_back({2 * i, i % 7 - 3.5});
    Maker(path).Rows("rows", rows);
  }
  const Record record = Parsed(path, "rows", {});
  EXPECT_EQ(record.rows, 70'000U);
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_EQ(record.channels[0].values[6], 2.5);
  EXPECT_REL(record.stretches.at(0).rate_hz, 500, 1e-12, "whole milliseconds over 140 s");
}

TEST(Hdf5Tables, WhatAFileHoldsIsSaidWithItsShape) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker maker(path);
    maker.Numbers("a_cube", {2, 3, 4}, std::vector<double>(24));
    maker.Group("b_group");
    maker.Numbers("c_matrix", {5, 2}, std::vector<double>(10));
    maker.Numbers("d_one", {}, {1});
  }
  constexpr const char* kObjects =
      "the dataset a_cube (2 x 3 x 4), the group b_group, the dataset c_matrix (5 x 2), the "
      "dataset d_one ()";
  EXPECT_THAT(ErrorOf(path), HasSubstr(fmt::format("it holds {}; name a dataset", kObjects)));
  EXPECT_THAT(ErrorOf(path, "other"),
              HasSubstr(fmt::format("holds no object 'other', but {}; name", kObjects)));
  {
    Maker(path).Group("alone");
  }
  EXPECT_THAT(ErrorOf(path), HasSubstr("it holds the group alone; name"));
  {
    Maker maker(path);
    for (const char* name : {"a", "b", "c", "d", "e"}) maker.Group(name);
  }
  EXPECT_THAT(ErrorOf(path), HasSubstr("the group c, the group d and more;"));
}

TEST(Hdf5Tables, ObjectsOfLongerNamesThan1023BytesAreIgnored) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const auto error_of = [&](std::size_t length) {
    {
      Maker maker(path);
      maker.Numbers("a_cube", {2, 3, 4}, std::vector<double>(24));
      maker.Group(std::string(length, 'v').c_str());
    }
    return ErrorOf(path);
  };
  EXPECT_THAT(error_of(1023), HasSubstr("(2 x 3 x 4), the group " + std::string(1023, 'v') + ";"));
  EXPECT_THAT(error_of(1024), HasSubstr("it holds the dataset a_cube (2 x 3 x 4); name"));
}

// a group that holds a header is a trial's
TEST(Hdf5Tables, TheFirstEightOfSeveralTrialsAreNamed) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const auto error_of = [&path](int trials) {
    {
      Maker maker(path);
      for (int i = 1; i <= trials; ++i) {
        const std::string name = fmt::format("t{}", i);
        maker.Group(name.c_str());
        maker.Numbers(fmt::format("{}/{}", name, objects::kHeader).c_str(), {1}, {0});
      }
    }
    return ErrorOf(path);
  };
  constexpr const char* kEight = "t1, t2, t3, t4, t5, t6, t7, t8";
  EXPECT_EQ(error_of(8), fmt::format("{0}: holds 8 trials: {1}; name one as {0}/t1", path, kEight));
  EXPECT_EQ(error_of(9),
            fmt::format("{0}: holds 9 trials: {1}, ...; name one as {0}/t1", path, kEight));
}

// no filter packs more than 2^17 numbers into a byte
TEST(Hdf5Tables, NumbersThatTheFileCannotHoldAreRefused) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker(path).FirstOf("bytes", 131'073);
  }
  auto file = Hdf5File::Open(path);
  ASSERT_TRUE(file);
  const auto dataset = file->Open(file->root(), "bytes");
  ASSERT_TRUE(dataset);
  EXPECT_TRUE(file->Admit(*dataset, 131'072, 1));
  EXPECT_TRUE(file->Admit(*dataset, 65'536, 2));
  const auto refused = file->Admit(*dataset, 131'073, 1);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(),
              HasSubstr("/bytes: states 131073 numbers and holds 1 bytes of them"));
}

// 2^28 numbers of one file, over all of its objects
TEST(Hdf5Tables, NumbersOfAllObjectsAreCounted) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker(path).Numbers("n", {2048}, std::vector<double>(2048));
  }
  auto file = Hdf5File::Open(path);
  ASSERT_TRUE(file);
  const auto dataset = file->Open(file->root(), "n");
  ASSERT_TRUE(dataset);
  constexpr std::uint64_t kMost = std::uint64_t{1} << 28U;
  EXPECT_FALSE(file->Admit(*dataset, kMost + 1, 1));
  EXPECT_FALSE(file->Admit(*dataset, kMost / 2, 3));
  ASSERT_TRUE(file->Admit(*dataset, kMost / 4 - 1, 4));
  EXPECT_TRUE(file->Admit(*dataset, 1, 4));
  const auto refused = file->Admit(*dataset, 1, 1);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("/n: has more numbers than are read of one file"));
}

TEST(Hdf5Tables, TheLongestDatasetsOfAGroupAreItsColumns) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker maker(path);
    maker.Numbers("fs", {1}, {8000});
    maker.Numbers("matrix", {4, 4}, std::vector<double>(16));
    maker.Numbers("time_s", {3}, {0, 0.25, 0.5});
    maker.Numbers("voltage_v", {3}, {4, 5, 6});
  }
  const Record record = Parsed(path, "", {});
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_THAT(record.channels[0].values, ElementsAre(4, 5, 6));
  EXPECT_EQ(record.stretches.at(0).rate_hz, 4);
}

}  // namespace
}  // namespace haptometer::trial
