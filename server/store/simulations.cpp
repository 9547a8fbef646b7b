#include "server/store/simulations.h"

#include <algorithm>

namespace isochor {
namespace {

constexpr std::size_t max_simulations = 16;

bool idle(const SimulationRunner& runner) {
  const RunState state = runner.view().state;
  return state != RunState::playing && state != RunState::preparing && runner.feed()->viewers() == 0;
}

}  // namespace

Simulations::Simulations(std::shared_ptr<Waker> waker, std::int64_t frame_bytes)
    : waker_(std::move(waker)), encoder_(std::make_shared<WorkerPool>(1)), frame_bytes_(frame_bytes) {}

Simulations::~Simulations() = default;

std::shared_ptr<SimulationRunner> Simulations::create(SimulationRunner::Build build, RunOptions options) {
  return data_.with([&](Data& data) {
    if (data.slots.size() >= max_simulations && !drop_oldest_idle(data))
      throw Error(ErrorCode::over_budget, "too many simulations are running", "delete one, or pause it");
    options.id = "s" + std::to_string(data.next++);
    auto feed = std::make_shared<FrameFeed>(waker_, encoder_, frame_bytes_);
    auto runner = std::make_unique<SimulationRunner>(std::move(build), options, std::move(feed));
    Slot slot{disposal_.share(std::move(runner)), ++data.clock};
    return data.slots.emplace(options.id, std::move(slot)).first->second.runner;
  });
}

bool Simulations::drop_oldest_idle(Data& data) {
  auto oldest = data.slots.end();
  for (auto it = data.slots.begin(); it != data.slots.end(); ++it)
    if (idle(*it->second.runner) && (oldest == data.slots.end() || it->second.used < oldest->second.used))
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

std::int64_t Simulations::bytes() const {
  std::int64_t bytes = 0;
  for (const auto& runner : all()) {
    bytes += runner->feed()->bytes();
    for (const PlannedPhase& phase : runner->view().plan) bytes += phase.bytes;
  }
  return bytes;
}

void Simulations::end_streams(const std::string& reason) {
  for (const auto& runner : all()) runner->feed()->end(reason);
}

}  // namespace isochor
