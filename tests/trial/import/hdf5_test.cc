// HDF5 files of other programs, made here by libhdf5.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/residual.h"
#include "tests/trial/trial_file.h"
#include "trial/export/object_names.h"
#include "trial/hdf5_id.h"
#include "trial/import/hdf5_file.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Repeated(const std::string& text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

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

  // numbers as they lie in a file that another program wrote
  void Stored(const std::string& name, const std::vector<hsize_t>& shape, hid_t type,
              const std::vector<double>& numbers) {
    const Hdf5Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       H5Sclose);
    const Hdf5Id dataset(H5Dcreate2(file_.id(), name.c_str(), type, space.id(), H5P_DEFAULT,
                                    H5P_DEFAULT, H5P_DEFAULT),
                         H5Dclose);
    EXPECT_GE(
        H5Dwrite(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()),
        0);
  }

  // a text of one element, or a vector of `count` equal ones; `is_variable`: of variable length
  void Text(const std::string& name, const std::string& text, hsize_t count = 0,
            bool is_variable = false) {
    const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.id(), is_variable ? H5T_VARIABLE : text.size());
    const Hdf5Id space(count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr),
                       H5Sclose);
    const Hdf5Id dataset(H5Dcreate2(file_.id(), name.c_str(), type.id(), space.id(), H5P_DEFAULT,
                                    H5P_DEFAULT, H5P_DEFAULT),
                         H5Dclose);
    const std::string all = Repeated(text, count == 0 ? 1 : count);
    const std::vector<const char*> pointers(count == 0 ? 1 : count, text.c_str());
    const void* data = is_variable ? static_cast<const void*>(pointers.data()) : all.data();
    EXPECT_GE(H5Dwrite(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data), 0);
  }

  // an attribute of `count` numbers
  void Attribute(const char* object, const char* name, hid_t type, double number,
                 hsize_t count = 1) {
    const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Id attribute(H5Acreate_by_name(file_.id(), object, name, type, space.id(),
                                             H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose);
    const std::vector<double> numbers(count, number);
    EXPECT_GE(H5Awrite(attribute.id(), H5T_NATIVE_DOUBLE, numbers.data()), 0);
  }

  // links to an object that is not there, and to one of another file
  void SoftLink(const char* name) {
    EXPECT_GE(H5Lcreate_soft("/nowhere", file_.id(), name, H5P_DEFAULT, H5P_DEFAULT), 0);
  }
  void ExternalLink(const char* name) {
    EXPECT_GE(H5Lcreate_external("other.h5", "/x", file_.id(), name, H5P_DEFAULT, H5P_DEFAULT), 0);
  }

  // three numbers that lie in another file: beside this one, or in a dataset of another
  void Elsewhere(const char* name, bool is_virtual) {
    const hsize_t rows = 3;
    const Hdf5Id space(H5Screate_simple(1, &rows, nullptr), H5Sclose);
    const Hdf5Id made(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (is_virtual) {
      H5Pset_virtual(made.id(), space.id(), "other.h5", "x", space.id());
    } else {
      H5Pset_external(made.id(), "other.raw", 0, rows * sizeof(double));
    }
    const Hdf5Id dataset(H5Dcreate2(file_.id(), name, H5T_NATIVE_DOUBLE, space.id(), H5P_DEFAULT,
                                    made.id(), H5P_DEFAULT),
                         H5Dclose);
    EXPECT_TRUE(dataset.ok());
  }

  // rows of a text and a number, in one dimension or in two
  void TextsAndNumbers(const char* name, const std::vector<hsize_t>& shape) {
    struct TextRow {
      char text[4];
      double displacement_m;
    };
    const Hdf5Id text(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(text.id(), sizeof(TextRow::text));
    const Hdf5Id type(H5Tcreate(H5T_COMPOUND, sizeof(TextRow)), H5Tclose);
    H5Tinsert(type.id(), "text", HOFFSET(TextRow, text), text.id());
    H5Tinsert(type.id(), "displacement_m", HOFFSET(TextRow, displacement_m), H5T_NATIVE_DOUBLE);
    const std::vector<TextRow> rows{{"a", 1}, {"b", 2}};
    Write(name, shape, type.id(), rows.data());
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
  EXPECT_TRUE(file->Admit(*dataset, 131'073, 0)) << "rows of nothing";
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

TEST(Hdf5Tables, WhatIsNoNumberIsNoColumn) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker maker(path);
    maker.Text("words", "abc", 3);
    maker.SoftLink("dangling");
    maker.Stored("voltage_v", {2}, H5T_NATIVE_INT16, {4, -5});
    maker.TextsAndNumbers("rows", {2});
    maker.TextsAndNumbers("square", {2, 1});
    maker.Stored("none_v", {0}, H5T_NATIVE_DOUBLE, {});
  }
  // a group, a compound dataset
  const Record record = Parsed(path, "", kAtRate);
  ASSERT_EQ(record.channels.size(), 1U);
  EXPECT_THAT(record.channels[0].values, ElementsAre(4, -5));
  const Record rows = Parsed(path, "rows", kAtRate);
  ASSERT_EQ(rows.channels.size(), 1U);
  EXPECT_EQ(rows.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_THAT(rows.channels[0].values, ElementsAre(1, 2));
  for (const char* name : {"words", "square"}) {
    EXPECT_EQ(ErrorOf(path, name),
              fmt::format("{}/{}: is neither a group with columns of numbers nor a dataset of one "
                          "or two dimensions; name another object of the file",
                          path, name));
  }
  EXPECT_THAT(ErrorOf(path, "none_v"), HasSubstr("/none_v: holds 0 rows"));
  EXPECT_THAT(ErrorOf(path, "dangling"), HasSubstr("holds no object 'dangling', but"));
}

// 1005 ns off a grid of 1 s are beyond the millionth of whole numbers (NumberTable)
TEST(Hdf5Tables, WholeNumbersAreExactTimes) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const std::vector<double> times_ns{0, 1e9 + 1005, 2e9};
  for (const bool is_whole : {true, false}) {
    {
      Maker maker(path);
      maker.Stored("time_ns", {3}, is_whole ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE, times_ns);
      maker.Numbers("voltage_v", {3}, {4, 5, 6});
    }
    EXPECT_EQ(Parsed(path, "", {}).raw_times_s.size(), is_whole ? 3U : 0U);
  }
}

TEST(Hdf5Tables, WhatLiesInOtherFilesIsNotRead) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker maker(path);
    maker.ExternalLink("a_link");
    maker.Elsewhere("b_beside", false);
    maker.Elsewhere("c_virtual", true);
    maker.Numbers("voltage_v", {2}, {4, 5});
  }
  for (const char* name : {"a_link", "b_beside", "c_virtual"}) {
    EXPECT_THAT(ErrorOf(path, name),
                HasSubstr(fmt::format("{}/{}: lies in another file, and a recording is one file",
                                      path, name)));
  }
  EXPECT_THAT(ErrorOf(path), HasSubstr("/a_link: lies in another file")) << "as the first column";
  EXPECT_THAT(ErrorOf(path, "x"),
              HasSubstr("but a_link in another file, b_beside in another file, c_virtual in "
                        "another file, the dataset voltage_v (2);"));
  EXPECT_THAT(Parsed(path, "voltage_v", kAtRate).channels.at(0).values, ElementsAre(4, 5));
  {
    Maker maker(path);
  }
  EXPECT_THAT(ErrorOf(path), HasSubstr("it holds nothing; name"));
}

// --- trials --------------------------------------------------------------------------------------

constexpr const char* kDisplacement = "t/displacement_m";

// the objects of a trial of two rows, but for those that `other` makes in their place
struct TrialObjects {
  std::string missing{};
  std::function<void(Maker&)> other = [](Maker&) {};
};

std::string HeaderOfTrial() {
  TrialHeader header;
  header.rate_hz = 4;
  ChannelFormat channel;
  channel.name = "laser";
  channel.role = ChannelRole::kDisplacement;
  channel.unit = "m";
  header.channels.push_back(channel);
  return HeaderToJson(header);
}

void MakeTrial(const std::string& path, const TrialObjects& objects) {
  Maker maker(path);
  maker.Group("t");
  const auto is_made = [&](const std::string& name) { return name != objects.missing; };
  if (is_made("t/header_json")) maker.Text("t/header_json", HeaderOfTrial() + std::string(2, '\0'));
  if (is_made("t/time_s")) maker.Stored("t/time_s", {2}, H5T_NATIVE_DOUBLE, {0, 0.25});
  if (is_made("t/stretches")) {
    maker.Stored("t/stretches", {1, 5}, H5T_NATIVE_DOUBLE, {0, 2, 0, 4, 0});
  }
  if (is_made(kDisplacement)) maker.Stored(kDisplacement, {2}, H5T_NATIVE_DOUBLE, {1, 2});
  if (is_made("t/displacement_m_status")) {
    maker.Stored("t/displacement_m_status", {2}, H5T_NATIVE_UINT8, {0, 1});
  }
  objects.other(maker);
}

TEST(Hdf5Trials, ObjectsHaveTheirTypeAndShape) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  MakeTrial(path, {});
  const auto whole = ReadHdf5(path, "");
  ASSERT_TRUE(whole) << whole.error().Text();
  EXPECT_TRUE(whole->report.is_export);
  EXPECT_FALSE(whole->report.closed);
  EXPECT_THAT(whole->record.channels.at(0).values, ElementsAre(1, 2));
  EXPECT_EQ(whole->record.channels[0].statuses[1], SampleStatus::kRepeated);
  EXPECT_EQ(whole->record.stretches.at(0).rate_hz, 4);
  const auto error_of = [&](const std::string& name, const std::function<void(Maker&)>& other) {
    MakeTrial(path, {.missing = name, .other = other});
    const auto read = ReadHdf5(path, "t");
    return read ? "was read" : read.error().Text();
  };
  const auto stored = [](const char* name, const std::vector<hsize_t>& shape, hid_t type) {
    std::size_t count = 1;
    for (const hsize_t side : shape) count *= side;
    return [=](Maker& maker) { maker.Stored(name, shape, type, std::vector<double>(count)); };
  };
  const auto nothing = [](Maker&) {};
  EXPECT_EQ(
      error_of("t/time_s", nothing),
      path + "/t: its time_s is missing; export the trial again with haptometer trial export");
  EXPECT_EQ(error_of("t/time_s",
                     [](Maker& m) { m.Stored("t/time_s", {2, 1}, H5T_NATIVE_DOUBLE, {0, 0.25}); }),
            "was read");
  for (const hid_t type : {H5T_NATIVE_INT64, H5T_NATIVE_FLOAT}) {
    EXPECT_THAT(error_of("t/time_s", stored("t/time_s", {2}, type)),
                HasSubstr("its time_s holds numbers of another type"));
  }
  for (const hid_t type : {H5T_NATIVE_UINT16, H5T_NATIVE_FLOAT}) {
    EXPECT_THAT(error_of("t/displacement_m_status", stored("t/displacement_m_status", {2}, type)),
                HasSubstr("its displacement_m_status holds numbers of another type"));
  }
  for (const std::vector<hsize_t>& shape : {std::vector<hsize_t>{}, {2, 2}, {1, 2}, {2, 1, 1}}) {
    EXPECT_THAT(error_of("t/time_s", stored("t/time_s", shape, H5T_NATIVE_DOUBLE)),
                HasSubstr("its time_s has another shape"));
  }
  for (const std::vector<hsize_t>& shape : {std::vector<hsize_t>{5}, {5, 1}, {1, 4}, {1, 6}}) {
    EXPECT_THAT(error_of("t/stretches", stored("t/stretches", shape, H5T_NATIVE_DOUBLE)),
                HasSubstr("its stretches has another shape"));
  }
}

TEST(Hdf5Trials, TheHeaderIsOneTextOfFixedLength) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const auto error_of = [&](const std::function<void(Maker&)>& other) {
    MakeTrial(path, {.missing = "t/header_json", .other = other});
    const auto read = ReadHdf5(path, "t");
    return read ? "was read" : read.error().Text();
  };
  const auto text = [](hsize_t count, bool is_variable) {
    return [=](Maker& maker) { maker.Text("t/header_json", HeaderOfTrial(), count, is_variable); };
  };
  EXPECT_EQ(error_of(text(0, false)), "was read");
  for (const auto& other : {text(1, false), text(0, true)}) {
    EXPECT_THAT(error_of(other), HasSubstr("its header_json is not a text of fixed length"));
  }
  EXPECT_THAT(error_of([](Maker& m) { m.Numbers("t/header_json", {}, {0}); }),
              HasSubstr("its header_json is not a text of fixed length"));
  EXPECT_THAT(error_of([](Maker& m) { m.SoftLink("t/header_json"); }),
              HasSubstr("its header_json is missing"));
}

