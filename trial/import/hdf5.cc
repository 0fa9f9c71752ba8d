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
#include "trial/import/number_table.h"
#include "trial/import/readers.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

constexpr const char* kRemedy = "export the trial again with haptometer trial export";

// Reads the objects of one trial's group.
class Group final : public ExportedObjects {
 public:
  Group(Hdf5Id group, std::string where)
      : ExportedObjects(std::move(where)), group_(std::move(group)) {}

  bool Has(const std::string& name) override {
    return H5Lexists(group_.id(), name.c_str(), H5P_DEFAULT) > 0;
  }

  // the numbers of a dataset whose rows are `width` wide; T as it lies in memory
  template <typename T>
  Result<std::vector<T>> Numbers(const std::string& name, hid_t type, H5T_class_t kind,
                                 hsize_t width) const {
    // existence, type, class and shape are checked before the memory is allocated
    const Hdf5Id dataset(H5Dopen2(group_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
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
    // a claimed length above the limit is refused
    if (shape[0] > kMostNumbers / width) return Wrong(name, "is too long to be read");
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
    constexpr std::size_t kMostBytes = 1U << 28;
    const Hdf5Id dataset(H5Dopen2(group_.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) return Wrong(name, "is missing");
    const Hdf5Id type(H5Dget_type(dataset.id()), H5Tclose);
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    // a file may state any length, so it is limited
    const std::size_t bytes = H5Tget_size(type.id());
    if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) > 0 ||
        H5Sget_simple_extent_type(space.id()) != H5S_SCALAR || bytes > kMostBytes) {
      return Wrong(name, "is not a text of fixed length");
    }
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

// the datasets of a group that may be its columns, and the greatest length among them
std::vector<std::pair<std::string, std::size_t>> ColumnsIn(const Hdf5Id& group) {
  std::vector<std::pair<std::string, std::size_t>> columns;
  for (std::string& name : LinksIn(group, kMostColumns)) {
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

// Whether each link of the path `name` from the root is there; an empty path is the root. libhdf5
// calls a path whose first links are missing an error.
bool Exists(const Hdf5Id& file, const std::string& name) {
  for (std::size_t end = name.find('/');; end = name.find('/', end + 1)) {
    const std::string part = name.substr(0, end);
    if (!part.empty() && H5Lexists(file.id(), part.c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

// whether a dataset of numbers of one dimension stands at the root
bool HasColumn(const Hdf5Id& file) {
  const Hdf5Id root(H5Gopen2(file.id(), "/", H5P_DEFAULT), H5Gclose);
  return root.ok() && !ColumnsIn(root).empty();
}

// the table at the path `name` of `file`, which is there; `where` stands for it in messages
Result<NumberTable> ReadTable(const Hdf5Id& file, const std::string& name, const std::string& where,
                              const ImportOptions& options) {
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

// --- which object of a file ---

// the groups at the root that hold a trial's header
std::vector<std::string> TrialsIn(const Hdf5Id& file) {
  std::vector<std::string> names;
  for (std::string& name : LinksIn(file, std::numeric_limits<hsize_t>::max())) {
    const std::string header = name + "/" + objects::kHeader;
    // objects at the root of other kinds than groups are no trials
    H5O_info_t object{};
    if (H5Oget_info_by_name(file.id(), name.c_str(), &object, H5P_DEFAULT) < 0 ||
        object.type != H5O_TYPE_GROUP) {
      continue;
    }
    if (H5Lexists(file.id(), header.c_str(), H5P_DEFAULT) > 0) names.push_back(std::move(name));
  }
  return names;
}

// "the dataset values (2 x 1000), the group set": the first few objects, for a message
std::string ObjectsIn(const Hdf5Id& file) {
  constexpr hsize_t kShown = 4;
  std::vector<std::string> objects;
  for (const std::string& name : LinksIn(file, kShown)) {
    const Hdf5Id dataset(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) {
      objects.push_back(fmt::format("the group {}", name));
      continue;
    }
    const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
    hsize_t shape[H5S_MAX_RANK] = {};
    const int rank = H5Sget_simple_extent_dims(space.id(), shape, nullptr);
    objects.push_back(fmt::format("the dataset {} ({})", name,
                                  fmt::join(shape, shape + std::max(rank, 0), " x ")));
  }
  if (objects.empty()) return "nothing";
  H5G_info_t info{};
  const bool is_more = H5Gget_info(file.id(), &info) >= 0 && info.nlinks > kShown;
  return fmt::format("{}{}", fmt::join(objects, ", "), is_more ? " and more" : "");
}

// whether `name` is the group of a trial; each link on the way to it is looked at by itself,
// because libhdf5 asks for that
bool IsTrial(const Hdf5Id& file, const std::string& name) {
  return Exists(file, name) && Exists(file, name + "/" + objects::kHeader);
}

// the error for a file of several trials, or of none and no columns
std::unexpected<Error> WhichOf(const Hdf5Id& file, const std::string& path,
                               const std::vector<std::string>& names, const std::string& name) {
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
  // errors are reported by this program, not by libhdf5 on stderr
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  // no output of the same command may replace this file
  NoteInput(path);
  const Hdf5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) {
    return CannotAnswer(path, "is a damaged HDF5 file, or is still being written", kRemedy);
  }
  const std::vector<std::string> trials = TrialsIn(file);
  const bool is_only = name.empty() && trials.size() == 1;
  const std::string chosen = is_only ? trials.front() : name;
  if (is_only || IsTrial(file, chosen)) {
    Hdf5Id group(H5Gopen2(file.id(), chosen.c_str(), H5P_DEFAULT), H5Gclose);
    if (!group.ok()) return CannotAnswer(path, "holds a trial that cannot be opened", kRemedy);
    Group objects(std::move(group), fmt::format("{}/{}", path, chosen));
    return ReadExportedTrial(objects, FileKind::kHdf5);
  }
  // without a name the columns may stand at the root
  const bool is_there = name.empty() ? trials.empty() && HasColumn(file) : Exists(file, name);
  if (!is_there) return WhichOf(file, path, trials, name);
  const std::string where = name.empty() ? path : fmt::format("{}/{}", path, name);
  HAPTOMETER_LET(auto table, ReadTable(file, name, where, options));
  return ReadNumberTable(std::move(table), FileKind::kHdf5, where, options);
}

}  // namespace haptometer::trial
