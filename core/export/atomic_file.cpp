#include "core/export/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <regex>
#include <vector>

#include "core/common/error.h"

namespace isochor {
namespace {

[[noreturn]] void fail(const std::filesystem::path& target, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw Error(ErrorCode::cannot_write,
              fmt::format("cannot write {}: {}", target.string(), std::strerror(error)),
              full ? "free some space, or write to another disk"
                   : "check that the folder exists and that you may write there");
}

/// Through symbolic links, so that renaming replaces the file and not the link.
std::filesystem::path resolved(const std::filesystem::path& target) {
  std::error_code ignored;
  const auto path = std::filesystem::weakly_canonical(target, ignored);
  return path.empty() ? target : path;
}

void sync_folder(const std::filesystem::path& file) {
  const auto folder = file.parent_path();
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : target_(target) {
  if (target_ == "-") {
    descriptor_ = ::dup(STDOUT_FILENO);
    if (descriptor_ < 0) fail(target_, errno);
    return;
  }
  struct stat status {};
  const bool exists = ::stat(target_.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) fail(target_, EISDIR);
  if (exists && !S_ISREG(status.st_mode)) {
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(target_, errno);
    return;
  }
  target_ = resolved(target);
  if (exists && ::access(target_.c_str(), W_OK) != 0) fail(target_, errno);
  // O_EXCL: never through a file or link that somebody else has put there.
  for (int attempt = 0; descriptor_ < 0 && attempt < 100; ++attempt) {
    beside_ = target_.parent_path() /
              fmt::format(".{}.{}.{}.tmp", target_.filename().string(), ::getpid(), attempt);
    descriptor_ = ::open(beside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EEXIST) fail(target_, errno);
  }
  if (descriptor_ < 0) fail(target_, EEXIST);
  if (exists) ::fchmod(descriptor_, status.st_mode & 0777);
}

AtomicFile::~AtomicFile() {
  close();
  if (!beside_.empty()) ::unlink(beside_.c_str());
}

void AtomicFile::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

void AtomicFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(target_, errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::sync() {
  if (!beside_.empty() && ::fsync(descriptor_) != 0) fail(target_, errno);
}

void AtomicFile::commit() {
  sync();
  close();
  if (beside_.empty()) return;
  if (::rename(beside_.c_str(), target_.c_str()) != 0) fail(target_, errno);
  beside_.clear();
  sync_folder(target_);
}

void remove_abandoned(const std::filesystem::path& folder) {
  // As an AtomicFile names them.
  static const std::regex beside(R"(\..+\.([1-9][0-9]{0,8})\.[0-9]+\.tmp)");
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    if (!std::regex_match(name, parts, beside)) continue;
    const bool gone = ::kill(std::stoi(parts[1]), 0) != 0 && errno == ESRCH;
    if (gone) std::filesystem::remove(entry.path(), ignored);
  }
}

void write_file(const std::filesystem::path& path, std::string_view content) {
  const NamedContent file{path, content};
  write_files({&file, 1});
}

void write_files(std::span<const NamedContent> files) {
  std::vector<std::unique_ptr<AtomicFile>> open;
  for (const NamedContent& file : files) {
    open.push_back(std::make_unique<AtomicFile>(file.path));
    open.back()->write(file.content);
    open.back()->sync();
  }
  for (const auto& file : open) file->commit();
}

}  // namespace isochor
