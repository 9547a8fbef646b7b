#include "server/http/server.h"

#include <fmt/format.h>

#include "core/parameters/parameters.h"

namespace isochor {
namespace {

std::string choose_token(const ServeOptions& options, const Listener& listener) {
  if (!listener.loopback() && options.token.empty())
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} can be reached from other machines", options.host),
                "give a --token of your own, or serve on 127.0.0.1");
  return options.token.empty() ? make_token() : options.token;
}

/// As it stands in a URL.
std::string name_of(const std::string& host) {
  return host.find(':') != std::string::npos ? "[" + host + "]" : host;
}

AccessPolicy policy(const std::string& host, const Listener& listener, const std::string& token) {
  if (listener.loopback()) return loopback_policy(listener.port(), token, name_of(host));
  return {.hosts = {}, .token = token, .token_for_reading = true};
}

}  // namespace

Server::Server(const ServeOptions& options, const FrontLimits& limits)
    : host_(options.host),
      listener_(options.host, options.port),
      token_(choose_token(options, listener_)),
      waker_(std::make_shared<Waker>()),
      api_(Samples(options.samples_folder), waker_, options.memory_limit),
      // Where others can reach the page, it does not hold the token: a person brings it along in the URL.
      assets_(options.web_folder, listener_.loopback() ? token_ : ""),
      service_(api_routes(api_), policy(host_, listener_, token_),
               [this](const Request& r) { return assets_.find(r); }),
      front_(listener_, service_, workers_, waker_, limits) {
  warm();
}

Server::~Server() = default;

std::string Server::url() const {
  return fmt::format("http://{}:{}/", name_of(host_), port());
}

/// The first sample's model is there before the page asks for it.
void Server::warm() {
  if (api_.samples.meshes().empty()) return;
  const Samples::Sample& first = api_.samples.meshes().front();
  api_.jobs.submit("warm", [this, &first](Progress& progress) {
    bool added = false;
    const auto mesh = store_mesh(api_, {first.file, {}, first.text}, added, progress);
    const MeshingOptions options = first.preset.empty() ? MeshingOptions{} : preset_options(first.preset);
    make_model(api_, mesh, options, std::nullopt, progress);
    return std::string("{}");
  });
}

void Server::run() {
  front_.run();
}

void Server::stop() {
  api_.simulations.end_streams("the server was stopped");
  front_.stop();
}

}  // namespace isochor
