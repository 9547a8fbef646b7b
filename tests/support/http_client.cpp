#include "tests/support/http_client.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace isochor::test {
namespace {

using nlohmann::json;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool matches(std::string_view pattern, std::string_view path) {
  while (!pattern.empty() && !path.empty()) {
    if (pattern.front() == '{') {
      pattern.remove_prefix(pattern.find('}') + 1);
      path.remove_prefix(std::min(path.find('/'), path.size()));
    } else if (pattern.front() == path.front()) {
      pattern.remove_prefix(1), path.remove_prefix(1);
    } else {
      return false;
    }
  }
  return pattern.empty() && path.empty();
}

}  // namespace

RawSocket::RawSocket(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const timeval patience{60 * ISOCHOR_SLOWNESS, 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("cannot connect");
}

RawSocket::~RawSocket() {
  close();
}

RawSocket::RawSocket(RawSocket&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

void RawSocket::close() {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
}

bool RawSocket::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

std::string RawSocket::receive(std::size_t at_most) {
  std::string buffer(at_most, '\0');
  const ssize_t got = recv(socket_, buffer.data(), buffer.size(), 0);
  buffer.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return buffer;
}

std::string RawSocket::receive_all() {
  std::string all;
  for (std::string part = receive(); !part.empty(); part = receive()) all += part;
  return all;
}

void RawSocket::end_sending() {
  shutdown(socket_, SHUT_WR);
}

void RawSocket::shrink_receive_buffer(int bytes) {
  setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

std::string HttpResponse::header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

HttpResponse parse_response(const std::string& bytes) {
  HttpResponse response;
  const std::size_t end = bytes.find("\r\n\r\n");
  if (!bytes.starts_with("HTTP/1.1 ") || end == std::string::npos) return response;
  response.status = std::stoi(bytes.substr(9, 3));
  for (std::size_t at = bytes.find("\r\n") + 2; at < end;) {
    const std::size_t stop = bytes.find("\r\n", at), colon = bytes.find(": ", at);
    response.headers.emplace(lower(bytes.substr(at, colon - at)), bytes.substr(colon + 2, stop - colon - 2));
    at = stop + 2;
  }
  response.body = bytes.substr(end + 4);
  return response;
}

HttpClient::HttpClient(int port, std::string token) : port_(port), token_(std::move(token)), schema_(json()) {
  schema_ = JsonSchema(exchange(request("GET", "/api/v1/openapi.json", "", {})).json());
}

std::string HttpClient::request(const std::string& method, const std::string& path, const std::string& body,
                                const HeaderList& headers) const {
  std::string text = method + " " + path + " HTTP/1.1\r\nHost: " + host() + "\r\n";
  if (method != "GET" && method != "HEAD")
    text += "Authorization: Bearer " + token_ + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  for (const auto& [name, value] : headers) text += name + ": " + value + "\r\n";
  return text + "\r\n" + body;
}

HttpResponse HttpClient::exchange(const std::string& bytes) const {
  RawSocket socket(port_);
  socket.send(bytes);
  return parse_response(socket.receive_all());
}

HttpResponse HttpClient::get(const std::string& path, const HeaderList& headers) const {
  return send("GET", path, "", headers);
}

HttpResponse HttpClient::send(const std::string& method, const std::string& path, const std::string& body,
                              const HeaderList& headers) const {
  HttpResponse response = exchange(request(method, path, body, headers));
  check(method, path.substr(0, path.find('?')), response);
  return response;
}

HttpResponse HttpClient::send_json(const std::string& method, const std::string& path,
                                   const json& body) const {
  return send(method, path, body.dump(), {{"Content-Type", "application/json"}});
}

json HttpClient::finish(json job) const {
  while (job["status"] == "queued" || job["status"] == "running")
    job = get("/api/v1/jobs/" + job["id"].get<std::string>() + "?wait_ms=1000").json();
  return job;
}

void HttpClient::check(const std::string& method, const std::string& path,
                       const HttpResponse& response) const {
  const std::string what = method + " " + path + " → " + std::to_string(response.status);
  if (!path.starts_with("/api/") || response.status == 304 || method == "HEAD") return;
  EXPECT_EQ(response.header("content-length"),
            response.status == 204 ? "0" : std::to_string(response.body.size()));
  json answer = {
      {"content", {{"application/problem+json", {{"schema", {{"$ref", "#/components/schemas/Problem"}}}}}}}};
  for (const auto& [pattern, operations] : schema_.document()["paths"].items()) {
    if (!matches(pattern, path) || !operations.contains(lower(method))) continue;
    const json& responses = operations[lower(method)]["responses"];
    answer = responses.value(std::to_string(response.status), responses["default"]);
  }
  if (!answer.contains("content")) {
    EXPECT_EQ(response.body, "") << what;
    return;
  }
  const std::string type = response.header("content-type");
  const json& content = answer["content"];
  if (content.contains("*/*")) return;
  ASSERT_TRUE(content.contains(type))
      << what << " has the type " << type << ": " << response.body.substr(0, 300);
  if (!content[type].contains("schema")) return;
  const auto fault = schema_.fault(content[type]["schema"], response.json());
  EXPECT_FALSE(fault) << what << ": " << fault.value_or("");
}

StreamReader::StreamReader(const HttpClient& client, const std::string& path, const HeaderList& headers)
    : socket_(client.port()), schema_(client.schema()) {
  socket_.send(client.request("GET", path, "", headers));
  while (raw_.find("\r\n\r\n") == std::string::npos) {
    const std::string part = socket_.receive();
    if (part.empty()) break;
    raw_ += part;
  }
  head_ = parse_response(raw_);
  raw_ = std::exchange(head_.body, {});
}

/// The next chunk's text; false at the end.
bool StreamReader::fill() {
  for (;;) {
    const std::size_t line = raw_.find("\r\n");
    if (line != std::string::npos) {
      const std::size_t size = std::stoul(raw_.substr(0, line), nullptr, 16);
      if (raw_.size() >= line + 4 + size) {
        text_ += raw_.substr(line + 2, size);
        raw_.erase(0, line + 4 + size);
        ended_ = size == 0;
        return !ended_;
      }
    }
    const std::string part = socket_.receive(1 << 20);
    ended_ = part.empty();
    if (ended_) return false;
    raw_ += part;
  }
}

std::string StreamReader::next_text_line() {
  std::size_t end = 0;
  while ((end = text_.find('\n')) == std::string::npos)
    if (!fill()) return {};
  const std::string line = text_.substr(0, end);
  text_.erase(0, end + 1);
  return line;
}

json StreamReader::next_line() {
  const std::string text = next_text_line();
  if (text.empty()) return nullptr;
  json line = json::parse(text);
  const auto fault = schema_.fault({{"$ref", "#/components/schemas/StreamLine"}}, line);
  EXPECT_FALSE(fault) << fault.value_or("") << ": " << text.substr(0, 300);
  return line;
}

json StreamReader::next_of_type(const std::string& type) {
  for (;;) {
    json line = next_line();
    if (line.is_null() || line["type"] == type) return line;
  }
}

}  // namespace isochor::test
