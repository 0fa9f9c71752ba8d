#include "trial/import/hdf5_table.h"

#include <fmt/core.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trial/import/exported_trial.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

bool IsNumber(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_FLOAT || kind == H5T_INTEGER;
}

// an open dataset with its type and shape
struct Dataset {
  Hdf5Id id;
  Hdf5Id type;
  std::array<hsize_t, 2> shape{0, 1};  // a vector is a matrix of one column
  int rank = 0;

  [[nodiscard]] std::size_t numbers() const { return shape[0] * shape[1]; }
};

// the dataset `name` of `place`, of one or two dimensions and no more than kMostNumbers
std::optional<Dataset> OpenDataset(const Hdf5Id& place, const std::string& name) {
  H5O_info_t object{};
  if (H5Oget_info_by_name(place.id(), name.c_str(), &object, H5P_DEFAULT) < 0 ||
      object.type != H5O_TYPE_DATASET) {
    return std::nullopt;
  }
  Hdf5Id id(H5Dopen2(place.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!id.ok()) return std::nullopt;
  Hdf5Id type(H5Dget_type(id.id()), H5Tclose);
  Dataset dataset{.id = std::move(id), .type = std::move(type)};
  const Hdf5Id space(H5Dget_space(dataset.id.id()), H5Sclose);
  dataset.rank = H5Sget_simple_extent_ndims(space.id());
  if (dataset.rank < 1 || dataset.rank > 2 ||
      H5Sget_simple_extent_dims(space.id(), dataset.shape.data(), nullptr) < 0) {
    return std::nullopt;
  }
  const bool is_short =
      dataset.shape[0] <= kMostNumbers &&
      (dataset.shape[0] == 0 || dataset.shape[1] <= kMostNumbers / dataset.shape[0]);
  return is_short ? std::optional(std::move(dataset)) : std::nullopt;
}

// all numbers of a dataset by `memory`, a type of one double; nothing where they cannot be read
std::optional<std::vector<double>> NumbersOf(const Dataset& dataset, hid_t memory) {
  std::vector<double> numbers(dataset.numbers());
  if (!numbers.empty() &&
      H5Dread(dataset.id.id(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) {
    return std::nullopt;
  }
  return numbers;
}

// a name that libhdf5 gives to the caller
std::string OwnedName(char* name) {
  std::string copy = name == nullptr ? "" : name;
  H5free_memory(name);
  return copy;
}

// the fields of a compound dataset that are numbers, a column each
std::vector<NumberColumn> FieldsOf(const Dataset& dataset) {
  std::vector<NumberColumn> columns;
  const int count = std::min(H5Tget_nmembers(dataset.type.id()), static_cast<int>(kMostColumns));
  for (int i = 0; i < count; ++i) {
    const auto member = static_cast<unsigned>(i);
    const Hdf5Id type(H5Tget_member_type(dataset.type.id(), member), H5Tclose);
    if (!IsNumber(type.id())) continue;
    NumberColumn column{.name = OwnedName(H5Tget_member_name(dataset.type.id(), member)),
                        .is_count = H5Tget_class(type.id()) == H5T_INTEGER};
    // a compound of this field alone, as a double
    const Hdf5Id memory(H5Tcreate(H5T_COMPOUND, sizeof(double)), H5Tclose);
    H5Tinsert(memory.id(), column.name.c_str(), 0, H5T_NATIVE_DOUBLE);
    auto numbers = NumbersOf(dataset, memory.id());
    if (!numbers) continue;
    column.values = std::move(*numbers);
    columns.push_back(std::move(column));
  }
  return columns;
}

// names of the links in a group, in the order of the names
std::vector<std::string> LinksIn(const Hdf5Id& group) {
  std::vector<std::string> names;
  H5G_info_t info{};
  if (H5Gget_info(group.id(), &info) < 0) return names;
  for (hsize_t i = 0; i < std::min<hsize_t>(info.nlinks, kMostColumns); ++i) {
    std::array<char, 1024> name{};
    const auto length = H5Lget_name_by_idx(group.id(), ".", H5_INDEX_NAME, H5_ITER_INC, i,
                                           name.data(), name.size(), H5P_DEFAULT);
    if (length > 0 && length < static_cast<ssize_t>(name.size())) names.emplace_back(name.data());
  }
  return names;
}

// the datasets of a group that may be its columns, and the greatest length among them
std::vector<std::pair<std::string, std::size_t>> ColumnsIn(const Hdf5Id& group) {
  std::vector<std::pair<std::string, std::size_t>> columns;
  for (std::string& name : LinksIn(group)) {
    const auto dataset = OpenDataset(group, name);
    if (!dataset || dataset->rank != 1 || !IsNumber(dataset->type.id())) continue;
    columns.emplace_back(std::move(name), dataset->numbers());
  }
  return columns;
}

std::vector<NumberColumn> TableOfGroup(const Hdf5Id& group) {
  const auto names = ColumnsIn(group);
  std::size_t rows = 0;
  for (const auto& [name, length] : names) rows = std::max(rows, length);
  std::vector<NumberColumn> columns;
  for (const auto& [name, length] : names) {
    // shorter ones are something else than columns beside the others
    if (length != rows) continue;
    const auto dataset = OpenDataset(group, name);
    if (!dataset) continue;
    auto numbers = NumbersOf(*dataset, H5T_NATIVE_DOUBLE);
    if (!numbers) continue;
    columns.push_back({.name = name,
                       .values = std::move(*numbers),
                       .is_count = H5Tget_class(dataset->type.id()) == H5T_INTEGER});
  }
  return columns;
}

// "b" of "a/b"
std::string LastPart(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? name : name.substr(slash + 1);
}

}  // namespace

bool Hdf5Exists(const Hdf5Id& file, const std::string& name) {
  for (std::size_t end = name.find('/');; end = name.find('/', end + 1)) {
    const std::string part = name.substr(0, end);
    if (!part.empty() && H5Lexists(file.id(), part.c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

bool HasHdf5Column(const Hdf5Id& file) {
  const Hdf5Id root(H5Gopen2(file.id(), "/", H5P_DEFAULT), H5Gclose);
  return root.ok() && !ColumnsIn(root).empty();
}

Result<NumberTable> ReadHdf5Table(const Hdf5Id& file, const std::string& name,
                                  const std::string& where, const ImportOptions& options) {
  NumberTable table;
  const std::string path = name.empty() ? "/" : name;
  if (const auto dataset = OpenDataset(file, path)) {
    if (H5Tget_class(dataset->type.id()) == H5T_COMPOUND && dataset->rank == 1) {
      table.columns = FieldsOf(*dataset);
    } else if (IsNumber(dataset->type.id())) {
      auto numbers = NumbersOf(*dataset, H5T_NATIVE_DOUBLE);
      if (!numbers) return CannotAnswer(where, "cannot be read: the file is damaged");
      HAPTOMETER_LET(table.columns,
                     ColumnsOfMatrix(std::move(*numbers), dataset->shape[0], dataset->shape[1],
                                     true, LastPart(name), where, options));
    }
  } else {
    const Hdf5Id group(H5Gopen2(file.id(), path.c_str(), H5P_DEFAULT), H5Gclose);
    if (group.ok()) table.columns = TableOfGroup(group);
  }
  if (!table.columns.empty()) return table;
  return CannotAnswer(where,
                      "is neither a group with columns of numbers nor a dataset of one or two "
                      "dimensions, or is too long",
                      "name another object of the file");
}

}  // namespace haptometer::trial
