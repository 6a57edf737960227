# A double pendulum of balls, and a ball that bounces beside it, in PyODE.
import ode

world = ode.World()
world.setGravity((0, -9.81, 0))
space = ode.HashSpace()
ground = ode.GeomPlane(space, (0, 1, 0), 0)
contacts = ode.JointGroup()


def ball(x, y):
    body = ode.Body(world)
    mass = ode.Mass()
    mass.setSphere(2500, 0.05)
    body.setMass(mass)
    body.setPosition((x, y, 0))
    return body


def join(one, other, x, y):
    joint = ode.BallJoint(world)
    joint.attach(one, other)
    joint.setAnchor((x, y, 0))
    return joint


upper, lower, free = ball(1, 2), ball(2, 2), ball(5, 1)
joints = [join(upper, ode.environment, 0, 2), join(upper, lower, 1, 2)]
sphere = ode.GeomSphere(space, 0.05)
sphere.setBody(free)


def near(given, one, other):
    where, group = given
    for contact in ode.collide(one, other):
        contact.setBounce(0.5)
        contact.setMu(0.3)
        ode.ContactJoint(where, group, contact).attach(one.getBody(), other.getBody())


moves = 0


def count(*_):
    global moves
    moves += 1


lower.setMovedCallback(count)
for _ in range(2000):
    space.collide((world, contacts), near)
    world.step(0.001)
    contacts.empty()
print(lower.getPosition(), free.getPosition())
print(moves, "moves")
