#pragma once
// CVODE as an object: Adams formulas with fixed-point iteration, one step at a time; on request with the sensitivities
// of the state. All of it is CVODES, which is CVODE where no sensitivities are asked for.
#include <sundials/sundials_context.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace odeval::reference {

struct Tolerances {
  double rtol;
  double atol;
  bool settable = false;  // by the scenario, so that a failure can be answered with another rtol
};

/// Integrates y' = f(t, y). After `start`, every `step` moves end() on by one of CVODE's own steps.
/// All failures are MachineErrors; nothing is printed.
class CvodeSolver {
 public:
  using RightSide = std::function<void(double t, const double* y, double* dydt)>;
  /// df_i/dy_j, by rows.
  using Jacobian = std::function<void(const double* y, double* jacobian)>;

  /// `scenario` and `duration_s` are for messages and the first guess of the step only.
  CvodeSolver(std::size_t size, RightSide right_side, Tolerances tolerances, std::string scenario, double duration_s);

  /// From the next `start` on, moves the derivatives of the state with respect to the state at that start as well:
  /// P' = J(y) P, P = 1 at first. They are held to the same relative tolerance as the state, and to its absolute one.
  void follow_sensitivities(Jacobian jacobian);

  /// Forgets the past and begins at y (`size` values).
  void start(double t, const double* y);
  /// One of CVODE's own, which ends no later than a time that was set since the last one.
  void step();
  /// For the next step alone, later than end().
  void end_by(double t);

  double end() const { return end_; }
  /// The state at end(), until the next step.
  const double* state() const { return N_VGetArrayPointer(y_.get()); }
  /// The state at a time of the last step, from the formula's own polynomial.
  void interpolate(double t, double* y) const;
  /// That polynomial, to be kept: in powers of (t - end_s) / step_s, so many numbers each as a state has.
  struct Polynomial {
    double end_s = 0;
    double step_s = 0;
    std::vector<double> coefficients = {};

    void at(double t, double* y, std::size_t size) const;
  };
  Polynomial polynomial() const;

  /// P at a time of the last step, size x size, by rows: column j is d(state)/d(start_j).
  void interpolate_sensitivities(double t, double* transition) const;

  static std::string version();
  long steps() const { return steps_; }
  long evaluations() const { return evaluations_; }

 private:
  struct FreeContext {
    void operator()(SUNContext context) const { SUNContext_Free(&context); }
  };
  struct FreeMemory {
    void operator()(void* memory) const;
  };
  struct FreeVector {
    void operator()(N_Vector vector) const { N_VDestroy(vector); }
  };
  struct FreeVectors {
    int count;
    void operator()(N_Vector* vectors) const { N_VDestroyVectorArray(vectors, count); }
  };
  struct FreeIteration {
    void operator()(SUNNonlinearSolver solver) const { SUNNonlinSolFree(solver); }
  };
  template <class Handle, class Free>
  using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Free>;

  void set_identity();
  static int evaluate(double t, N_Vector y, N_Vector dydt, void* self);
  static int evaluate_sensitivities(int count, double t, N_Vector y, N_Vector dydt, N_Vector* s, N_Vector* dsdt,
                                    void* self, N_Vector, N_Vector);
  void check(int flag, const char* call) const;
  [[noreturn]] void give_up(int flag) const;

  RightSide right_side_;
  Jacobian jacobian_;
  std::vector<double> jacobian_values_;
  std::size_t size_;
  Tolerances tolerances_;
  std::string scenario_;
  double duration_s_;
  std::string message_;  // CVODE's own words, kept for ours
  double end_ = 0;
  long steps_ = 0;
  long evaluations_ = 0;

  // Freed in reverse: the context outlives all that was made in it.
  Owned<SUNContext, FreeContext> context_;
  Owned<N_Vector, FreeVector> y_;
  Owned<N_Vector, FreeVector> between_;
  Owned<SUNNonlinearSolver, FreeIteration> iteration_;
  std::unique_ptr<N_Vector[], FreeVectors> sensitivities_;
  Owned<SUNNonlinearSolver, FreeIteration> joint_iteration_;  // of state and sensitivities
  std::unique_ptr<void, FreeMemory> cvode_;
};

}  // namespace odeval::reference
