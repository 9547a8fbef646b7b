#include "server/http/nameless_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "server/http/service.h"

namespace isochor {
namespace {

std::string folder() {
  const char* chosen = std::getenv("TMPDIR");
  return chosen && *chosen ? chosen : "/var/tmp";
}

[[noreturn]] void fail(int error) {
  refuse(507, "no_space", fmt::format("no room for the body in {}: {}", folder(), std::strerror(error)),
         "free some space there, or start the server with TMPDIR set to a folder that has more");
}

int open_nameless() {
  const int nameless = ::open(folder().c_str(), O_TMPFILE | O_EXCL | O_RDWR | O_CLOEXEC, 0600);
  if (nameless >= 0) return nameless;
  // Not every file system knows such files.
  std::string name = folder() + "/isochor-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named < 0) fail(errno);
  ::unlink(name.c_str());
  return named;
}

}  // namespace

NamelessFile::NamelessFile() : descriptor_(open_nameless()) {}

NamelessFile::~NamelessFile() {
  if (mapped_) ::munmap(mapped_, size_);
  ::close(descriptor_);
}

void NamelessFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    size_ += static_cast<std::size_t>(written);
  }
}

void NamelessFile::overwrite(std::size_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += static_cast<std::size_t>(written);
  }
}

std::string_view NamelessFile::map() {
  if (!mapped_) {
    void* const address = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor_, 0);
    if (address == MAP_FAILED) throw std::bad_alloc();
    mapped_ = address;
  }
  return {static_cast<const char*>(mapped_), size_};
}

ssize_t NamelessFile::send(int socket, std::size_t offset) const {
  auto from = static_cast<off_t>(offset);
  return ::sendfile(socket, descriptor_, &from, size_ - offset);
}

}  // namespace isochor
