#include "audit/preload/collisions.hpp"

#include <dlfcn.h>

#include <cstdint>
#include <cstring>

#include "audit/preload/own.hpp"

namespace odeval::audit {
namespace {

/// PyODE gives its callback an object of Python that goes when the call returns.
bool of_python(dNearCallback* callback) {
  Dl_info info{};
  return ::dladdr(reinterpret_cast<void*>(callback), &info) != 0 && info.dli_fname != nullptr &&
         std::strstr(info.dli_fname, "cpython") != nullptr;
}

void call_python(const char* name, void* object) {
  void* found = ::dlsym(RTLD_DEFAULT, name);
  if (found != nullptr && object != nullptr) reinterpret_cast<void (*)(void*)>(found)(object);
}

/// Below the frames that were alive at `frame_of_step`, and not so far that it is no stack any more.
bool in_a_frame_that_is_gone(const void* data, const void* frame_of_step) {
  constexpr std::uintptr_t deepest = 8 << 20;
  const auto here = reinterpret_cast<std::uintptr_t>(frame_of_step);
  const auto there = reinterpret_cast<std::uintptr_t>(data);
  return there < here && here - there < deepest;
}

bool has_body_of(dGeomID geom, dWorldID world) {
  if (dGeomIsSpace(geom) == 0) {
    dBodyID body = dGeomGetBody(geom);
    return body != nullptr && dBodyGetWorld(body) == world;
  }
  auto* const space = reinterpret_cast<dSpaceID>(geom);
  const int count = dSpaceGetNumGeoms(space);
  for (int i = 0; i < count; ++i) {
    if (has_body_of(dSpaceGetGeom(space, i), world)) return true;
  }
  return false;
}

}  // namespace

Collisions::~Collisions() = default;  // Python may be gone

void Collisions::add(dGeomID first, dGeomID second, void* data, dNearCallback* callback) {
  if (calls_.size() == most_calls) {
    clear();
    too_many_ = true;
  }
  if (too_many_) return;
  const bool kept = of_python(callback);
  if (kept) call_python("Py_IncRef", data);
  calls_.push_back({first, second, data, callback, kept});
}

void Collisions::release(const Call& call) {
  if (call.kept) call_python("Py_DecRef", call.data);
}

void Collisions::forget(dGeomID geom) {
  std::erase_if(calls_, [geom](const Call& call) {
    const bool gone = call.first == geom || call.second == geom;
    if (gone) release(call);
    return gone;
  });
}

void Collisions::clear() {
  for (const Call& call : calls_) release(call);
  calls_.clear();
  too_many_ = false;
}

bool Collisions::can_be_repeated(const void* frame_of_step) const {
  if (too_many_) return false;
  for (const Call& call : calls_) {
    if (in_a_frame_that_is_gone(call.data, frame_of_step)) return false;
  }
  return true;
}

void Collisions::repeat(dWorldID world, bool only_world) const {
  const std::vector<Call> calls = calls_;  // a callback may destroy a geom
  for (const Call& call : calls) {
    const bool its =
        only_world || has_body_of(call.first, world) || (call.second != nullptr && has_body_of(call.second, world));
    if (!its) continue;
    if (call.second == nullptr) {
      ODEVAL_OWN(dSpaceCollide)(reinterpret_cast<dSpaceID>(call.first), call.data, call.callback);
    } else {
      ODEVAL_OWN(dSpaceCollide2)(call.first, call.second, call.data, call.callback);
    }
  }
}

}  // namespace odeval::audit
