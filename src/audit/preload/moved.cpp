#include "audit/preload/moved.hpp"

namespace odeval::audit {

void MovedCallbacks::set(dBodyID body, Callback callback) {
  const std::lock_guard guard(lock_);
  if (callback == nullptr) {
    of_body_.erase(body);
  } else {
    of_body_[body].callback = callback;
  }
}

bool MovedCallbacks::watch(dBodyID body) {
  const std::lock_guard guard(lock_);
  return of_body_.try_emplace(body).second;
}

void MovedCallbacks::forget(dBodyID body) { set(body, nullptr); }

MovedCallbacks::Row* MovedCallbacks::moved(dBodyID body) {
  const std::lock_guard guard(lock_);
  const auto found = of_body_.find(body);
  if (found == of_body_.end()) return nullptr;
  found->second.due = held_;
  return held_ ? nullptr : &found->second;
}

MovedCallbacks::Row* MovedCallbacks::due(dBodyID body) {
  const std::lock_guard guard(lock_);
  const auto found = of_body_.find(body);
  if (found == of_body_.end() || !found->second.due) return nullptr;
  found->second.due = false;
  return &found->second;
}

MovedCallbacks::Held::Held(MovedCallbacks& callbacks) : callbacks_(callbacks) {
  const std::lock_guard guard(callbacks_.lock_);
  callbacks_.held_ = true;
}

void MovedCallbacks::Held::release() {
  const std::lock_guard guard(callbacks_.lock_);
  callbacks_.held_ = false;
}

MovedCallbacks::Held::~Held() {
  const std::lock_guard guard(callbacks_.lock_);
  callbacks_.held_ = false;
  for (auto& [body, row] : callbacks_.of_body_) row.due = false;
}

}  // namespace odeval::audit
