#include "engines/mujoco/mujoco_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "engines/mujoco/model_text.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_mujoco {
namespace {

using engine_tree::Degree;
using engine_tree::Hanging;
using engine_tree::Lost;
using engine_tree::Placed;

// MuJoCo would end the program at an error, and write a file of its warnings where it stands.
void fail(const char* message) { throw MachineError(std::string("MuJoCo: ") + message); }
void ignore(const char*) {}

mjModel* compiled(const std::string& text) {
  const char* const file = "mechanism.xml";
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
#if mjVERSION_HEADER < 314
  mj_makeEmptyFileVFS(files.get(), file, static_cast<int>(text.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), file)], text.data(), text.size());
#else
  mj_addBufferVFS(files.get(), file, text.data(), static_cast<int>(text.size()));
#endif
  std::array<char, 500> error{};
  mjModel* const model = mj_loadXML(file, files.get(), error.data(), static_cast<int>(error.size()));
  mj_deleteVFS(files.get());
  if (model == nullptr) fail(error.data());
  return model;
}

/// Every option of MuJoCo's, those that no setting says as MuJoCo has them.
void set(mjOption& options, const Scenario& scenario, double step_s, int integrator) {
  mj_defaultOption(&options);
  options.timestep = step_s;
  options.gravity[0] = 0;
  options.gravity[1] = 0;
  options.gravity[2] = -scenario.gravity;
  options.integrator = integrator;
  for (double& wind : options.wind) wind = 0;
  options.density = 0;
  options.viscosity = 0;
  options.solver = mjSOL_NEWTON;
  options.iterations = 100;
  options.tolerance = 1e-8;
  options.impratio = 1;
  options.cone = scenario.mujoco.elliptic ? mjCONE_ELLIPTIC : mjCONE_PYRAMIDAL;
  options.jacobian = mjJAC_AUTO;
  options.noslip_iterations = 0;
  options.disableflags = 0;
  options.enableflags = 0;
}

}  // namespace

MujocoWorld::MujocoWorld(const Scenario& scenario, double step_s, int integrator)
    : mechanism_(scenario.mechanism),
      tree_(engine_tree::hang(mechanism_, &closing_)),
      time_constant_s_(scenario.mujoco.time_constant_s),
      bodies_(mechanism_.bodies.size()) {
  mju_user_error = &fail;
  mju_user_warning = &ignore;
  model_.reset(compiled(model_text(mechanism_, tree_, closing_, time_constant_s_)));
  set(model_->opt, scenario, step_s, integrator);
  data_.reset(mj_makeData(model_.get()));
  // Less than two steps MuJoCo itself does not take (refsafe) where softness is told by a time constant and not, as
  // here, by numbers.
  const auto* const limited = model_->jnt_limited;
  const bool soft = model_->npair > 0 || model_->neq > 0 ||
                    std::any_of(limited, limited + model_->njnt, [](auto is) { return is != 0; });
  too_stiff_ = soft && time_constant_s_ < 2 * step_s;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    number_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, name_of(i).c_str()));
  }
  look_for_loads();
  start();
}

MujocoWorld::~MujocoWorld() = default;

void MujocoWorld::look_for_loads() {
  for (const Hanging& hanging : tree_) {
    if (hanging.degrees.size() != 1) continue;
    const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, (name_of(hanging.body) + "d0").c_str());
    loads_.add(mechanism_.joints[*hanging.joint], {model_->jnt_qposadr[joint], model_->jnt_dofadr[joint]});
  }
  if (loads_.empty() && mechanism_.contacts.empty()) return;
  MujocoWorld* const self = this;
  static_assert(sizeof self == sizeof(mjtNum));
  std::memcpy(data_->userdata, &self, sizeof self);
  mjcb_passive = &in_stage;  // of all worlds of the process
}

