#include "tools/daemon/status.h"

#include <fmt/core.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "tools/acquire/recording_document.h"
#include "tools/document/keys.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using document::Key;
using document::Section;
using document::TextOrNotKnown;
using nlohmann::ordered_json;

// in the order of LoopState
constexpr std::array<std::string_view, 6> kStateNames{"starting", "waiting for device", "recording",
                                                      "away",     "waiting for disk",   "stopped"};

// keys of the JSON on the socket too, which ParseStatus() reads
constexpr Key kConfig{"config"};
constexpr Key kState{document::kState.name, "state"};
constexpr Key kSince{"since_utc", "since"};
constexpr Key kDiskWaits{"disk_waits", "waits for disk"};
constexpr Key kLastError{"last_error"};

// one row of the table; keys without a label stand in JSON alone
Section SensorSection(const SensorStatus& sensor) {
  Section row;
  row.Add({document::kName.name, "sensor"}, sensor.name);
  row.Add(document::kPort, sensor.port);
  row.Add({document::kSensor.name}, sensor.sensor);
  row.Add(kState, Name(sensor.state));
  row.Add(kSince, TextOrNotKnown(sensor.since_utc));
  row.Add(document::kReadings, sensor.readings);
  row.Add(document::kRate, sensor.rate_hz).resolution = 0.1;
  row.Add(kBadKey, sensor.bad);
  row.Add(document::kGaps, sensor.gaps);
  row.Add(kLostKey, sensor.lost);
  row.Add(kReconnectsKey, sensor.reconnects);
  row.Add(kDiskWaits, sensor.disk_waits);
  row.Add({document::kFile.name, "file"}, TextOrNotKnown(sensor.file));
  row.Add(kLastError, TextOrNotKnown(sensor.last_error));
  return row;
}

// The value of a key, made printable, because any program may answer on a socket; where it is of
// another kind, the default, which means not known
std::string Text(const ordered_json& object, const Key& key) {
  const auto found = object.find(std::string(key.name));
  return found != object.end() && found->is_string() ? Printable(found->get<std::string>()) : "";
}

std::uint64_t Count(const ordered_json& object, const Key& key) {
  const auto found = object.find(std::string(key.name));
  if (found == object.end() || !found->is_number_unsigned()) return 0;
  const auto count = found->get<std::uint64_t>();
  // the document holds signed 64-bit integers
  return std::in_range<std::int64_t>(count) ? count : 0;
}

std::optional<double> Number(const ordered_json& object, const Key& key) {
  const auto found = object.find(std::string(key.name));
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

// nothing for an object without a known state: that is not a sensor of this version
std::optional<SensorStatus> FromJson(const ordered_json& object) {
  const std::string state = Text(object, kState);
  const auto* const found = std::ranges::find(kStateNames, state);
  if (!object.is_object() || found == kStateNames.end()) return std::nullopt;
  return SensorStatus{.name = Text(object, document::kName),
                      .port = Text(object, document::kPort),
                      .sensor = Text(object, document::kSensor),
                      .state = static_cast<LoopState>(found - kStateNames.begin()),
                      .since_utc = Text(object, kSince),
                      .file = Text(object, document::kFile),
                      .readings = Count(object, document::kReadings),
                      .rate_hz = Number(object, document::kRate),
                      .bad = Count(object, kBadKey),
                      .gaps = Count(object, document::kGaps),
                      .lost = Count(object, kLostKey),
                      .reconnects = Count(object, kReconnectsKey),
                      .disk_waits = Count(object, kDiskWaits),
                      .last_error = Text(object, kLastError)};
}

namespace fs = std::filesystem;
using acquire::OwnedDescriptor;

// a client that does not take the answer within this time must not block the others
constexpr MonotonicNs kTakenWithinNs = kNsPerS;
// longest answer that is accepted, 1 MiB
constexpr std::size_t kLongestStatus = 1 << 20;
constexpr int kWaiting = 8;  // clients that may queue while one is answered

Result<sockaddr_un> AddressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // sun_path is a fixed array (108 bytes on Linux) that needs its final zero
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return Usage(path, fmt::format("is not a path of 1 to {} bytes", sizeof address.sun_path - 1),
                 "name a shorter one under `socket`");
  }
  std::ranges::copy(path, address.sun_path);
  return address;
}

