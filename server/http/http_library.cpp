#include "server/http/http_library.h"

#include <httplib.h>

#include <algorithm>
#include <cstring>
#include <exception>

#include "server/messages/problem_messages.h"

namespace isochor {
namespace {

class MemoryStream final : public httplib::Stream {
 public:
  explicit MemoryStream(std::string_view input) : input_(input) {}
  std::string take_output() { return std::move(output_); }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override {
    size = std::min(size, input_.size());
    std::memcpy(to, input_.data(), size);
    input_.remove_prefix(size);
    return static_cast<ssize_t>(size);
  }
  ssize_t write(const char* from, std::size_t size) override {
    output_.append(from, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return INVALID_SOCKET; }

 private:
  std::string_view input_;
  std::string output_;
};

/// One exchange: the library parses the head, hands over, and writes what comes back.
class Exchange final : public httplib::Server {
 public:
  std::string run(std::string_view head, const Handler& handler) {
    std::exception_ptr thrown;
    set_pre_routing_handler([&](const httplib::Request& request, httplib::Response& response) {
      try {
        handler(request, response);
      } catch (...) {
        thrown = std::current_exception();  // the library would make a bare 500 of it
      }
      return HandlerResponse::Handled;
    });
    MemoryStream stream(head);
    bool closed = false;
    process_request(stream, true, closed, nullptr);
    if (thrown) std::rethrow_exception(thrown);
    return stream.take_output();
  }
};

/// Declares the body without giving it: the bytes are sent by the front, which shares them between readers.
void declare_body(const Response& from, httplib::Response& to) {
  const auto nothing = [](auto&&...) { return false; };
  const std::string type = from.content_type.empty() ? "application/json" : from.content_type;
  if (from.stream)
    to.set_chunked_content_provider(type, nothing);
  else if (from.body_size() > 0)
    to.set_content_provider(from.body_size(), type, nothing);
}

}  // namespace

std::string format_head(const Response& response) {
  return Exchange().run("GET / HTTP/1.1\r\n\r\n", [&](const httplib::Request&, httplib::Response& out) {
    out.status = response.status;
    out.reason = status_title(response.status);
    for (const auto& [name, value] : response.headers) out.set_header(name, value);
    declare_body(response, out);
  });
}

}  // namespace isochor
