// The equations of constraint, and the lines that motors and springs act along.
#include "engines/ode_rk4/mechanism.hpp"

namespace odeval::engine_rk4 {
namespace {

Matrix3d turn_of(std::size_t body, std::span<const Matrix3d> turns) {
  return body == world_body ? Matrix3d(Matrix3d::Identity()) : turns[body];
}
Vector3d position_of(std::size_t body, const State& state) {
  return body == world_body ? Vector3d(Vector3d::Zero()) : state[body].pose.position;
}

}  // namespace

MotorLine line_of(const Joint& joint, const Motor& motor, const State& state, std::span<const Matrix3d> turns) {
  MotorLine line{motor.axis, Vector3d::Zero(), Vector3d::Zero()};
  if (motor.carrier == Motor::Carrier::a) line.axis = turns[joint.a] * motor.axis;
  if (motor.carrier == Motor::Carrier::b) line.axis = turn_of(joint.b, turns) * motor.axis;
  if (motor.midway) {
    if (joint.b == world_body) return line;
    line.on_a = (state[joint.b].pose.position - state[joint.a].pose.position) / 2;
    line.on_b = -line.on_a;
  } else if (motor.slides) {
    line.on_b = turn_of(joint.b, turns) * motor.on_b;
    line.on_a = position_of(joint.b, state) + line.on_b - state[joint.a].pose.position;
  }
  return line;
}

double motor_speed(const Joint& joint, const MotorLine& line, bool slides, const State& state) {
  const auto of = [&](std::size_t body, const Vector3d& arm) {
    if (body == world_body) return 0.0;
    const Twist& twist = state[body].twist;
    return line.axis.dot(slides ? Vector3d(twist.linear + twist.angular.cross(arm)) : twist.angular);
  };
  return of(joint.a, line.on_a) - of(joint.b, line.on_b);
}

MotorLine line_of(const Joint& joint, const Spring& spring, const State& state, std::span<const Matrix3d> turns) {
  const Vector3d on_b = turn_of(joint.b, turns) * spring.on_b;
  return {turns[joint.a] * spring.axis, position_of(joint.b, state) + on_b - state[joint.a].pose.position, on_b};
}

double pull(const Joint& joint, const Spring& spring, const State& state, std::span<const Matrix3d> turns) {
  const MotorLine line = line_of(joint, spring, state, turns);
  const double length = line.axis.dot(line.on_a - turns[joint.a] * spring.on_a);
  return spring.stiffness * length - spring.damping * motor_speed(joint, line, true, state);
}

namespace {

/// Where a joint's two bodies are, and how they move; the world stands still at the origin.
struct Pair {
  Matrix3d turn_a, turn_b;
  Vector3d x_a, x_b, v_a, v_b, w_a, w_b;

