#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>

#include "server/job_queue/guarded.h"

namespace isochor {

/// Large values, made once for all who are reading them at the same time and freed with the last: many slow
/// readers cost the memory of one. They are made one after another, since making one takes memory, too.
template <class T>
class Shared {
 public:
  std::shared_ptr<const T> get(const std::string& key, const std::function<T()>& make) {
    const auto slot = slots_.with([&](auto& slots) {
      std::erase_if(slots,
                    [](const auto& entry) { return entry.second.use_count() == 1 && entry.second->idle(); });
      auto& found = slots[key];
      if (!found) found = std::make_shared<Slot>();
      return found;
    });
    return slot->made.with([&](std::weak_ptr<const T>& text) -> std::shared_ptr<const T> {
      if (auto known = text.lock()) return known;
      auto made = making_.with([&](auto&) { return std::make_shared<const T>(make()); });
      text = made;
      return made;
    });
  }

 private:
  struct Slot {
    Guarded<std::weak_ptr<const T>> made;
    bool idle() const {
      return made.with([](const auto& weak) { return weak.expired(); });
    }
  };
  Guarded<std::map<std::string, std::shared_ptr<Slot>>> slots_;
  Guarded<std::monostate> making_;
};

}  // namespace isochor
