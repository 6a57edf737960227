#include "reference/cvode_solver.hpp"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_version.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "odeval/error.hpp"
#include "reference/sundials.hpp"

namespace odeval::reference {
namespace {

std::string flag_name(int flag) {
  const std::unique_ptr<char, decltype(&std::free)> name(CVodeGetReturnFlagName(flag), &std::free);
  return name ? name.get() : "unknown flag";
}

}  // namespace

void CvodeSolver::FreeMemory::operator()(void* memory) const { CVodeFree(&memory); }

CvodeSolver::CvodeSolver(std::size_t size, RightSide right_side, Tolerances tolerances, std::string scenario,
                         double duration_s)
    : right_side_(std::move(right_side)),
      size_(size),
      tolerances_(tolerances),
      scenario_(std::move(scenario)),
      duration_s_(duration_s),
      context_(make_sundials_context()),
      y_(N_VNew_Serial(static_cast<sunindextype>(size), context_.get())),
      between_(N_VNew_Serial(static_cast<sunindextype>(size), context_.get())),
      iteration_(y_ ? SUNNonlinSol_FixedPoint(y_.get(), 0, context_.get()) : nullptr),
      cvode_(CVodeCreate(CV_ADAMS, context_.get())) {
  if (!y_ || !between_ || !iteration_ || !cvode_) throw MachineError("CVODE: out of memory");
  N_VConst(0.0, y_.get());
  keep_last_message(context_.get(), cvode_.get(), message_);
  check(CVodeInit(cvode_.get(), evaluate, 0.0, y_.get()), "CVodeInit");
  check(CVodeSetUserData(cvode_.get(), this), "CVodeSetUserData");
  check(CVodeSStolerances(cvode_.get(), tolerances.rtol, tolerances.atol), "CVodeSStolerances");
  check(CVodeSetNonlinearSolver(cvode_.get(), iteration_.get()), "CVodeSetNonlinearSolver");
}

void CvodeSolver::follow_sensitivities(Jacobian jacobian) {
  const int count = static_cast<int>(size_);
  jacobian_ = std::move(jacobian);
  jacobian_values_.resize(size_ * size_);
  sensitivities_ = {N_VCloneVectorArray(count, y_.get()), FreeVectors{count}};
  joint_iteration_.reset(SUNNonlinSol_FixedPointSens(count + 1, y_.get(), 0, context_.get()));
  if (!sensitivities_ || !joint_iteration_) throw MachineError("CVODE: out of memory");
  set_identity();
  check(CVodeSensInit(cvode_.get(), count, CV_SIMULTANEOUS, evaluate_sensitivities, sensitivities_.get()),
        "CVodeSensInit");
  std::vector<double> absolute(size_, tolerances_.atol);
  check(CVodeSensSStolerances(cvode_.get(), tolerances_.rtol, absolute.data()), "CVodeSensSStolerances");
  check(CVodeSetSensErrCon(cvode_.get(), SUNTRUE), "CVodeSetSensErrCon");
  check(CVodeSetNonlinearSolverSensSim(cvode_.get(), joint_iteration_.get()), "CVodeSetNonlinearSolverSensSim");
}

void CvodeSolver::set_identity() {
  for (std::size_t j = 0; j < size_; ++j) {
    N_VConst(0.0, sensitivities_[j]);
    N_VGetArrayPointer(sensitivities_[j])[j] = 1;
  }
}

void CvodeSolver::start(double t, const double* y) {
  std::copy_n(y, size_, N_VGetArrayPointer(y_.get()));
  check(CVodeReInit(cvode_.get(), t, y_.get()), "CVodeReInit");
  if (sensitivities_) {
    set_identity();
    check(CVodeSensReInit(cvode_.get(), CV_SIMULTANEOUS, sensitivities_.get()), "CVodeSensReInit");
  }
  end_ = t;
}

void CvodeSolver::step() {
  double reached = end_;
  // The target only tells CVODE the direction and the scale of its first step.
  const double target = end_ + std::max(duration_s_, 1e-3);
  const int flag = CVode(cvode_.get(), target, y_.get(), &reached, CV_ONE_STEP);
  if (flag < 0) give_up(flag);
  end_ = reached;
  ++steps_;
}

void CvodeSolver::end_by(double t) { check(CVodeSetStopTime(cvode_.get(), t), "CVodeSetStopTime"); }

void CvodeSolver::interpolate(double t, double* y) const {
  check(CVodeGetDky(cvode_.get(), t, 0, between_.get()), "CVodeGetDky");
  std::copy_n(N_VGetArrayPointer(between_.get()), size_, y);
}

CvodeSolver::Polynomial CvodeSolver::polynomial() const {
  Polynomial last;
  int order = 0;
  check(CVodeGetLastOrder(cvode_.get(), &order), "CVodeGetLastOrder");
  check(CVodeGetLastStep(cvode_.get(), &last.step_s), "CVodeGetLastStep");
  check(CVodeGetCurrentTime(cvode_.get(), &last.end_s), "CVodeGetCurrentTime");
  double scale = 1;  // step^k / k!
  for (int k = 0; k <= order; scale *= last.step_s / ++k) {
    check(CVodeGetDky(cvode_.get(), last.end_s, k, between_.get()), "CVodeGetDky");
    const double* const derivative = N_VGetArrayPointer(between_.get());
    for (std::size_t i = 0; i < size_; ++i) last.coefficients.push_back(scale * derivative[i]);
  }
  return last;
}

void CvodeSolver::Polynomial::at(double t, double* y, std::size_t size) const {
  const double part = (t - end_s) / step_s;
  std::fill_n(y, size, 0.0);
  for (std::size_t from = coefficients.size(); from > 0;) {
    from -= size;
    for (std::size_t i = 0; i < size; ++i) y[i] = y[i] * part + coefficients[from + i];
  }
}

void CvodeSolver::interpolate_sensitivities(double t, double* transition) const {
  for (std::size_t j = 0; j < size_; ++j) {
    check(CVodeGetSensDky1(cvode_.get(), t, 0, static_cast<int>(j), between_.get()), "CVodeGetSensDky1");
    const double* column = N_VGetArrayPointer(between_.get());
    for (std::size_t i = 0; i < size_; ++i) transition[i * size_ + j] = column[i];
  }
}

std::string CvodeSolver::version() {
  std::array<char, 32> text{};
  SUNDIALSGetVersion(text.data(), static_cast<int>(text.size()));
  return text.data();
}

int CvodeSolver::evaluate(double t, N_Vector y, N_Vector dydt, void* self) {
  auto& solver = *static_cast<CvodeSolver*>(self);
  double* slope = N_VGetArrayPointer(dydt);
  solver.right_side_(t, N_VGetArrayPointer(y), slope);
  ++solver.evaluations_;
  const bool finite = std::all_of(slope, slope + solver.size_, [](double value) { return std::isfinite(value); });
  return finite ? 0 : 1;  // 1: CVODE may try a smaller step
}

int CvodeSolver::evaluate_sensitivities(int count, double, N_Vector y, N_Vector, N_Vector* s, N_Vector* dsdt,
                                        void* self, N_Vector, N_Vector) {
  auto& solver = *static_cast<CvodeSolver*>(self);
  const std::size_t size = solver.size_;
  solver.jacobian_(N_VGetArrayPointer(y), solver.jacobian_values_.data());
  for (int k = 0; k < count; ++k) {
    const double* const at = N_VGetArrayPointer(s[k]);
    double* const rate = N_VGetArrayPointer(dsdt[k]);
    for (std::size_t i = 0; i < size; ++i) {
      rate[i] = 0;
      for (std::size_t j = 0; j < size; ++j) rate[i] += solver.jacobian_values_[i * size + j] * at[j];
      if (!std::isfinite(rate[i])) return 1;
    }
  }
  return 0;
}

void CvodeSolver::check(int flag, const char* call) const {
  if (flag >= 0) return;
  throw MachineError("CVODE for '" + scenario_ + "': " + call + " failed with " + flag_name(flag) + ": " + message_);
}

void CvodeSolver::give_up(int flag) const {
  std::ostringstream text;
  text.precision(4);
  text << "CVODE for '" << scenario_ << "' stopped at t = " << end_ << " of " << duration_s_
       << " s: " << flag_name(flag) << " (" << flag << ") at rtol " << tolerances_.rtol;
  if (tolerances_.settable) text << "; try rtol " << 10 * tolerances_.rtol;
  throw MachineError(text.str());
}

}  // namespace odeval::reference
