#pragma once
// A tree of bodies integrated by CVODE, step by step, cut short where a motor or a stop changes what it does.
//
// Such a moment is located on the solver's own polynomial: a joint strikes its stop or is pressed off it no more, a
// motor reaches its speed or the force it needs for that reaches its limit, bodies meet. Steps end at the known times
// at which controllers look and tables bend. Across a pose at which loops may branch off goes a step of another kind.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reference/cvode_solver.hpp"
#include "reference/tree/passage.hpp"
#include "reference/tree/tree_equations.hpp"

namespace odeval::reference {

/// A piece of a motion, to be kept.
struct TreePiece {
  double end_s;
  Grips grips;
  std::shared_ptr<const LoopChart> chart;
  TreeEquations::State last;                    // at its end
  CvodeSolver::Polynomial way = {};             // of small states; empty: it has no length
  std::shared_ptr<const Passage> passage = {};  // in the place of these

  /// The state at a time of it. Throws MachineError where loops can not be closed.
  TreeEquations::State at(double t) const;
};

class TreeMotion {
 public:
  using State = TreeEquations::State;

  /// What happens at the end of a piece.
  struct Change {
    double t;
    State before;
    State after;
    Grips grips;                                        // from then on
    std::shared_ptr<const LoopChart> chart;             // likewise
    std::function<State(const State&)> jump;            // from before to after, of states beside it as well
    std::function<double(double, const State&)> cause;  // reaches a bound then; empty: the time was known
    std::shared_ptr<const Passage> passage = {};        // takes from before to after, in a time of its own

    double end() const { return passage ? passage->way.end() : t; }
  };

  /// The equations must outlive it.
  TreeMotion(const TreeEquations& equations, const Scenario& scenario, Tolerances tolerances);
  TreeMotion(const TreeMotion&) = delete;
  TreeMotion& operator=(const TreeMotion&) = delete;

  /// On by a piece: one of CVODE's own steps, or a part of one; `end` is how far they have come.
  void advance();
  double end() const { return end_; }
  /// What happens at end(), and what motors and stops did until then.
  const std::optional<Change>& change() const { return change_; }
  const Grips& grips() const { return grips_; }
  /// How many changes there were until end(), but for those at known times.
  long changes() const { return changes_; }

  /// The state at a time of the last piece, before what happens at its end; stays until the next call.
  const State& at(double t);
  /// The last piece; before the first, the start.
  TreePiece piece();
  /// The small states that are integrated until end().
  const std::shared_ptr<const LoopChart>& chart() const { return chart_; }

  long steps() const { return solver_.steps(); }
  long evaluations() const { return solver_.evaluations(); }

 private:
  struct Event {
    double t;
    std::size_t axis;
    std::optional<double> lets_go;  // at this force; absent: strikes or reaches its speed
    bool strikes;
    std::optional<std::size_t> point = {};  // at which bodies meet, in the place of an axis
  };
  /// What falls to 0 at an event, and how fast it changes.
  using Number = std::function<double(double t)>;

  void require_progress();
  double next_known_time() const;
  std::optional<Event> first_event();
  std::optional<Event> first_meeting();
  std::optional<double> first_touch(const TreeEquations::Axis& axis, bool low);
  std::optional<double> first_fall(const Number& height, const Number& rate) const;
  std::optional<double> first_zero(const std::function<double(double)>& margin, double slack);
  void happen(const Event& event);
  void meet(const Event& event);
  void require_clear_start() const;
  void happen_at_known_time();
  void leave_chart();
  std::shared_ptr<const Passage> next_passage();
  void happen(std::shared_ptr<const Passage> passage);
  void require_loops_that_go_on();
  void change_to(Change change);

  const TreeEquations& equations_;
  std::string name_;
  std::string file_;                // for messages
  std::vector<std::string> names_;  // of bodies, likewise
  double step_s_;                   // the scenario's, at which controllers look
  double duration_s_;
  Grips grips_;
  std::shared_ptr<const LoopChart> chart_;
  CvodeSolver solver_;
  State state_;
  State small_;
  std::shared_ptr<const Passage> passage_;  // that the last piece is, in the place of a step
  bool may_pass_;                           // nothing stops or drives a joint, or looks once a step
  double margin_ = 0;                       // of the loops at end_; 0 where it is not known
  double widest_ = 0;                       // the largest so far
  double tried_;                            // the margin at which a passage was tried last
  std::vector<double> bends_;               // of tables, rising
  double begin_ = 0;
  double end_ = 0;
  double marked_s_ = 0;  // end_ when progress was looked at last
  std::optional<Change> change_;
  long changes_ = 0;
  int in_a_row_ = 0;  // changes without a way between them
};

}  // namespace odeval::reference
