#include "roadgen/export/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace roadgen {
namespace {

namespace fs = std::filesystem;

Error cannot_write(const std::string& path, const std::string& why) {
  return {ErrorCode::kIo, "cannot be written: " + why, path};
}

Error cannot_write(const std::string& path, int errno_value) {
  return cannot_write(path, std::string(std::strerror(errno_value)));
}

// The file behind symbolic links; path itself where there is none.
fs::path resolved(const std::string& path) {
  std::error_code ignored;
  const fs::path real = fs::weakly_canonical(path, ignored);
  return real.empty() ? fs::path(path) : real;
}

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

// A descriptor that closes itself, and a name that goes away unless it was kept.
struct Temporary {
  std::string name;
  int descriptor = -1;
  bool kept = false;

  ~Temporary() {
    if (descriptor >= 0) ::close(descriptor);
    if (!name.empty() && !kept) ::unlink(name.c_str());
  }
};

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

Status check_writable(const std::string& path) {
  const fs::path file = resolved(path), folder = folder_of(file);
  struct stat found {};
  if (path.empty()) return cannot_write("output", "its name is empty");
  if (::stat(folder.c_str(), &found) != 0) {
    return cannot_write(path, "there is no folder " + folder.string() + "; create it first");
  }
  if (!S_ISDIR(found.st_mode)) return cannot_write(path, folder.string() + " is not a folder");
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return cannot_write(path, "no right to create files in " + folder.string());
  }
  if (::stat(file.c_str(), &found) == 0 && !S_ISREG(found.st_mode)) {
    return cannot_write(path, S_ISDIR(found.st_mode) ? "it is a folder; name a file" : "it is not a regular file");
  }
  return Done{};
}

Status write_file(const std::string& path, std::string_view bytes) {
  return write_file(path, [&](const TakeBytes& take) { take(bytes); });
}

Status write_file(const std::string& path, const std::function<void(const TakeBytes&)>& write) {
  if (Status status = check_writable(path); !status) return status;
  const fs::path file = resolved(path);

  Temporary temporary;
  const std::string base = (folder_of(file) / ("." + file.filename().string())).string();
  for (int attempt = 0; temporary.descriptor < 0; ++attempt) {
    const std::string name = base + "." + std::to_string(::getpid()) + "." + std::to_string(attempt) + ".tmp";
    temporary.descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (temporary.descriptor >= 0) temporary.name = name;
    if (temporary.descriptor < 0 && (errno != EEXIST || attempt >= 100)) return cannot_write(path, errno);
  }

  int failure = 0;
  write([&](std::string_view bytes) {
    if (failure == 0 && !write_all(temporary.descriptor, bytes)) failure = errno;
  });
  if (failure != 0) return cannot_write(path, failure);
  if (::fsync(temporary.descriptor) != 0) return cannot_write(path, errno);
  if (std::rename(temporary.name.c_str(), file.c_str()) != 0) return cannot_write(path, errno);
  temporary.kept = true;
  return Done{};
}

}  // namespace roadgen