OwnedDescriptor NewSocket() {
  return OwnedDescriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

// system calls take addresses under the general type
const sockaddr* General(const sockaddr_un& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

// 0 or errno; a descriptor that could not be made counts as EMFILE
int Connect(const OwnedDescriptor& descriptor, const sockaddr_un& address) {
  if (descriptor.get() < 0) return EMFILE;
  return connect(descriptor.get(), General(address), sizeof address) == 0 ? 0 : errno;
}

std::unexpected<Error> NoSocket(const std::string& path, int error_number) {
  return Failed(path,
                fmt::format("no status socket: {}", std::generic_category().message(error_number)),
                "name another place under `socket`, in a directory that you may write to");
}

// removes the socket of a daemon that was killed, and no other file
Result<void> ClearPlace(const std::string& path, const sockaddr_un& address) {
  struct stat found{};
  if (lstat(path.c_str(), &found) != 0) return {};
  if (!S_ISSOCK(found.st_mode)) {
    return Usage(path, "is there and no socket", "name another place under `socket`");
  }
  // a socket without a listener refuses the connection: its daemon has ended
  if (Connect(NewSocket(), address) != ECONNREFUSED) {
    return Failed(path, "another daemon answers there",
                  "end it, or name another place under `socket`");
  }
  if (unlink(path.c_str()) != 0) return NoSocket(path, errno);
  return {};
}

std::vector<fs::path> SocketDirectories() {
  std::vector<fs::path> directories;
  // getenv is not safe beside setenv: called before any thread is started
  const char* own = std::getenv("XDG_RUNTIME_DIR");  // NOLINT(concurrency-mt-unsafe)
  if (own != nullptr && *own != '\0') directories.push_back(fs::path(own) / "haptometer");
  // the user's directory first, then the system's
  directories.emplace_back("/run/haptometer");
  return directories;
}

}  // namespace

std::string_view Name(LoopState state) { return kStateNames.at(static_cast<std::size_t>(state)); }

document::Document StatusDocument(const DaemonStatus& status) {
  document::Document document{.verb = "acquire",
                              .title = fmt::format("{}: {}", status.config, StatusLine(status))};
  Section& root = document.root;
  root.Add(kConfig, status.config);
  root.Add(document::kUtc, status.utc);
  Section sensors{.name = document::kSensors.name, .shape = Section::Shape::kTable};
  for (const SensorStatus& sensor : status.sensors) {
    sensors.sections.push_back(SensorSection(sensor));
    // the last error is shown as a note of its sensor, also after the state has changed
    if (sensor.last_error.empty()) continue;
    root.findings.push_back(
        {.kind = "last-error", .text = "last error: " + sensor.last_error, .subject = sensor.name});
  }
  root.sections = {std::move(sensors)};
  return document;
}

std::string StatusJson(const DaemonStatus& status) {
  document::Document document = StatusDocument(status);
  document.provenance = {.version = HAPTOMETER_VERSION, .utc = status.utc};
  return document::JsonOf(document);
}

Result<DaemonStatus> ParseStatus(std::string_view json, const std::string& where) {
  auto refused = CannotAnswer(where, "answers with no status of a daemon",
                              "is it haptometer's, and of this version?");
  // without exceptions: a document that is no JSON is discarded, and no object
  const ordered_json document = ordered_json::parse(json, nullptr, false);
  if (!document.is_object() || !document.contains(document::kSensors.name)) return refused;
  DaemonStatus status{.config = Text(document, kConfig), .utc = Text(document, document::kUtc)};
  for (const ordered_json& object : document[document::kSensors.name]) {
    auto sensor = FromJson(object);
    if (!sensor) return refused;
    status.sensors.push_back(std::move(*sensor));
  }
  return status;
}

std::string StatusLine(const DaemonStatus& status) {
  const auto recording =
      std::ranges::count(status.sensors, LoopState::kRecording, &SensorStatus::state);
  std::string line = fmt::format("{} of {} recording", recording, status.sensors.size());
  for (const SensorStatus& sensor : status.sensors) {
    // sensors that record are in the count; each other one is named with its state
    if (sensor.state == LoopState::kRecording) continue;
    line += fmt::format("; {}: {}", sensor.name, Name(sensor.state));
  }
  return line;
}

Result<StatusSocket> StatusSocket::Listen(std::string path) {
  HAPTOMETER_LET(const auto address, AddressOf(path));
  std::error_code error;
  (void)fs::create_directory(fs::path(path).parent_path(), error);  // bind reports what is wrong
  HAPTOMETER_TRY(ClearPlace(path, address));
  OwnedDescriptor listener = NewSocket();
  if (listener.get() < 0 || bind(listener.get(), General(address), sizeof address) != 0 ||
      listen(listener.get(), kWaiting) != 0) {
    return NoSocket(path, errno);
  }
  // a status changes nothing, so each user who can enter the directory may request it
  chmod(path.c_str(), 0666);
  // the inode identifies this socket when it is removed
  struct stat made{};
  if (lstat(path.c_str(), &made) != 0) return NoSocket(path, errno);
  return StatusSocket(std::move(listener), std::move(path), made.st_ino);
}

StatusSocket::~StatusSocket() {
  if (listener_.get() < 0) return;
  // another file may stand at the path by now: only this daemon's socket is removed
  struct stat found{};
  const bool is_ours =
      lstat(path_.c_str(), &found) == 0 && S_ISSOCK(found.st_mode) && found.st_ino == inode_;
  if (is_ours) unlink(path_.c_str());
}

void StatusSocket::AnswerOne(MonotonicNs longest_ns,
                             const std::function<std::string()>& text) const {
  pollfd watched{.fd = listener_.get(), .events = POLLIN, .revents = 0};
  const timespec longest{.tv_sec = longest_ns / kNsPerS, .tv_nsec = longest_ns % kNsPerS};
  if (ppoll(&watched, 1, &longest, nullptr) <= 0) return;
  const OwnedDescriptor asker(
      accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (asker.get() < 0) return;
  SystemClock clock;
  const auto sent =
      acquire::WriteDescriptor(asker.get(), text(), clock.Now() + kTakenWithinNs, path_);
  if (!sent) return;  // the client has disconnected
}

Result<std::string> AskStatus(const std::string& path, MonotonicNs longest_ns) {
  HAPTOMETER_LET(const auto address, AddressOf(path));
  SystemClock clock;
  // one deadline for the whole answer, not for each read
  const MonotonicNs deadline = clock.Now() + longest_ns;
  const OwnedDescriptor descriptor = NewSocket();
  if (const int failure = Connect(descriptor, address); failure != 0) {
    return CannotAnswer(
        path, fmt::format("no daemon answers: {}", std::generic_category().message(failure)),
        "start one with: acquire --daemon CONFIG.toml");
  }
  std::string text;
  std::array<char, 4096> buffer{};
  while (clock.Now() < deadline && text.size() <= kLongestStatus) {
    const auto read = acquire::ReadDescriptor(descriptor.get(), buffer, deadline);
    // the daemon closes the connection behind the answer: its end
    if (read.state == acquire::ReadState::kGone) return text;
    text.append(buffer.data(), read.bytes);
  }
  return CannotAnswer(path, "gives no status in time", "is it haptometer's daemon? try again");
}

std::vector<std::string> DefaultStatusSockets(const std::string& config_path) {
  return Mapped<std::string>(SocketDirectories(), [&](const fs::path& directory) {
    return directory / (fs::path(config_path).stem().string() + ".sock");
  });
}

std::vector<std::string> StatusSockets() {
  std::vector<std::string> paths;
  for (const fs::path& directory : SocketDirectories()) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(directory, error)) {
      if (entry.is_socket(error)) paths.push_back(entry.path());
    }
  }
  return paths;
}

}  // namespace haptometer::tools