TEST(Hdf5Trials, AFlagIsOneWholeNumberThatIsNotZero) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const auto is_closed = [&](hid_t type, double number, hsize_t count) {
    MakeTrial(path, {.other = [&](Maker& m) { m.Attribute("t", "closed", type, number, count); }});
    const auto read = ReadHdf5(path, "t");
    return read && read->report.closed;
  };
  EXPECT_TRUE(is_closed(H5T_NATIVE_UINT8, 1, 1));
  EXPECT_TRUE(is_closed(H5T_NATIVE_INT32, 2, 1));
  EXPECT_FALSE(is_closed(H5T_NATIVE_UINT8, 0, 1));
  EXPECT_FALSE(is_closed(H5T_NATIVE_UINT8, 1, 2));
  EXPECT_FALSE(is_closed(H5T_NATIVE_DOUBLE, 1, 1));
}

TEST(Hdf5Trials, OneMayHaveNoRows) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  {
    Maker maker(path);
    maker.Group("t");
    maker.Text("t/header_json", HeaderOfTrial());
    for (const char* name : {"t/time_s", kDisplacement}) {
      maker.Stored(name, {0}, H5T_NATIVE_DOUBLE, {});
    }
    maker.Stored("t/stretches", {0, 5}, H5T_NATIVE_DOUBLE, {});
    maker.Stored("t/displacement_m_status", {0}, H5T_NATIVE_UINT8, {});
  }
  const auto read = ReadHdf5(path, "");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(read->record.rows, 0U);
  EXPECT_TRUE(read->record.stretches.empty());
}

}  // namespace
}  // namespace haptometer::trial
