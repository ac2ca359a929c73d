"""One vertex during one step, and the drag on it: what medium effects transform.

    F_i = -w (((1 - l) r f_t (m_t + f_d) + l m_t f_l) v_t T_i + m_n f_n v_n N_i)     at the step's ends
    M_i = -w m_n f_n h^2 Omega                 v = (c_1 - c_0) / dt, Omega: mean turning rate of the wheels
    wrench = 1/2 sum_k (F_0 + F_1,  c_1 x F_0 + c_0 x F_1 + M_0 + M_1)

c: contact point, T, N: rolling direction and its left normal, w: weight, r: what rolling weighs (eps of linear drag),
l: share of the wheel that is locked, h: half the distance of the wheels on the axle. m_t, m_n are the law's multipliers
(serpenoid.media; 1 of linear drag). f_t, f_l, f_n are 1 without effects; l, h and f_d are 0.
Each end's force acts at the other end's contact point: for any law that comes from a potential of (v, T_i) that is
exactly the derivative of the step energy by the pose, because the potential does not change when everything turns.
World frame, SI: metres, seconds; forces divided by the drag level are speeds, where drag is linear (`Parameter`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca

CREEP = 1e-3  # m/s: softens signs and norms


def soft_sign(u: ca.SX) -> ca.SX:
    """u / sqrt(u^2 + d^2), d = 1 mm/s."""
    return u / ca.sqrt(u**2 + CREEP**2)


def left(vector: ca.SX) -> ca.SX:
    """A vector (2,) turned by +90 degrees."""
    return ca.vertcat(-vector[1], vector[0])


def turned(vector: ca.SX, angle: ca.SX) -> ca.SX:
    """A vector (2,) turned by an angle."""
    return ca.cos(angle) * vector + ca.sin(angle) * left(vector)


def angle_between(a: ca.SX, b: ca.SX) -> ca.SX:
    """From direction a to direction b, counter-clockwise."""
    return ca.atan2(cross(a, b), ca.dot(a, b))


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """a x b in the plane."""
    return a[0] * b[1] - a[1] * b[0]


@dataclass(frozen=True)
class Element:
    """A vertex during a step. Pairs hold (before, after) the step.

    points: the vertex [m]; tangents: of the body; links: direction of the edge on the tail's side; contacts: where the
    drag acts [m]; wheels: directions in which it rolls; origin: what points and contacts are counted from [m]; weight:
    share of the body's weight; grip: the weight in the drag law; anisotropy_ratio: eps; locked: share of the wheel
    that slides instead of rolling; axle: square of the distance from its middle to a wheel [m^2]; time: middle of the
    step, seconds since the start; duration [s]; push: force on the vertex [m/s]; momentum: of the vertex [m].
    """

    points: tuple[ca.SX, ca.SX]
    tangents: tuple[ca.SX, ca.SX]
    links: tuple[ca.SX, ca.SX]
    contacts: tuple[ca.SX, ca.SX]
    wheels: tuple[ca.SX, ca.SX]
    origin: ca.SX
    weight: ca.SX
    grip: ca.SX
    anisotropy_ratio: ca.SX
    locked: ca.SX
    axle: ca.SX
    time: ca.SX
    duration: ca.SX
    push: ca.SX
    momentum: ca.SX

    @property
    def middle(self) -> ca.SX:
        """Where the vertex is in the middle of the step [m], about the origin."""
        return (self.points[0] + self.points[1]) / 2

    @property
    def place(self) -> ca.SX:
        """Where that is on the floor [m]."""
        return self.origin + self.middle

    @property
    def velocity(self) -> ca.SX:
        """Velocity of the vertex [m/s]."""
        return (self.points[1] - self.points[0]) / self.duration

    @property
    def contact_velocity(self) -> ca.SX:
        """Velocity of the contact point [m/s]."""
        return (self.contacts[1] - self.contacts[0]) / self.duration

    @property
    def squared_slips(self) -> tuple[ca.SX, ca.SX]:
        """Across and along [m^2/s^2] (see serpenoid.media), the mean of both ends."""
        velocity = self.contact_velocity
        across, along = (
            sum(ca.dot(w, velocity) ** 2 for w in ways) / 2 for ways in (map(left, self.wheels), self.wheels)
        )
        return across + self.axle * self.turning**2, along

    def gripping(self, factor: ca.SX) -> Element:
        """Where the force across a wheel is `factor` times as large, and that along it as it was, in every law."""
        return replace(self, grip=self.grip * factor, anisotropy_ratio=self.anisotropy_ratio / factor)

    def along(self, ratio: ca.SX) -> ca.SX:
        """What a slip along weighs beside one across: `ratio` where the wheel rolls, one where it is locked."""
        return (1 - self.locked) * ratio + self.locked

    @property
    def turning(self) -> ca.SX:
        """Turning rate of the wheels [rad/s]."""
        return angle_between(*self.wheels) / self.duration


@dataclass(frozen=True)
class Drag:
    """The law at one end: velocity along the wheel and to its left, soft speed [m/s], and multipliers.

    across and along are the law's multipliers of the force there, across that of the axle's moment, too; dry adds to
    along where a wheel rolls; tangential multiplies what rolls, sliding what is locked, normal what across multiplies.
    scrub: square of the speed at which wheels of a turning axle slide [m^2/s^2]; locked: the share of the wheel that
    does not roll.
    """

    forward: ca.SX
    sideways: ca.SX
    scrub: ca.SX
    locked: ca.SX
    speed: ca.SX
    across: ca.SX
    along: ca.SX
    dry: ca.SX
    tangential: ca.SX
    sliding: ca.SX
    normal: ca.SX

    @classmethod
    def baseline(cls, element: Element, wheel: ca.SX, across: ca.SX, along: ca.SX) -> Drag:
        """The medium's own law, by its multipliers for this step."""
        velocity, scrub, one = element.contact_velocity, element.axle * element.turning**2, ca.SX(1)
        speed = ca.sqrt(ca.dot(velocity, velocity) + scrub + CREEP**2)
        forward, sideways = ca.dot(wheel, velocity), ca.dot(left(wheel), velocity)
        return cls(forward, sideways, scrub, element.locked, speed, across, along, ca.SX(0), one, one, one)

    def resistance(self, wheel: ca.SX, anisotropy_ratio: ca.SX) -> ca.SX:
        """The force per weight, against the drag (2,) [m/s]."""
        rolling = (1 - self.locked) * anisotropy_ratio * self.tangential * (self.along + self.dry)
        along = (rolling + self.along * self.locked * self.sliding) * self.forward
        return along * wheel + self.across * self.normal * self.sideways * left(wheel)

    def by_speed(self, factor: ca.SX | float, added: ca.SX | float = 0) -> Drag:
        """Both of the law's multipliers times a factor, and what is added to both."""
        return replace(self, across=self.across * factor + added, along=self.along * factor + added)

    @property
    def scrubbing(self) -> ca.SX:
        """The axle's moment per weight, its square half track and its turning rate."""
        return self.across * self.normal
