#pragma once
// What a robot's file says (URDF, SDFormat), as it says it: links in frames of their own, joints between them.
//
// A scenario is made of it (src/model), and what KDL makes of the same is held beside that scenario (reference/tree).
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "odeval/frame.hpp"

namespace odeval {

/// Links on joints. Numbers of links and joints are places in these lists.
struct Robot {
  /// Six numbers about the centre of mass: xx, yy, zz, xy, xz, yz.
  using Inertia = std::array<double, 6>;

  struct Mass {
    double mass_kg = 0;
    Frame frame;           // of the centre of mass, in the link's
    Inertia inertia_kgm2;  // along that frame's axes
  };
  /// What a link may touch with.
  struct Solid {
    enum class Form { box, sphere, cylinder, capsule, plane, mesh, other };
    Form form = Form::box;
    Frame frame;          // of its centre, in the link's
    Vec3 sides_m{};       // of the box around it, along its own axes; a cylinder's and a capsule's way is z
    std::string file{};   // of a mesh, as it is named; of another form its name
    Vec3 scale{1, 1, 1};  // of a mesh
    std::string name{};   // as the file calls it; empty: it does not
  };
  struct Link {
    std::string name;
    std::optional<Mass> mass = {};
    std::vector<Solid> solids = {};
  };
  /// What stops, brakes and loads a motion of a joint.
  struct Acting {
    std::optional<std::pair<double, double>> limits_q = {};  // rad or m
    double damping = 0;                                      // N m s/rad or N s/m
    double friction = 0;                                     // N m or N
    double stiffness = 0;                                    // N m/rad or N/m
    double rest = 0;                                         // rad or m, of that spring
  };
  struct Joint {
    enum class Kind { fixed, hinge, slider, ball, universal, free };
    std::string name;
    Kind kind = Kind::fixed;
    std::optional<std::size_t> parent;  // number of a link before it; absent: the world
    Frame frame;                        // of the joint in the parent's, when all joints are at 0
    Frame link;                         // of the child, in the joint's
    Vec3 axis{1, 0, 0};                 // unit, in the joint's frame; of a universal joint the parent's
    Vec3 axis2{0, 1, 0};                // of a universal joint the child's
    Acting acting{};                    // of a universal joint about the parent's axis
    Acting acting2{};                   // of a universal joint about the child's
    double start = 0;                   // where it stands at t = 0, rad or m; of a universal joint at 0
  };
  /// What is read by a rule that is worth saying, or not at all.
  struct Remark {
    std::string what;               // "visual shapes"
    std::string rule;               // "not taken: ..."
    std::vector<std::string> of{};  // names of links, joints or elements
  };

  std::string name;
  std::string format;  // "URDF", "SDFormat 1.6"
  std::vector<Link> links;
  std::vector<Joint> joints;  // one a link, of the same number: what it hangs on, from the world outwards
  std::vector<Remark> remarks;
  std::vector<std::pair<std::string, std::string>> settings{};  // keys of a scenario file and their values as in one
  double gravity = 9.81;                                        // m/s², along -z

  /// Adds a name to the remark of that text.
  void remark(const std::string& what, const std::string& rule, const std::string& of) {
    for (Remark& known : remarks) {
      if (known.what != what || known.rule != rule) continue;
      known.of.push_back(of);
      return;
    }
    remarks.push_back({what, rule, {of}});
  }
};

}  // namespace odeval
