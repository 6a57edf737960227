// A motion's memory: samples of every shape hold what was written, each in its own place, and none costs an allocation.
#include <cstdlib>
#include <new>

#include "odeval/motion.hpp"
#include "tests/check.hpp"

namespace {

long allocations = 0;

}  // namespace

// Every allocation of the program is counted.
void* operator new(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

using namespace odeval;

/// Calls `visit` with every number of a sample.
template <class S, class Visit>
void each_number(const S& sample, const Visit& visit) {
  const auto all = [&](auto& numbers) {
    for (auto& number : numbers) visit(number);
  };
  for (auto& body : sample.bodies) {
    all(body.position);
    all(body.rotation);
    all(body.velocity);
    all(body.spin);
    visit(body.angle);
  }
  for (auto& joint : sample.joints) all(joint.force);
  all(sample.q);
  all(sample.qd);
  visit(sample.contacts);
}

void check_shape(const SampleShape& shape) {
  constexpr std::size_t samples = 5;
  Motion motion(shape, samples);
  CHECK_EQUAL(motion.size(), 0u);
  Recorder recorder(motion);
  CHECK(static_cast<bool>(recorder));

  // Each number is another one; if two shared a place, the first would not be there any more.
  double next = 1;
  bool zeros = true;
  for (std::size_t k = 0; k < samples; ++k) {
    const long before = allocations;
    const Sample sample = recorder.next();
    CHECK_EQUAL(allocations, before);
    CHECK_EQUAL(motion.size(), k + 1);
    CHECK_EQUAL(sample.bodies.size(), shape.bodies);
    CHECK_EQUAL(sample.joints.size(), shape.joints);
    CHECK_EQUAL(sample.q.size(), shape.coordinates);
    CHECK_EQUAL(sample.qd.size(), shape.coordinates);
    each_number(sample, [&](double& number) {
      zeros = zeros && number == 0;
      number = next++;
    });
  }
  CHECK(zeros);
  CHECK_EQUAL(next - 1,
              static_cast<double>(samples * (19 * shape.bodies + 3 * shape.joints + 2 * shape.coordinates + 1)));

  double wanted = 1;
  bool kept = true;
  const Motion& read = motion;
  for (std::size_t k = 0; k < samples; ++k) {
    each_number(read[k], [&](const double& number) { kept = kept && number == wanted++; });
  }
  CHECK(kept);

  // A sample that is there already, and no other, is changed in its place.
  recorder.at(2).contacts = -1;
  CHECK_EQUAL(motion.size(), samples);
  CHECK_EQUAL(read[2].contacts, -1.0);
  CHECK(read[1].contacts > 0 && read[3].contacts > 0);
}

}  // namespace

int main() {
  check_shape({.bodies = 3, .joints = 2, .coordinates = 0});
  check_shape({.bodies = 1, .joints = 4, .coordinates = 0});
  check_shape({.bodies = 0, .joints = 0, .coordinates = 2});
  check_shape({.bodies = 2, .joints = 1, .coordinates = 3});
  check_shape({});
  CHECK(!static_cast<bool>(Recorder()));
  CHECK(allocations > 0);  // or nothing was counted
  return test::verdict();
}
