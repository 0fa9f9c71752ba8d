// HDF5 files: trials that this program exported, and tables.
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "trial/export/object_names.h"
#include "trial/hdf5_id.h"
#include "trial/import/exported_trial.h"
#include "trial/import/hdf5_file.h"
#include "trial/import/number_table.h"
#include "trial/import/readers.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

// Reads the objects of one trial's group.
class Group final : public ExportedObjects {
 public:
  Group(Hdf5File& file, Hdf5Id group, std::string where)
      : ExportedObjects(std::move(where)), file_(file), group_(std::move(group)) {}

  bool Has(const std::string& name) override {
    return H5Lexists(group_.id(), name.c_str(), H5P_DEFAULT) > 0;
  }

  // the numbers of a dataset whose rows are `width` wide; T as it lies in memory
  template <typename T>
  Result<std::vector<T>> Numbers(const std::string& name, hid_t type, H5T_class_t kind,
                                 hsize_t width) {
    // existence, type, class and shape are checked before the memory is allocated
    HAPTOMETER_LET(const auto dataset, file_.Open(group_, name));
    if (!dataset.ok()) return Wrong(name, "is missing");
    const Hdf5Id stored(H5Dget_type(dataset.id()), H5Tclose);
    if (H5Tget_class(stored.id()) != kind || H5Tget_size(stored.id()) != sizeof(T)) {
      return Wrong(name, "holds numbers of another type");
    }
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    // one or two dimensions; a vector has the width 1
    hsize_t shape[2] = {0, 1};
    const int rank = H5Sget_simple_extent_ndims(space.id());
    if (rank < 1 || rank > 2 || H5Sget_simple_extent_dims(space.id(), shape, nullptr) < 0 ||
        shape[1] != width) {
      return Wrong(name, "has another shape");
    }
    HAPTOMETER_TRY(file_.Admit(dataset, shape[0], width));
    std::vector<T> numbers(shape[0] * width);
    if (!numbers.empty() &&
        H5Dread(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) {
      return Wrong(name, "cannot be read: the file is damaged");
    }
    return numbers;
  }

  Result<std::vector<double>> Doubles(const std::string& name, std::size_t width) override {
    return Numbers<double>(name, H5T_NATIVE_DOUBLE, H5T_FLOAT, width);
  }

  Result<std::vector<std::uint8_t>> Bytes(const std::string& name) override {
    return Numbers<std::uint8_t>(name, H5T_NATIVE_UINT8, H5T_INTEGER, 1);
  }

  // a scalar text of fixed length; NULs at its end do not belong to it
  Result<std::string> Text(const std::string& name) override {
    HAPTOMETER_LET(const auto dataset, file_.Open(group_, name));
    if (!dataset.ok()) return Wrong(name, "is missing");
    const Hdf5Id type(H5Dget_type(dataset.id()), H5Tclose);
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    const std::size_t bytes = H5Tget_size(type.id());
    if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0 ||
        H5Sget_simple_extent_type(space.id()) != H5S_SCALAR) {
      return Wrong(name, "is not a text of fixed length");
    }
    HAPTOMETER_TRY(file_.Admit(dataset, bytes, 1));
    std::string text(bytes, '\0');
    if (H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) {
      return Wrong(name, "cannot be read: the file is damaged");
    }
    text.erase(text.find_last_not_of('\0') + 1);
    return text;
  }

  // an attribute of one integer; absent or of another type: false
  bool Flag(const std::string& name) override {
    std::uint8_t value = 0;
    const Hdf5Id attribute(H5Aopen(group_.id(), name.c_str(), H5P_DEFAULT), H5Aclose);
    if (!attribute.ok()) return false;
    const Hdf5Id type(H5Aget_type(attribute.id()), H5Tclose);
    const Hdf5Id space(H5Aget_space(attribute.id()), H5Sclose);
    if (H5Tget_class(type.id()) != H5T_INTEGER || H5Sget_simple_extent_npoints(space.id()) != 1) {
      return false;
    }
    return H5Aread(attribute.id(), H5T_NATIVE_UINT8, &value) >= 0 && value != 0;
  }

