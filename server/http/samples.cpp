#include "server/http/samples.h"

#include <algorithm>

#include "server/http/assets.h"
#include "server/messages/request_messages.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

std::vector<Samples::Sample> read_index(const fs::path& folder, const Json& rows) {
  std::vector<Samples::Sample> samples;
  for (const Json& row : rows) {
    Samples::Sample sample{row.at("name"),          row.value("title", ""),   row.at("file"),
                           row.value("preset", ""), row.value("meaning", ""), {}};
    if (!fs::exists(folder / sample.file)) continue;
    sample.text = read_all(folder / sample.file);
    samples.push_back(std::move(sample));
  }
  return samples;
}

const Samples::Sample* find(const std::vector<Samples::Sample>& samples, std::string_view name) {
  const auto found = std::find_if(samples.begin(), samples.end(), [&](const Samples::Sample& sample) {
    return sample.name == name || sample.file == name || fs::path(sample.file).filename() == name;
  });
  return found == samples.end() ? nullptr : &*found;
}

}  // namespace

Samples::Samples(const fs::path& folder) {
  if (!fs::exists(folder / "index.json")) return;
  const Json index = parse_json(read_all(folder / "index.json"));
  meshes_ = read_index(folder, index.value("meshes", Json::array()));
  scenes_ = read_index(folder, index.value("scenes", Json::array()));
}

const Samples::Sample* Samples::mesh(std::string_view name) const {
  return find(meshes_, name);
}

const Samples::Sample* Samples::scene(std::string_view name) const {
  return find(scenes_, name);
}

}  // namespace isochor
