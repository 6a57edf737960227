#include "audit/preload/softness.hpp"

#include <algorithm>
#include <cmath>

namespace odeval::audit {
namespace {

using Get = dReal (*)(dJointID, int);
using Set = void (*)(dJointID, int, dReal);

struct Pair {
  int erp;
  int cfm;
};
constexpr Pair whole{dParamERP, dParamCFM};
constexpr Pair stop{dParamStopERP, dParamStopCFM};
constexpr Pair suspension{dParamSuspensionERP, dParamSuspensionCFM};

/// Which springs a kind of joint has of its own, in so many groups of parameters. The CFM of a motor is a damper,
/// 1/CFM at any step, the springs of a plane2d are the world's, and an lmotor has no stops, whatever it is told.
struct Springs {
  dJointType type;
  Get get;
  Set set;
  Pair pair;
  int groups;
};
constexpr std::array springs{
    Springs{dJointTypeBall, dJointGetBallParam, dJointSetBallParam, whole, 1},
    Springs{dJointTypeDBall, dJointGetDBallParam, dJointSetDBallParam, whole, 1},
    Springs{dJointTypeDHinge, dJointGetDHingeParam, dJointSetDHingeParam, whole, 1},
    Springs{dJointTypeFixed, dJointGetFixedParam, dJointSetFixedParam, whole, 1},
    Springs{dJointTypeTransmission, dJointGetTransmissionParam, dJointSetTransmissionParam, whole, 1},
    Springs{dJointTypeHinge, dJointGetHingeParam, dJointSetHingeParam, stop, 1},
    Springs{dJointTypeSlider, dJointGetSliderParam, dJointSetSliderParam, stop, 1},
    Springs{dJointTypeUniversal, dJointGetUniversalParam, dJointSetUniversalParam, stop, 2},
    Springs{dJointTypeHinge2, dJointGetHinge2Param, dJointSetHinge2Param, stop, 2},
    Springs{dJointTypeHinge2, dJointGetHinge2Param, dJointSetHinge2Param, suspension, 1},
    Springs{dJointTypePR, dJointGetPRParam, dJointSetPRParam, stop, 2},
    Springs{dJointTypePU, dJointGetPUParam, dJointSetPUParam, stop, 3},
    Springs{dJointTypePiston, dJointGetPistonParam, dJointSetPistonParam, stop, 2},
    Springs{dJointTypeAMotor, dJointGetAMotorParam, dJointSetAMotorParam, stop, 3},
};

Set setter(dJointType type) {
  return std::find_if(springs.begin(), springs.end(), [type](const Springs& row) { return row.type == type; })->set;
}

void change(Joint& joint, const Springs& row, int k) {
  for (int group = 0; group < row.groups; ++group) {
    const int erp = group * dParamGroup + row.pair.erp;
    const int cfm = group * dParamGroup + row.pair.cfm;
    const Softness before{row.get(joint.id, erp), row.get(joint.id, cfm)};
    const Softness part = at_part_of_step(before, k);
    joint.changed.push_back({erp, before.erp});
    joint.changed.push_back({cfm, before.cfm});
    row.set(joint.id, erp, part.erp);
    row.set(joint.id, cfm, part.cfm);
  }
}

/// What a velocity keeps in a step of h is the product of what it keeps in k parts of it.
dReal scale_at_part(dReal scale, int k) { return 1 - std::pow(1 - scale, dReal(1) / k); }

}  // namespace

// With kp/kd = e / (h (1 - e)) the step h/k gives e' = (e/k) / (1 - e + e/k), and 1/CFM' = (h/k) kp + kd.
Softness at_part_of_step(Softness at_h, int k) {
  const dReal part = at_h.erp / k;
  const dReal sum = 1 - at_h.erp + part;
  return sum > 0 ? Softness{part / sum, at_h.cfm / sum} : at_h;
}

Softness softness_of(const dSurfaceParameters& surface, dWorldID world) {
  return {(surface.mode & dContactSoftERP) != 0 ? surface.soft_erp : dWorldGetERP(world),
          (surface.mode & dContactSoftCFM) != 0 ? surface.soft_cfm : dWorldGetCFM(world)};
}

void soften(dSurfaceParameters& surface, Softness world, int k) {
  const bool own_erp = (surface.mode & dContactSoftERP) != 0;
  const bool own_cfm = (surface.mode & dContactSoftCFM) != 0;
  if (!own_erp && !own_cfm) return;
  const Softness part =
      at_part_of_step({own_erp ? surface.soft_erp : world.erp, own_cfm ? surface.soft_cfm : world.cfm}, k);
  surface.mode |= dContactSoftERP | dContactSoftCFM;
  surface.soft_erp = part.erp;
  surface.soft_cfm = part.cfm;
}

Softened::Softened(World& world, int k)
    : world_(world), k_(k), before_{dWorldGetERP(world.id), dWorldGetCFM(world.id)} {
  const Softness part = at_part_of_step(before_, k);
  dWorldSetERP(world.id, part.erp);
  dWorldSetCFM(world.id, part.cfm);
  joints(world, k);
  for (Body& body : world.bodies) take_own_numbers(body);
  world.softened = this;
}

void Softened::joints(World& world, int k) {
  for (Joint& joint : world.joints) {
    for (const Springs& row : springs) {
      if (row.type == joint.type) change(joint, row, k);
    }
  }
}

void Softened::take_own_numbers(Body& body) const {
  body.damping = {dBodyGetLinearDamping(body.id), dBodyGetAngularDamping(body.id)};
  body.steps_to_rest = dBodyGetAutoDisableSteps(body.id);
  if (body.damping[0] != 0) dBodySetLinearDamping(body.id, scale_at_part(body.damping[0], k_));
  if (body.damping[1] != 0) dBodySetAngularDamping(body.id, scale_at_part(body.damping[1], k_));
  dBodySetAutoDisableSteps(body.id, body.steps_to_rest * k_);
}

void Softened::give_own_numbers(Body& body) const {
  if (body.steps_to_rest < 0) return;  // a callback has made it since
  if (body.damping[0] != 0) dBodySetLinearDamping(body.id, body.damping[0]);
  if (body.damping[1] != 0) dBodySetAngularDamping(body.id, body.damping[1]);
  dBodySetAutoDisableSteps(body.id, body.steps_to_rest);
  body.damping = {};
  body.steps_to_rest = -1;
}

Softened::~Softened() {
  world_.softened = nullptr;
  dWorldSetERP(world_.id, before_.erp);
  dWorldSetCFM(world_.id, before_.cfm);
  for (Joint& joint : world_.joints) {
    for (const Changed& one : joint.changed) setter(joint.type)(joint.id, one.parameter, one.before);
    joint.changed.clear();
  }
  for (Body& body : world_.bodies) give_own_numbers(body);
}

}  // namespace odeval::audit