// A free joint's speeds are the velocity in the world and the spin in the body; a ball's spin is in the body as well.
void MujocoWorld::start() {
  for (const Hanging& hanging : tree_) {
    mjtNum* speed = data_->qvel + model_->body_dofadr[number_[hanging.body]];
    if (!hanging.joint) {
      for (const double v : mechanism_.bodies[hanging.body].velocity_m_s) *speed++ = v;
    }
    if (!hanging.joint || hanging.ball) {
      for (const double w : hanging.place.in_body(hanging.spin_rad_s)) *speed++ = w;
    }
    for (const Degree& degree : hanging.degrees) *speed++ = degree.rate;
  }
}

void MujocoWorld::in_stage(const mjModel* model, mjData* data) {
  MujocoWorld* self = nullptr;
  if (model->nuserdata == 0) return;  // another's world
  std::memcpy(&self, data->userdata, sizeof self);
  if (self == nullptr) return;
  self->look_for_contacts();
  self->loads_.apply(
      self->from_s_ + (data->time - self->from_by_clock_), [self](const Coordinate& at) { return self->way(at); },
      [self](const Coordinate& at) { return self->rate(at); },
      [data](const Coordinate& at, double force) { data->qfrc_passive[at.speed] += force; });
}

// MuJoCo starts anew when a number is lost, and only its count of warnings tells.
long MujocoWorld::step(double from, double) {
  // Of a run by itself the command line tells before; a search of steps passes by here.
  if (too_stiff_) throw Lost("mujoco.time_constant is less than two steps");
  from_s_ = from;
  from_by_clock_ = data_->time;
  touched_ = {};
  if (!loads_.empty()) {
    loads_.sample(
        from, [this](const Coordinate& at) { return way(at); }, [this](const Coordinate& at) { return rate(at); });
  }
  mj_step(model_.get(), data_.get());
  for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
    if (data_->warning[warning].number > 0) throw Lost("MuJoCo found a number beyond 1e10, or none");
  }
  for (const int warning : {mjWARN_CONTACTFULL, mjWARN_CNSTRFULL}) {
    if (data_->warning[warning].number > 0) throw Lost("MuJoCo had no room for all contacts");
  }
  return 1;
}

const std::vector<Placed>& MujocoWorld::bodies() {
  mj_kinematics(model_.get(), data_.get());
  mj_comPos(model_.get(), data_.get());
  mj_comVel(model_.get(), data_.get());
  double sum = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Placed& body = bodies_[i];
    const std::size_t number = static_cast<std::size_t>(number_[i]);
    std::array<mjtNum, 6> velocity{};  // turning, then moving
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_XBODY, number_[i], velocity.data(), 0);
    for (std::size_t k = 0; k < 3; ++k) {
      body.position_m[k] = data_->xpos[3 * number + k];
      body.spin_rad_s[k] = velocity[k];
      body.velocity_m_s[k] = velocity[3 + k];
    }
    for (std::size_t k = 0; k < 9; ++k) body.rotation[k] = data_->xmat[9 * number + k];
    sum += dot(body.velocity_m_s, body.velocity_m_s) + dot(body.spin_rad_s, body.spin_rad_s);
  }
  engine_tree::require_finite(sum);
  return bodies_;
}

// After a step MuJoCo has the contacts of its last stage alone: what it pushed off in the first would be none.
void MujocoWorld::look_for_contacts() {
  long contacts = 0;
  for (int k = 0; k < data_->ncon; ++k) {
    if (data_->contact[k].dist > 0) continue;
    ++contacts;
    touched_.depth = std::fmax(touched_.depth, -data_->contact[k].dist);
  }
  touched_.contacts = std::max(touched_.contacts, contacts);
}

// Of the axes of a contact the first points from its first thing to its second.
std::vector<Vec3> MujocoWorld::contact_forces() {
  if (mechanism_.contacts.empty()) return {};
  std::vector<Vec3> forces(bodies_.size());
  for (int k = 0; k < data_->ncon; ++k) {
    const mjContact& contact = data_->contact[k];
    std::array<mjtNum, 6> along{};  // its axes, then about them
    mj_contactForce(model_.get(), data_.get(), k, along.data());
    Vec3 force{};
    for (std::size_t d = 0; d < 9; ++d) force[d % 3] += contact.frame[d] * along[d / 3];
    for (const auto& [geom, sign] : {std::pair{contact.geom1, -1.0}, std::pair{contact.geom2, 1.0}}) {
      const auto body = std::ranges::find(number_, model_->geom_bodyid[geom]);
      if (body == number_.end()) continue;  // what stands
      Vec3& of_body = forces[static_cast<std::size_t>(body - number_.begin())];
      of_body = of_body + sign * force;
    }
  }
  return forces;
}

