#include "server/store/simulations.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/memory_estimate.h"
#include "server/messages/problem_messages.h"

namespace isochor {
namespace {

constexpr std::size_t max_simulations = 16;

bool idle(const SimulationRunner& runner) {
  const RunState state = runner.view().state;
  return state != RunState::playing && state != RunState::preparing && runner.feed()->viewers() == 0;
}

}  // namespace

Simulations::Simulations(std::shared_ptr<Waker> waker, std::int64_t max_bytes, std::int64_t frame_bytes)
    : waker_(std::move(waker)),
      encoder_(std::make_shared<WorkerPool>(1)),
      max_bytes_(max_bytes),
      frame_bytes_(frame_bytes) {}

Simulations::~Simulations() = default;

std::shared_ptr<SimulationRunner> Simulations::create(Build build, RunOptions options) {
  return data_.with([&](Data& data) {
    if (data.slots.size() >= max_simulations && !drop_oldest_idle(data, ""))
      throw RefusalException{{503, "busy", "too many simulations are running", "delete one, or pause it"}};
    options.id = "s" + std::to_string(data.next++);
    auto feed = std::make_shared<FrameFeed>(waker_, encoder_, frame_bytes_);
    auto runner = std::make_unique<SimulationRunner>(
        [build, id = options.id](Progress& progress) { return build(id, progress); }, options,
        std::move(feed));
    const auto lease = std::make_shared<const std::string>(options.id);
    Slot slot{disposal_.share(std::move(runner), lease), lease, ++data.clock};
    return data.slots.emplace(options.id, std::move(slot)).first->second.runner;
  });
}

bool Simulations::drop_oldest_idle(Data& data, const std::string& except) {
  auto oldest = data.slots.end();
  for (auto it = data.slots.begin(); it != data.slots.end(); ++it)
    if (it->first != except && idle(*it->second.runner) &&
        (oldest == data.slots.end() || it->second.used < oldest->second.used))
      oldest = it;
  if (oldest == data.slots.end()) return false;
  drop(data, oldest->first);
  return true;
}

/// Its bytes count until they are free.
void Simulations::drop(Data& data, const std::string& id) {
  const auto slot = data.slots.find(id);
  if (slot == data.slots.end()) return;
  data.leaving.push_back({slot->second.lease, bytes_of(slot->second)});
  data.slots.erase(slot);
}

std::shared_ptr<SimulationRunner> Simulations::find(const std::string& id) {
  return data_.with([&](Data& data) {
    const auto found = data.slots.find(id);
    if (found == data.slots.end()) throw Missing{"simulation", id, was_issued(id, data.next)};
    found->second.used = ++data.clock;
    return found->second.runner;
  });
}

void Simulations::remove(const std::string& id) {
  find(id)->cancel();
  data_.with([&](Data& data) { drop(data, id); });
}

std::vector<std::shared_ptr<SimulationRunner>> Simulations::all() const {
  return data_.with([](const Data& data) {
    std::vector<std::shared_ptr<SimulationRunner>> runners;
    for (const auto& [id, slot] : data.slots) runners.push_back(slot.runner);
    return runners;
  });
}

int Simulations::viewers() const {
  int count = 0;
  for (const auto& runner : all()) count += runner->feed()->viewers();
  return count;
}

/// While it is prepared only the estimate is known.
std::int64_t Simulations::bytes_of(const Slot& slot) {
  std::int64_t planned = 0;
  for (const PlannedPhase& phase : slot.runner->view().plan) planned += phase.bytes;
  return std::max(planned, slot.reserved) + slot.runner->feed()->bytes();
}

std::int64_t Simulations::bytes() const {
  return data_.with([](const Data& data) {
    std::int64_t bytes = 0;
    for (const auto& [id, slot] : data.slots) bytes += bytes_of(slot);
    return bytes;
  });
}

std::int64_t Simulations::bytes_leaving(Data& data) {
  std::erase_if(data.leaving, [](const Leaving& one) { return one.lease.expired(); });
  std::int64_t bytes = 0;
  for (const Leaving& one : data.leaving) bytes += one.bytes;
  return bytes;
}

/// False where what is being freed has to be waited for. What is on its way out and held by somebody is not:
/// that may be a run that goes on from it.
bool Simulations::reserve(Data& data, const std::string& id, std::int64_t bytes) const {
  constexpr double gib = 1 << 30;
  for (;;) {
    const bool freeing = disposal_.busy();  // before the bytes are counted: what ends meanwhile is seen
    std::int64_t free = max_bytes_;
    for (const auto& [other, slot] : data.slots)
      if (other != id) free -= bytes_of(slot);
    if (bytes <= free - bytes_leaving(data)) break;
    if (freeing) return false;
    if (bytes <= free) break;
    if (drop_oldest_idle(data, id)) continue;
    free = std::max<std::int64_t>(free, 0);
    throw Error(ErrorCode::over_budget,
                fmt::format("the simulation takes about {:.2f} GiB, and {:.2f} of {:.2f} GiB are free",
                            static_cast<double>(bytes) / gib, static_cast<double>(free) / gib,
                            static_cast<double>(max_bytes_) / gib),
                fmt::format("take at most {} cells, or delete or pause others", free / bytes_a_cell));
  }
  if (const auto own = data.slots.find(id); own != data.slots.end()) own->second.reserved = bytes;
  return true;
}

void Simulations::make_room(const std::string& id, std::int64_t bytes, const Progress& progress) {
  while (!data_.with([&](Data& data) { return reserve(data, id, bytes); })) disposal_.wait(progress);
}

void Simulations::end_streams(const std::string& reason) {
  for (const auto& runner : all()) runner->feed()->end(reason);
}

}  // namespace isochor
