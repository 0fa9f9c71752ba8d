#include "trial/import/hdf5_file.h"

#include <fmt/core.h>
#include <hdf5.h>

#include <algorithm>
#include <array>

#include "trial/import/exported_trial.h"

namespace haptometer::trial {
namespace {

// asked before a link to another file is followed; a negative answer is an error of the opening
herr_t StayInFile(const char* /*file*/, const char* /*group*/, const char* /*other_file*/,
                  const char* /*other_object*/, unsigned* /*flags*/, hid_t /*access*/,
                  void* has_left) {
  *static_cast<bool*>(has_left) = true;
  return -1;
}

// whether a dataset's numbers lie in other files; what is no dataset has none
bool LiesElsewhere(const Hdf5Id& object) {
  if (H5Iget_type(object.id()) != H5I_DATASET) return false;
  const Hdf5Id made(H5Dget_create_plist(object.id()), H5Pclose);
  return H5Pget_layout(made.id()) == H5D_VIRTUAL || H5Pget_external_count(made.id()) > 0;
}

}  // namespace

Hdf5File::Hdf5File(std::string path, Hdf5Id file, Hdf5Id root)
    : path_(std::move(path)),
      file_(std::move(file)),
      root_(std::move(root)),
      links_(H5Pcreate(H5P_LINK_ACCESS), H5Pclose),
      has_left_(std::make_unique<bool>(false)) {
  H5Pset_elink_cb(links_.id(), StayInFile, has_left_.get());
  // numbers that lie in the file take a byte at least, so that a long file is read whole
  hsize_t bytes = 0;
  H5Fget_filesize(file_.id(), &bytes);
  numbers_left_ = std::max<std::uint64_t>(kMostNumbers, bytes);
}

Result<Hdf5File> Hdf5File::Open(const std::string& path) {
  PrepareHdf5();
  Hdf5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  Hdf5Id root(file.ok() ? H5Gopen2(file.id(), "/", H5P_DEFAULT) : -1, H5Gclose);
  if (!root.ok()) {
    return CannotAnswer(path, "is a damaged HDF5 file, or is still being written",
                        "export the trial again with haptometer trial export");
  }
  return Hdf5File(path, std::move(file), std::move(root));
}

std::string Hdf5File::PathOf(const Hdf5Id& object) const {
  std::array<char, 1024> name{};
  const auto length = H5Iget_name(object.id(), name.data(), name.size());
  // the root is "/"
  return length > 1 ? path_ + name.data() : path_;
}

Result<Hdf5Id> Hdf5File::Open(const Hdf5Id& place, const std::string& name) const {
  *has_left_ = false;
  Hdf5Id object(H5Oopen(place.id(), name.c_str(), links_.id()), H5Oclose);
  if (!*has_left_ && !LiesElsewhere(object)) return object;
  return CannotAnswer(
      fmt::format("{}/{}", PathOf(place), name),
      "lies in another file, and a recording is one file",
      "copy its numbers into one file (h5py: new[\"NAME\"] = old[\"NAME\"][:]), or name another "
      "object");
}

Result<void> Hdf5File::Admit(const Hdf5Id& dataset, std::uint64_t rows, std::uint64_t width) {
  // shapes are stated by the file: compared without a product that could overflow
  if (width > 0 && rows > numbers_left_ / width) {
    return CannotAnswer(PathOf(dataset), "has more numbers than are read of one file",
                        "name one object of the file, or cut it into shorter files");
  }
  // of numbers of a byte deflate packs 1032 into one, Zstandard 32 768
  constexpr std::uint64_t kMostInAByte = 1U << 17U;
  const std::uint64_t numbers = rows * width;
  const std::uint64_t stored = H5Dget_storage_size(dataset.id());
  if (stored < (numbers + kMostInAByte - 1) / kMostInAByte) {
    return CannotAnswer(
        PathOf(dataset),
        fmt::format("states {} numbers and holds {} bytes of them", numbers, stored),
        "were its numbers written? Record or export them again");
  }
  numbers_left_ -= numbers;
  return {};
}

}  // namespace haptometer::trial