// The rows of a loop's equations come in their order; of each the first three are of a point, in the world.
std::vector<Vec3> MujocoWorld::closing_forces() {
  std::vector<Vec3> forces;
  int equation = 0;
  for (const std::size_t number : closing_) {
    const int next = equation + equations_of(mechanism_.joints[number].kind);
    Vec3& force = forces.emplace_back();
    int row = 0;
    for (; equation < next; ++equation) {
      while (row < data_->nefc && !(data_->efc_type[row] == mjCNSTR_EQUALITY && data_->efc_id[row] == equation)) ++row;
      for (std::size_t k = 0; k < 3; ++k) force[k] += data_->efc_force[row + static_cast<int>(k)];
    }
  }
  return forces;
}

namespace {

/// "-250000 -1000", and "; " between rows that differ.
std::string rows_of(const mjtNum* numbers, int rows, int width) {
  std::vector<std::string> different;
  for (int row = 0; row < rows; ++row) {
    std::string text;
    for (int k = 0; k < width; ++k) {
      std::array<char, 32> digits{};
      std::snprintf(digits.data(), digits.size(), k == 0 ? "%.15g" : " %.15g", numbers[row * width + k]);
      text += digits.data();
    }
    if (std::ranges::find(different, text) == different.end()) different.push_back(std::move(text));
  }
  std::string all;
  for (const std::string& text : different) all += (all.empty() ? "" : "; ") + text;
  return all;
}

/// How soft the constraints of one kind are, where there are any: MuJoCo's solref and solimp.
void tell_softness(Told& told, const std::string& kind, const mjtNum* reference, const mjtNum* impedance, int rows) {
  if (rows == 0) return;
  told.push_back({kind + "_solref", rows_of(reference, rows, mjNREF)});
  told.push_back({kind + "_solimp", rows_of(impedance, rows, mjNIMP)});
}

}  // namespace

Told MujocoWorld::told() const {
  const mjOption& options = model_->opt;
  const auto of_names = [](int number, auto... names) { return std::string(std::array{names...}.at(number)); };
  Told told{{"version", std::string(mj_versionString())},
            {"integrator", of_names(options.integrator, "Euler", "RK4", "implicit")},
            {"solver", of_names(options.solver, "PGS", "CG", "Newton")},
            {"iterations", std::int64_t{options.iterations}},
            {"tolerance", options.tolerance},
            {"noslip_iterations", std::int64_t{options.noslip_iterations}},
            {"impratio", options.impratio},
            {"cone", of_names(options.cone, "pyramidal", "elliptic")},
            {"jacobian", of_names(options.jacobian, "dense", "sparse", "auto")},
            {"constraint_time_constant", time_constant_s_},
            {"density", options.density},
            {"viscosity", options.viscosity},
            {"disableflags", std::int64_t{options.disableflags}},
            {"enableflags", std::int64_t{options.enableflags}}};
  tell_softness(told, "contact", model_->pair_solref, model_->pair_solimp, static_cast<int>(model_->npair));
  tell_softness(told, "loop", model_->eq_solref, model_->eq_solimp, static_cast<int>(model_->neq));
  for (int joint = 0; joint < model_->njnt; ++joint) {
    if (!model_->jnt_limited[joint]) continue;
    tell_softness(told, "stop_" + std::string(mj_id2name(model_.get(), mjOBJ_JOINT, joint)),
                  model_->jnt_solref + mjNREF * joint, model_->jnt_solimp + mjNIMP * joint, 1);
  }
  return told;
}

}  // namespace odeval::engine_mujoco
