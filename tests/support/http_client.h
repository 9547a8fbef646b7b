#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/json_schema.h"

namespace isochor::test {

/// A blocking TCP socket to 127.0.0.1 that speaks bytes, well-formed or not. Reads give up after a minute.
class RawSocket {
 public:
  explicit RawSocket(int port);
  ~RawSocket();
  RawSocket(RawSocket&& other) noexcept;
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  bool send(std::string_view bytes);                 ///< false when the peer has gone
  std::string receive(std::size_t at_most = 65536);  ///< empty at the end
  std::string receive_all();
  void end_sending();
  void close();
  /// Before connecting would be better, but loopback honours it well enough: a small window.
  void shrink_receive_buffer(int bytes);

 private:
  int socket_;
};

struct HttpResponse {
  int status = 0;
  std::multimap<std::string, std::string> headers;  ///< names in lower case
  std::string body;

  std::string header(const std::string& name) const;
  nlohmann::json json() const { return nlohmann::json::parse(body); }
};
HttpResponse parse_response(const std::string& bytes);

using HeaderList = std::vector<std::pair<std::string, std::string>>;

/// Requests as an honest client sends them. Every response is checked against the server's /openapi.json; a
/// fault fails the test.
class HttpClient {
 public:
  HttpClient(int port, std::string token);

  HttpResponse get(const std::string& path, const HeaderList& headers = {}) const;
  HttpResponse send(const std::string& method, const std::string& path, const std::string& body = {},
                    const HeaderList& headers = {}) const;
  HttpResponse send_json(const std::string& method, const std::string& path,
                         const nlohmann::json& body) const;
  /// Follows a job until it has ended.
  nlohmann::json finish(nlohmann::json job) const;
  /// The bytes of a request, with Host and token.
  std::string request(const std::string& method, const std::string& path, const std::string& body,
                      const HeaderList& headers) const;
  HttpResponse exchange(const std::string& bytes) const;  ///< not checked

  int port() const { return port_; }
  const std::string& token() const { return token_; }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  const JsonSchema& schema() const { return schema_; }

 private:
  void check(const std::string& method, const std::string& path, const HttpResponse& response) const;

  int port_;
  std::string token_;
  JsonSchema schema_;
};

/// Lines of a live stream, each checked against the schema of stream lines.
class StreamReader {
 public:
  StreamReader(const HttpClient& client, const std::string& path, const HeaderList& headers = {});
  /// Null at the end.
  nlohmann::json next_line();
  nlohmann::json next_of_type(const std::string& type);  ///< skips others
  const HttpResponse& head() const { return head_; }
  RawSocket& socket() { return socket_; }
  std::string next_text_line();  ///< without its newline; empty at the end (or an empty line)
  bool ended() const { return ended_; }

 private:
  bool fill();

  RawSocket socket_;
  const JsonSchema& schema_;
  HttpResponse head_;
  std::string raw_, text_;
  bool ended_ = false;
};

}  // namespace isochor::test