  Pair(const Joint& joint, const State& state, std::span<const Matrix3d> turns)
      : turn_a(turns[joint.a]),
        turn_b(Matrix3d::Identity()),
        x_a(state[joint.a].pose.position),
        x_b(Vector3d::Zero()),
        v_a(state[joint.a].twist.linear),
        v_b(Vector3d::Zero()),
        w_a(state[joint.a].twist.angular),
        w_b(Vector3d::Zero()) {
    if (joint.b == world_body) return;
    turn_b = turns[joint.b];
    x_b = state[joint.b].pose.position;
    v_b = state[joint.b].twist.linear;
    w_b = state[joint.b].twist.angular;
  }
};

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

void constrain(const Point& point, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d r_a = now.turn_a * point.on_a;
  const Vector3d r_b = now.turn_b * point.on_b;
  rows.of_a.block<3, 3>(k, 0).setIdentity();
  rows.of_a.block<3, 3>(k, 3) = -cross_matrix(r_a);
  rows.of_b.block<3, 3>(k, 0) = -Matrix3d::Identity();
  rows.of_b.block<3, 3>(k, 3) = cross_matrix(r_b);
  rows.error.segment<3>(k) = now.x_a + r_a - now.x_b - r_b;
  rows.bias.segment<3>(k) = now.w_a.cross(now.w_a.cross(r_a)) - now.w_b.cross(now.w_b.cross(r_b));
}

void constrain(const Square& square, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d p = now.turn_a * square.p;
  const Vector3d n = now.turn_b * square.n;
  const Vector3d row = p.cross(n);
  const Vector3d row_rate = now.w_a.cross(p).cross(n) + p.cross(now.w_b.cross(n));
  rows.of_a.block<1, 3>(k, 3) = row.transpose();
  rows.of_b.block<1, 3>(k, 3) = -row.transpose();
  rows.error[k] = p.dot(n) - square.cosine;
  rows.bias[k] = row_rate.dot(now.w_a - now.w_b);
}

void constrain(const Slide& slide, const Pair& now, Eigen::Index k, JointRows& rows) {
  const auto& [turn_a, turn_b, x_a, x_b, v_a, v_b, w_a, w_b] = now;
  const Vector3d p = turn_a * slide.p;
  const Vector3d r_a = turn_a * slide.on_a;
  const Vector3d r_b = turn_b * slide.on_b;
  const Vector3d apart = x_b + r_b - x_a - r_a;
  const Vector3d apart_rate = v_b + w_b.cross(r_b) - v_a - w_a.cross(r_a);
  rows.of_a.block<1, 3>(k, 0) = -p.transpose();
  rows.of_a.block<1, 3>(k, 3) = (p.cross(apart) - r_a.cross(p)).transpose();
  rows.of_b.block<1, 3>(k, 0) = p.transpose();
  rows.of_b.block<1, 3>(k, 3) = r_b.cross(p).transpose();
  rows.error[k] = p.dot(apart);
  rows.bias[k] = w_a.cross(w_a.cross(p)).dot(apart) + 2 * w_a.cross(p).dot(apart_rate) +
                 p.dot(w_b.cross(w_b.cross(r_b)) - w_a.cross(w_a.cross(r_a)));
}

void constrain(const Distance& distance, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d r_a = now.turn_a * distance.on_a;
  const Vector3d r_b = now.turn_b * distance.on_b;
  const Vector3d apart = now.x_a + r_a - now.x_b - r_b;
  const Vector3d apart_rate = now.v_a + now.w_a.cross(r_a) - now.v_b - now.w_b.cross(r_b);
  const double length = apart.norm();
  const Vector3d n = apart / length;
  rows.of_a.block<1, 3>(k, 0) = n.transpose();
  rows.of_a.block<1, 3>(k, 3) = r_a.cross(n).transpose();
  rows.of_b.block<1, 3>(k, 0) = -n.transpose();
  rows.of_b.block<1, 3>(k, 3) = -r_b.cross(n).transpose();
  rows.error[k] = length - distance.length;
  const double along = n.dot(apart_rate);
  rows.bias[k] = n.dot(now.w_a.cross(now.w_a.cross(r_a)) - now.w_b.cross(now.w_b.cross(r_b))) +
                 (apart_rate.squaredNorm() - along * along) / length;
}

void constrain(const Roll& roll, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d centre = now.turn_a * roll.centre, lowest = centre - roll.radius * roll.normal;
  rows.of_a.block<3, 3>(k, 0).setIdentity();
  rows.of_a.block<3, 3>(k, 3) = -cross_matrix(lowest);
  rows.error.segment<3>(k) = (roll.normal.dot(now.x_a + lowest) - roll.height) * roll.normal;
  rows.bias.segment<3>(k) = now.w_a.cross(now.w_a.cross(centre));
}

void constrain(const Gear& gear, const Pair& now, Eigen::Index k, JointRows& rows) {
  const Vector3d r_a = now.turn_a * gear.on_a, r_b = now.turn_b * gear.on_b;
  const Vector3d n_a = now.turn_a * gear.axis_a, n_b = now.turn_b * gear.axis_b;
  const Vector3d apart = now.x_a + r_a - now.x_b - r_b;
  const Vector3d apart_rate = now.v_a + now.w_a.cross(r_a) - now.v_b - now.w_b.cross(r_b);
  const Vector3d n_a_rate = now.w_a.cross(n_a), n_b_rate = now.w_b.cross(n_b);
  Vector3d line = n_a.cross(n_b), line_rate = n_a_rate.cross(n_b) + n_a.cross(n_b_rate);
  if (!gear.intersects) {
    line = gear.across * apart.cross(n_a) + gear.along * apart;
    line_rate = gear.across * (apart_rate.cross(n_a) + apart.cross(n_a_rate)) + gear.along * apart_rate;
  }
  const double length = line.norm();
  const Vector3d l = line / length;
  rows.of_a.block<1, 3>(k, 0) = l.transpose();
  rows.of_a.block<1, 3>(k, 3) = (r_a.cross(l) + gear.of_a * n_a).transpose();
  rows.of_b.block<1, 3>(k, 0) = -l.transpose();
  rows.of_b.block<1, 3>(k, 3) = (gear.of_b * n_b - r_b.cross(l)).transpose();
  // A wheel's speed about its own axis does not change with the axis.
  rows.bias[k] = (line_rate - l * l.dot(line_rate)).dot(apart_rate) / length +
                 l.dot(now.w_a.cross(now.w_a.cross(r_a)) - now.w_b.cross(now.w_b.cross(r_b)));
}

/// Of a motor that holds its velocity; another one's row says nothing. `alone`: against the world.
void constrain(const Motor& motor, bool alone, const MotorLine& line, const Pair& now, Eigen::Index k,
               JointRows& rows) {
  const Vector3d& n = line.axis;
  const Vector3d carried = motor.carrier == Motor::Carrier::a   ? now.w_a
                           : motor.carrier == Motor::Carrier::b ? now.w_b
                                                                : Vector3d(Vector3d::Zero());
  const Vector3d turning = carried.cross(n);
  if (!motor.slides) {
    rows.of_a.block<1, 3>(k, 3) = n.transpose();
    rows.of_b.block<1, 3>(k, 3) = -n.transpose();
    rows.bias[k] = turning.dot(now.w_a - now.w_b);
    return;
  }
  // The point of b moves through a; that in the middle, through both.
  const Vector3d point_rate = now.v_b + now.w_b.cross(line.on_b);
  const Vector3d apart = now.v_a + now.w_a.cross(line.on_a) - point_rate;
  Vector3d rate_a = point_rate - now.v_a, rate_b = now.w_b.cross(line.on_b);
  if (motor.midway) {
    rate_a = alone ? Vector3d(Vector3d::Zero()) : Vector3d((now.v_b - now.v_a) / 2);
    rate_b = -rate_a;
  }
  rows.of_a.block<1, 3>(k, 0) = n.transpose();
  rows.of_b.block<1, 3>(k, 0) = -n.transpose();
  rows.of_a.block<1, 3>(k, 3) = line.on_a.cross(n).transpose();
  rows.of_b.block<1, 3>(k, 3) = -line.on_b.cross(n).transpose();
  rows.bias[k] = turning.dot(apart) + n.dot(now.w_a.cross(rate_a) - now.w_b.cross(rate_b));
}

}  // namespace

void constrain(const Joint& joint, const State& state, std::span<const Matrix3d> turns, JointRows& rows) {
  const Pair now(joint, state, turns);
  Eigen::Index k = 0;
  for (const Point& point : joint.points) {
    constrain(point, now, k, rows);
    k += 3;
  }
  for (const Square& square : joint.squares) constrain(square, now, k++, rows);
  for (const Slide& slide : joint.slides) constrain(slide, now, k++, rows);
  for (const Distance& distance : joint.distances) constrain(distance, now, k++, rows);
  for (const Gear& gear : joint.gears) constrain(gear, now, k++, rows);
  for (const Roll& roll : joint.rolls) {
    constrain(roll, now, k, rows);
    k += 3;
  }
  for (const Motor& motor : joint.motors) {
    rows.of_a.row(k).setZero();
    rows.of_b.row(k).setZero();
    rows.bias[k] = 0;
    if (motor.drive == Drive::holds) {
      constrain(motor, joint.b == world_body, line_of(joint, motor, state, turns), now, k, rows);
    }
    ++k;
  }
}

}  // namespace odeval::engine_rk4
