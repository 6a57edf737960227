// MuJoCo alone.
#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>

#include "tests/benchmark/bare_engine.h"

namespace {

// Links lie along their own y; the second is level when the first stands at 45 degrees.
constexpr char pendulum[] =
    "<mujoco><compiler angle='degree'/><option timestep='0.001' gravity='0 0 -9.81'/><worldbody>"
    "<body pos='0 0 2.1' euler='45 0 0'><joint type='hinge' axis='1 0 0'/>"
    "<inertial pos='0 0.5 0' mass='1' diaginertia='0.08416666666666667 0.0016666666666666668 0.08416666666666667'/>"
    "<body name='last' pos='0 1 0' euler='-45 0 0'><joint type='hinge' axis='1 0 0'/>"
    "<inertial pos='0 0.5 0' mass='1' diaginertia='0.08416666666666667 0.0016666666666666668 0.08416666666666667'/>"
    "</body></body></worldbody></mujoco>";

mjModel* model;
mjData* data;

}  // namespace

void bare_create(const char* method) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
#if mjVERSION_HEADER < 314
  mj_makeEmptyFileVFS(files.get(), "pendulum.xml", sizeof pendulum - 1);
  std::memcpy(files->filedata[0], pendulum, sizeof pendulum - 1);
#else
  mj_addBufferVFS(files.get(), "pendulum.xml", pendulum, sizeof pendulum - 1);
#endif
  model = mj_loadXML("pendulum.xml", files.get(), nullptr, 0);
  mj_deleteVFS(files.get());
  model->opt.integrator = std::strstr(method, "rk4") != nullptr        ? mjINT_RK4
                          : std::strstr(method, "implicit") != nullptr ? mjINT_IMPLICIT
                                                                       : mjINT_EULER;
  data = mj_makeData(model);
}

void bare_run(long steps) {
  for (long k = 0; k < steps; ++k) mj_step(model, data);
}

double bare_height() {
  mj_kinematics(model, data);
  return data->xipos[3 * mj_name2id(model, mjOBJ_BODY, "last") + 2];
}

void bare_destroy() {
  mj_deleteData(data);
  mj_deleteModel(model);
}
