#include "server/store/simulations.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/scene/memory_estimate.h"

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
      throw Error(ErrorCode::over_budget, "too many simulations are running", "delete one, or pause it");
    options.id = "s" + std::to_string(data.next++);
    auto feed = std::make_shared<FrameFeed>(waker_, encoder_, frame_bytes_);
    auto runner = std::make_unique<SimulationRunner>(
        [build, id = options.id](Progress& progress) { return build(id, progress); }, options,
        std::move(feed));
    Slot slot{disposal_.share(std::move(runner)), ++data.clock};
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
  data.slots.erase(oldest);
  return true;
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
  data_.with([&](Data& data) { data.slots.erase(id); });
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

void Simulations::make_room(const std::string& id, std::int64_t bytes, const Progress& progress) {
  constexpr double gib = 1 << 30;
  data_.with([&](Data& data) {
    for (;;) {
      std::int64_t free = max_bytes_;
      for (const auto& [other, slot] : data.slots)
        if (other != id) free -= bytes_of(slot);
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
  });
  disposal_.wait(progress);
}

void Simulations::end_streams(const std::string& reason) {
  for (const auto& runner : all()) runner->feed()->end(reason);
}

}  // namespace isochor
