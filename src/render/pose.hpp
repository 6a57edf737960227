#pragma once
// Where every link of a scenario is at one sample of a trace.
#include <vector>

#include "odeval/scenario.hpp"
#include "odeval/trace.hpp"

namespace odeval::render {

/// A link's box, or a body's, world frame. The directions are unit vectors, at right angles to each other.
struct LinkPose {
  Vec3 centre_m;
  Vec3 along;   // from the near hinge to the far end, where `length` lies
  Vec3 across;  // in the plane of swing, where `width` lies
  Vec3 hinge;   // where `depth` lies; of a body these three are its z, x and y axes
};

using Pose = std::vector<LinkPose>;  // one a link, in the scenario's order

/// From the bodies' positions and rotations where the trace has them, else from the angles by forward kinematics.
Pose pose_at(const Scenario& scenario, const Trace& trace, std::size_t row);

}  // namespace odeval::render
