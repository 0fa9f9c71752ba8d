#include "acquire/transport/port_holder.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace haptometer::acquire {
namespace {

namespace fs = std::filesystem;

bool HasOpen(const fs::path& process, const fs::path& device) {
  std::error_code error;
  for (auto entry = fs::directory_iterator(process / "fd", error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code unreadable;
    if (fs::read_symlink(entry->path(), unreadable) == device) return true;
  }
  return false;
}

}  // namespace

std::string PortHolder(const std::string& path) {
  std::error_code error;
  const fs::path device = fs::canonical(path, error);
  if (error) return {};
  for (auto entry = fs::directory_iterator("/proc", error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string process = entry->path().filename();
    const bool is_other =
        std::ranges::all_of(process, [](char c) { return c >= '0' && c <= '9'; }) &&
        process != std::to_string(getpid());
    if (!is_other || !HasOpen(entry->path(), device)) continue;
    std::string command;
    std::getline(std::ifstream(entry->path() / "comm"), command);
    return fmt::format("{} (process {})", command, process);
  }
  return {};
}

}  // namespace haptometer::acquire