 private:
  Hdf5File& file_;
  Hdf5Id group_;
};

// --- tables of other programs ---

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
};

// the dataset `name` of `place`, of one or two dimensions; nothing where it is none
Result<std::optional<Dataset>> OpenDataset(const Hdf5File& file, const Hdf5Id& place,
                                           const std::string& name) {
  HAPTOMETER_LET(auto id, file.Open(place, name));
  if (!id.ok() || H5Iget_type(id.id()) != H5I_DATASET) return std::nullopt;
  Hdf5Id type(H5Dget_type(id.id()), H5Tclose);
  Dataset dataset{.id = std::move(id), .type = std::move(type)};
  const Hdf5Id space(H5Dget_space(dataset.id.id()), H5Sclose);
  dataset.rank = H5Sget_simple_extent_ndims(space.id());
  if (dataset.rank < 1 || dataset.rank > 2 ||
      H5Sget_simple_extent_dims(space.id(), dataset.shape.data(), nullptr) < 0) {
    return std::nullopt;
  }
  return dataset;
}

// all numbers of an admitted dataset by `memory`, a type of one double
Result<std::vector<double>> NumbersOf(const Hdf5File& file, const Dataset& dataset, hid_t memory) {
  std::vector<double> numbers(dataset.shape[0] * dataset.shape[1]);
  if (!numbers.empty() &&
      H5Dread(dataset.id.id(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) {
    return CannotAnswer(file.PathOf(dataset.id),
                        "cannot be read: it is damaged, or compressed by a filter that is not "
                        "installed here",
                        "store it without compression");
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
Result<std::vector<NumberColumn>> FieldsOf(Hdf5File& file, const Dataset& dataset) {
  std::vector<NumberColumn> columns;
  const int count = std::min(H5Tget_nmembers(dataset.type.id()), static_cast<int>(kMostColumns));
  HAPTOMETER_TRY(file.Admit(dataset.id, dataset.shape[0], static_cast<std::uint64_t>(count)));
  for (int i = 0; i < count; ++i) {
    const auto member = static_cast<unsigned>(i);
    const Hdf5Id type(H5Tget_member_type(dataset.type.id(), member), H5Tclose);
    if (!IsNumber(type.id())) continue;
    NumberColumn column{.name = OwnedName(H5Tget_member_name(dataset.type.id(), member)),
                        .is_count = H5Tget_class(type.id()) == H5T_INTEGER};
    // a compound of this field alone, as a double
    const Hdf5Id memory(H5Tcreate(H5T_COMPOUND, sizeof(double)), H5Tclose);
    H5Tinsert(memory.id(), column.name.c_str(), 0, H5T_NATIVE_DOUBLE);
    HAPTOMETER_LET(column.values, NumbersOf(file, dataset, memory.id()));
    columns.push_back(std::move(column));
  }
  return columns;
}

// names of the first links in a group, at most `most`, in the order of the names
std::vector<std::string> LinksIn(const Hdf5Id& group, hsize_t most) {
  std::vector<std::string> names;
  H5G_info_t info{};
  if (H5Gget_info(group.id(), &info) < 0) return names;
  for (hsize_t i = 0; i < std::min(info.nlinks, most); ++i) {
    // longer names are ignored: neither a trial's group nor a column is called so
    std::array<char, 1024> name{};
    const auto length = H5Lget_name_by_idx(group.id(), ".", H5_INDEX_NAME, H5_ITER_INC, i,
                                           name.data(), name.size(), H5P_DEFAULT);
    if (length > 0 && length < static_cast<ssize_t>(name.size())) names.emplace_back(name.data());
  }
  return names;
}

// the datasets of a group that may be its columns, by their names
Result<std::vector<std::pair<std::string, Dataset>>> ColumnsIn(const Hdf5File& file,
                                                               const Hdf5Id& group) {
  std::vector<std::pair<std::string, Dataset>> columns;
  for (std::string& name : LinksIn(group, kMostColumns)) {
    HAPTOMETER_LET(auto dataset, OpenDataset(file, group, name));
    if (!dataset || dataset->rank != 1 || !IsNumber(dataset->type.id())) continue;
    columns.emplace_back(std::move(name), std::move(*dataset));
  }
  return columns;
}

Result<std::vector<NumberColumn>> TableOfGroup(Hdf5File& file, const Hdf5Id& group) {
  HAPTOMETER_LET(auto datasets, ColumnsIn(file, group));
  hsize_t rows = 0;
  for (const auto& [name, dataset] : datasets) rows = std::max(rows, dataset.shape[0]);
  // shorter ones are something else than columns beside the others
  std::erase_if(datasets, [&](const auto& named) { return named.second.shape[0] != rows; });
  // all of them before the memory of the first is allocated
  for (const auto& [name, dataset] : datasets) HAPTOMETER_TRY(file.Admit(dataset.id, rows, 1));
  std::vector<NumberColumn> columns;
  for (const auto& [name, dataset] : datasets) {
    HAPTOMETER_LET(auto numbers, NumbersOf(file, dataset, H5T_NATIVE_DOUBLE));
    columns.push_back({.name = name,
                       .values = std::move(numbers),
                       .is_count = H5Tget_class(dataset.type.id()) == H5T_INTEGER});
  }
  return columns;
}

// "b" of "a/b"
std::string LastPart(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? name : name.substr(slash + 1);
}

// the table at the path `name` of `file`, which is there; `where` stands for it in messages
Result<NumberTable> ReadTable(Hdf5File& file, const std::string& name, const std::string& where,
                              const ImportOptions& options) {
  NumberTable table;
  HAPTOMETER_LET(const auto dataset, OpenDataset(file, file.root(), name));
  if (!dataset) {
    HAPTOMETER_LET(const auto group, file.Open(file.root(), name));
    HAPTOMETER_LET(table.columns, TableOfGroup(file, group));
  } else if (H5Tget_class(dataset->type.id()) == H5T_COMPOUND && dataset->rank == 1) {
    HAPTOMETER_LET(table.columns, FieldsOf(file, *dataset));
  } else if (IsNumber(dataset->type.id())) {
    HAPTOMETER_TRY(file.Admit(dataset->id, dataset->shape[0], dataset->shape[1]));
    HAPTOMETER_LET(auto numbers, NumbersOf(file, *dataset, H5T_NATIVE_DOUBLE));
    HAPTOMETER_LET(table.columns,
                   ColumnsOfMatrix(std::move(numbers), dataset->shape[0], dataset->shape[1], true,
                                   LastPart(name), where, options));
  }
  if (!table.columns.empty()) return table;
  return CannotAnswer(where,
                      "is neither a group with columns of numbers nor a dataset of one or two "
                      "dimensions",
                      "name another object of the file");
}

// --- which object of a file ---

// whether `object` is a group that holds a trial's header
bool IsTrial(const Hdf5Id& object) {
  return H5Iget_type(object.id()) == H5I_GROUP &&
         H5Lexists(object.id(), objects::kHeader, H5P_DEFAULT) > 0;
}

// the groups at the root that hold a trial; those in other files are none of this one
std::vector<std::string> TrialsIn(const Hdf5File& file) {
  std::vector<std::string> names;
  for (std::string& name : LinksIn(file.root(), std::numeric_limits<hsize_t>::max())) {
    const auto object = file.Open(file.root(), name);
    if (object && IsTrial(*object)) names.push_back(std::move(name));
  }
  return names;
}

// "the dataset values (2 x 1000)"
std::string DescribeObject(const Hdf5File& file, const std::string& name) {
  const auto object = file.Open(file.root(), name);
  if (!object) return fmt::format("{} in another file", name);
  if (H5Iget_type(object->id()) != H5I_DATASET) return fmt::format("the group {}", name);
  const Hdf5Id space(H5Dget_space(object->id()), H5Sclose);
  hsize_t shape[H5S_MAX_RANK] = {};
  const int rank = H5Sget_simple_extent_dims(space.id(), shape, nullptr);
  return fmt::format("the dataset {} ({})", name,
                     fmt::join(shape, shape + std::max(rank, 0), " x "));
}

// "the dataset values (2 x 1000), the group set": the first few objects, for a message
std::string ObjectsIn(const Hdf5File& file) {
  constexpr hsize_t kShown = 4;
  std::vector<std::string> objects;
  for (const std::string& name : LinksIn(file.root(), kShown)) {
    objects.push_back(DescribeObject(file, name));
  }
  if (objects.empty()) return "nothing";
  H5G_info_t info{};
  const bool is_more = H5Gget_info(file.root().id(), &info) >= 0 && info.nlinks > kShown;
  return fmt::format("{}{}", fmt::join(objects, ", "), is_more ? " and more" : "");
}

// the error for a file of several trials, or of none and no columns
std::unexpected<Error> WhichOf(const Hdf5File& file, const std::vector<std::string>& names,
                               const std::string& name) {
  const std::string& path = file.path();
  if (names.empty() && !name.empty()) {
    return CannotAnswer(path, fmt::format("holds no object '{}', but {}", name, ObjectsIn(file)),
                        "name a dataset, or a group of columns");
  }
  if (names.empty()) {
    return CannotAnswer(
        path,
        fmt::format("is an HDF5 file of another program: no group at its root holds a trial ({}); "
                    "it holds {}",
                    objects::kHeader, ObjectsIn(file)),
        fmt::format("name a dataset, or a group of columns such as time_s and displacement_m: "
                    "{}/NAME",
                    path));
  }
  const std::size_t shown = std::min<std::size_t>(names.size(), 8);
  const std::string list =
      fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<long>(shown), ", "),
                  names.size() > shown ? ", ..." : "");
  return CannotAnswer(path,
                      name.empty() ? fmt::format("holds {} trials: {}", names.size(), list)
                                   : fmt::format("holds no trial '{}', but {}", name, list),
                      fmt::format("name one as {}/{}", path, names.front()));
}

}  // namespace

Result<Recording> ReadHdf5(const std::string& path, const std::string& name,
                           const ImportOptions& options) {
  // no output of the same command may replace this file
  NoteInput(path);
  HAPTOMETER_LET(auto file, Hdf5File::Open(path));
  const std::vector<std::string> trials = TrialsIn(file);
  const bool is_only = name.empty() && trials.size() == 1;
  const std::string chosen = is_only ? trials.front() : name.empty() ? "/" : name;
  HAPTOMETER_LET(auto object, file.Open(file.root(), chosen));
  if (IsTrial(object)) {
    std::string where = file.PathOf(object);
    Group objects(file, std::move(object), std::move(where));
    return ReadExportedTrial(objects, FileKind::kHdf5);
  }
  if (!object.ok() || (name.empty() && !trials.empty())) return WhichOf(file, trials, name);
  // without a name the columns may stand at the root
  if (name.empty()) {
    HAPTOMETER_LET(const auto columns, ColumnsIn(file, object));
    if (columns.empty()) return WhichOf(file, trials, name);
  }
  const std::string where = name.empty() ? path : fmt::format("{}/{}", path, name);
  HAPTOMETER_LET(auto table, ReadTable(file, chosen, where, options));
  return ReadNumberTable(std::move(table), FileKind::kHdf5, where, options);
}

}  // namespace haptometer::trial
