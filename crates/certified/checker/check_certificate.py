"""Checks a certificate of `dynamics certify` with exact integers, without the library that wrote it.

    python3 check_certificate.py certificate.json

A number is an interval [lo, hi] of integers in units of 2^-BITS; each operation rounds outward. The equations
are the Newton-Euler equations in the bodies' own frames, with a separate wrench for each link. The exit code
is 0 if the claim is proven again, and 1 if not.
"""

import json
import sys

BITS = 128
ONE = 1 << BITS


class I:
    """An interval."""

    def __init__(self, lo, hi=None):
        self.lo, self.hi = lo, lo if hi is None else hi

    def __add__(self, o):
        return I(self.lo + o.lo, self.hi + o.hi)

    def __neg__(self):
        return I(-self.hi, -self.lo)

    def __sub__(self, o):
        return I(self.lo - o.hi, self.hi - o.lo)

    def __mul__(self, o):
        p = (self.lo * o.lo, self.lo * o.hi, self.hi * o.lo, self.hi * o.hi)
        return I(min(p) >> BITS, -(-max(p) >> BITS))

    def over(self, o):
        assert o.lo > 0 or o.hi < 0, "a divisor contains 0"
        ends = [(a, b) for a in (self.lo, self.hi) for b in (o.lo, o.hi)]
        return I(min((a << BITS) // b for a, b in ends), max(-((-a << BITS) // b) for a, b in ends))

    def meet(self, o):
        lo, hi = max(self.lo, o.lo), min(self.hi, o.hi)
        assert lo <= hi, "two enclosures of one number are disjoint"
        return I(lo, hi)

    def within(self, o):
        return o.lo <= self.lo and self.hi <= o.hi

    def middle(self):
        return I((self.lo + self.hi) // 2)

    def mag(self):
        return max(abs(self.lo), abs(self.hi))

    def sincos(self):
        """|sin(c + r) - sin c| <= |r|, and the same for cosine."""
        c, r = self.middle().lo, (self.hi - self.lo + 1) // 2
        s, k = sine(c), sine(c + HALF_PI)
        clip = lambda x, e: I(max(x - r - e, -ONE), min(x + r + e, ONE))
        return clip(s, 4), clip(k, 8)


def arctangent(n):
    """arctan(1/n) in units of 2^-(BITS + 64), with an error of at most 200 units."""
    x, k, total = (ONE << 64) // n, 1, 0
    while x:
        total += x // k if k % 4 == 1 else -(x // k)
        x, k = x // (n * n), k + 2
    return total


PI = 16 * arctangent(5) - 4 * arctangent(239)  # Machin, with 64 more bits
HALF_PI = PI >> 65


def sine(x):
    """sin x with an error of at most 2 units of 2^-BITS, for |x| below 2^32."""
    x <<= 64
    turns = (2 * x + PI) // (2 * PI)
    x -= turns * PI
    scale, term, k, total = ONE << 64, x, 1, 0
    while term:
        total += term
        term = -(term * x // scale) * x // scale // ((k + 1) * (k + 2))
        k += 2
    return (-total if turns % 2 else total) >> 64


class D:
    """A number and its derivative by time: value and slope are intervals."""

    def __init__(self, v, d=None):
        self.v, self.d = v, d or I(0)

    def __add__(self, o):
        return D(self.v + o.v, self.d + o.d)

    def __neg__(self):
        return D(-self.v, -self.d)

    def __sub__(self, o):
        return D(self.v - o.v, self.d - o.d)

    def __mul__(self, o):
        return D(self.v * o.v, self.v * o.d + self.d * o.v)

    def sincos(self):
        s, c = self.v.sincos()
        return D(s, c * self.d), D(c, -(s * self.d))


def number(x):
    """A double, which is a multiple of 2^-1074, rounded outward if it has bits below 2^-BITS."""
    n, d = x.as_integer_ratio() if isinstance(x, float) else (x, 1)
    return I((n << BITS) // d, -((-n << BITS) // d))


def interval(pair):
    return I(number(pair[0]).lo, number(pair[1]).hi)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def times(m, v):
    return [dot(row, v) for row in m]


def transposed(m):
    return [list(column) for column in zip(*m)]


class Robot:
    """The tree over one kind of numbers; `lift` turns an interval into such a number."""

    def __init__(self, data, lift):
        self.lift, self.bodies, self.n = lift, data["bodies"], data["coordinates"]
        get = lambda x: lift(number(x))
        self.get, self.zero, self.one = get, get(0), get(1)
        self.const = [
            {
                "R": [[get(x) for x in row] for row in b["rotation"]],
                "p": [get(x) for x in b["translation"]],
                "m": get(b["mass"]),
                "h": [get(x) for x in b["first_moment"]],
                "I": [[get(x) for x in row] for row in b["inertia"]],
            }
            for b in self.bodies
        ]

    def place(self, q):
        """Rotation and origin of every body in its parent."""
        self.at = []
        for b, c in zip(self.bodies, self.const):
            x = self.get(b["ratio"]) * q[b["coordinate"]] + self.get(b["offset"])
            R, p = c["R"], c["p"]
            if b["joint"] != "prismatic":
                s, k = x.sincos()
                R = [[r[0] * k + r[1] * s, r[1] * k - r[0] * s, r[2]] for r in R]
            slide = {"prismatic": self.one, "helical": self.get(b["pitch"])}.get(b["joint"])
            if slide is not None:
                p = [p[i] + R[i][2] * slide * x for i in range(3)]
            self.at.append((R, p, x))

    def move(self, v, a, gravity):
        """Velocity w, acceleration alpha, and acceleration o of the origin less gravity, of every body."""
        self.motion, zero = [], [self.zero] * 3
        for b, (R, p, _) in zip(self.bodies, self.at):
            w, alpha, o = (zero, zero, [-g for g in gravity]) if b["parent"] is None else self.motion[b["parent"]]
            o = plus(o, plus(cross(alpha, p), cross(w, cross(w, p))))
            T = transposed(R)
            w, alpha, o = times(T, w), times(T, alpha), times(T, o)
            rate, change = (self.get(b["ratio"]) * x[b["coordinate"]] for x in (v, a))
            slide = {"prismatic": self.one, "helical": self.get(b["pitch"])}.get(b["joint"])
            if slide is not None:
                z = [self.zero, self.zero, slide * rate]
                o = plus(o, [x + x for x in cross(w, z)])
                o[2] = o[2] + slide * change
            if b["joint"] != "prismatic":
                z = [self.zero, self.zero, rate]
                alpha = plus(alpha, cross(w, z))
                alpha[2] = alpha[2] + change
                w = plus(w, z)
            self.motion.append((w, alpha, o))

    def torques(self, body, force, moment):
        """The torques that balance a force and a moment about the body's origin."""
        tau = [self.zero] * self.n
        while body is not None:
            b, (R, p, _) = self.bodies[body], self.at[body]
            along = moment[2] if b["joint"] == "revolute" else force[2]
            if b["joint"] == "helical":
                along = moment[2] + self.get(b["pitch"]) * force[2]
            tau[b["coordinate"]] = tau[b["coordinate"]] + self.get(b["ratio"]) * along
            force = times(R, force)
            moment = plus(times(R, moment), cross(p, force))
            body = b["parent"]
        return tau

    def link(self, i):
        """The part of link i in the torques."""
        (w, alpha, o), c = self.motion[i], self.const[i]
        force = plus([c["m"] * x for x in o], plus(cross(alpha, c["h"]), cross(w, cross(w, c["h"]))))
        moment = plus(cross(c["h"], o), plus(times(c["I"], alpha), cross(w, times(c["I"], w))))
        return self.torques(i, force, moment)

    def unit_payload(self, frame):
        """The torques for a unit of each of ten parameters of a body in a frame, by coordinate."""
        (w, alpha, o), i = self.motion[frame["body"]], frame["body"]
        R = [[self.get(x) for x in row] for row in frame["rotation"]]
        p = [self.get(x) for x in frame["translation"]]
        T = transposed(R)
        o = times(T, plus(o, plus(cross(alpha, p), cross(w, cross(w, p)))))
        w, alpha = times(T, w), times(T, alpha)
        zero, e = [self.zero] * 3, [[self.one if i == j else self.zero for j in range(3)] for i in range(3)]
        wrenches = [(o, zero)]
        for x in e:
            wrenches.append((plus(cross(alpha, x), cross(w, cross(w, x))), cross(x, o)))
        for i_, j_ in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)):
            of = lambda u: [u[j_] * x for x in e[i_]] if i_ == j_ else plus(
                [u[j_] * x for x in e[i_]], [u[i_] * x for x in e[j_]]
            )
            wrenches.append((zero, plus(of(alpha), cross(w, of(w)))))
        columns = []
        for force, moment in wrenches:
            force = times(R, force)
            columns.append(self.torques(i, force, plus(times(R, moment), cross(p, force))))
        return transposed(columns)

    def joints(self, a):
        """Armature and springs."""
        tau = [self.zero] * self.n
        for b, (_, _, x) in zip(self.bodies, self.at):
            j, ratio = b["coordinate"], self.get(b["ratio"])
            force = self.get(b["armature"]) * ratio * a[j]
            force = force + self.get(b["stiffness"]) * (x - self.get(b["rest"]))
            tau[j] = tau[j] + ratio * force
        return tau

    def inverse_dynamics(self, q, v, a, gravity):
        self.place(q)
        self.move(v, a, gravity)
        tau = self.joints(a)
        for i in range(len(self.bodies)):
            tau = plus(tau, self.link(i))
        return tau

    def mass_matrix(self, q):
        zero, none = [self.zero] * self.n, [self.zero] * 3
        rest = self.inverse_dynamics(q, zero, zero, none)
        columns = []
        for k in range(self.n):
            unit = [self.one if i == k else self.zero for i in range(self.n)]
            columns.append([x - y for x, y in zip(self.inverse_dynamics(q, zero, unit, none), rest)])
        return transposed(columns)


def is_definite(m):
    """Whether all symmetric matrices in the intervals are positive definite, by the pivots of L D L'."""
    m = [row[:] for row in m]
    for k in range(len(m)):
        if m[k][k].lo <= 0:
            return False
        for i in range(k + 1, len(m)):
            factor = m[i][k].over(m[k][k])
            for j in range(k + 1, i + 1):
                m[i][j] = m[j][i] = m[i][j] - factor * m[j][k]
    return True


def largest_eigenvalue(s):
    """A bound of all eigenvalues of the symmetric matrices in the intervals, by bisection."""
    size = sum(x.mag() for row in s for x in row) + 1
    low, high = -size, size
    for _ in range(40):
        middle = (low + high) // 2
        shifted = [[(I(middle) if i == j else I(0)) - s[i][j] for j in range(3)] for i in range(3)]
        low, high = (low, middle) if is_definite(shifted) else (middle, high)
    return high


def payload_range(row, center, radius):
    """The range of one torque for 1 kg with its center in a box and principal moments up to radius^2."""
    _, hx, hy, hz, xx, xy, yy, xz, yz, zz = row
    half = lambda x: -(x * I(ONE >> 1))
    s = [[yy + zz, half(xy), half(xz)], [half(xy), xx + zz, half(yz)], [half(xz), half(yz), xx + yy]]
    middle, h = [c.middle() for c in center], [hx, hy, hz]
    value = row[0] + dot(h, middle) + dot(middle, times(s, middle))
    slope = plus(h, [x + x for x in times(s, center)])
    value = value + dot(slope, [c - m for c, m in zip(center, middle)])
    trace = (s[0][0] + s[1][1] + s[2][2]) * I(ONE >> 1)
    most = max(0, trace.hi, largest_eigenvalue(s))
    least = -max(0, -trace.lo, largest_eigenvalue([[-x for x in row] for row in s]))
    return value + radius * radius * I(least, most)


def motion_at(piece, s, lift):
    """q, v and a of a piece, by Horner's scheme."""
    q, v, a = [], [], []
    for polynomial in piece["coordinates"]:
        x = [lift(I(0))] * 3
        for k in reversed(range(6)):
            c = number(polynomial[k])
            scaled = [c, c * number(k), c * number(k * (k - 1))]
            x = [x[i] * s + lift(scaled[i]) if k >= i else x[i] for i in range(3)]
        for to, y in zip((q, v, a), x):
            to.append(y)
    return q, v, a


def check_torques(data, claim):
    gravity = [interval(x) for x in claim["gravity"]]
    middle = [g.middle() for g in gravity]
    factors = [interval(claim["mass_factors"][b["link"]]) if b["link"] else number(1) for b in data["bodies"]]
    friction, payload = interval(claim["friction_factor"]), claim["payload"]
    bounds = [interval(x) for x in claim["torques"]]
    lifts = {I: lambda x: x, D: D}
    robots = {kind: Robot(data, lift) for kind, lift in lifts.items()}
    n = data["coordinates"]

    def parts(kind, piece, s):
        robot, lift = robots[kind], lifts[kind]
        q, v, a = motion_at(piece, s, lift)
        zero = [robot.zero] * n
        robot.place(q)
        robot.move(v, a, [lift(g) for g in middle])
        found = [robot.joints(a)] + [robot.link(i) for i in range(len(factors))]
        found += transposed(robot.unit_payload(payload["frame"])) if payload else []
        for k in range(3):
            if gravity[k].lo < gravity[k].hi:
                unit = [robot.one if i == k else robot.zero for i in range(3)]
                robot.move(zero, zero, unit)
                found += [robot.link(i) for i in range(len(factors))]
                found += transposed(robot.unit_payload(payload["frame"])) if payload else []
        return found + [v]

    def carried(rows, j):
        row = [r[j] for r in rows]
        center = [interval(x) for x in payload["center_of_mass"]]
        return interval(payload["mass"]) * payload_range(row, center, number(payload["radius_of_gyration"]))

    def hold(piece, lo, hi, depth):
        s = I(lo, hi)
        m = s.middle()
        center, slope = parts(I, piece, m), parts(D, piece, D(s, number(1)))
        join = lambda c, d: d.v.meet(c + d.d * (s - m))
        rows = [[join(c, d) for c, d in zip(*pair)] for pair in zip(center, slope)]
        v, links, total, k = rows.pop(), len(factors), rows[0], 1
        weights = [number(1)] + [g - x for g, x in zip(gravity, middle) if g.lo < g.hi]
        for weight in weights:
            for j in range(n):
                part = I(0)
                for l in range(links):
                    part = part + factors[l] * rows[k + l][j]
                if payload:
                    part = part + carried(rows[k + links : k + links + 10], j)
                total[j] = total[j] + weight * part
            k += links + (10 if payload else 0)
        for b in data["bodies"]:
            ratio, j = number(b["ratio"]), b["coordinate"]
            rate = ratio * v[j]
            sign = I(-ONE if rate.lo < 0 else 0 if rate.lo == 0 else ONE, ONE if rate.hi > 0 else 0 if rate.hi == 0 else -ONE)
            loss = number(b["damping"]) * rate + number(b["friction"]) * sign
            total[j] = total[j] + friction * ratio * loss
        if all(t.within(bound) for t, bound in zip(total, bounds)):
            return True
        half = (lo + hi) // 2
        return depth > 0 and hold(piece, lo, half, depth - 1) and hold(piece, half, hi, depth - 1)

    pieces = claim["motion"]
    ends = [number(p["duration"]).hi for p in pieces]
    done = [0] * len(pieces)
    for k, lo, hi in sorted(claim["parts"]):
        assert number(lo).lo <= done[k], "the parts leave a gap"
        if not hold(pieces[k], done[k], number(hi).hi, 6):
            return f"a torque is not proven between {lo} s and {hi} s of piece {k}"
        done[k] = number(hi).hi
    return None if done == ends else "the parts do not cover the motion"


def check_mass_matrix(data, claim):
    def has_energy(b):
        h, zero = [number(x) for x in b["first_moment"]], number(0)
        c = [[zero, -h[2], h[1]], [h[2], zero, -h[0]], [-h[1], h[0], zero]]
        m = [[number(b["mass"]) if i == j else zero for j in range(3)] + [c[j][i] for j in range(3)] for i in range(3)]
        m += [c[i] + [number(x) for x in b["inertia"][i]] for i in range(3)]
        return b["armature"] > 0 or is_definite(m)

    if any(b["armature"] < 0 for b in data["bodies"]):
        return "a rotor has a negative inertia"
    if claim["divisions"] is None:
        return None if all(has_energy(b) for b in data["bodies"]) else "a body has no inertia of its own"
    robot, order, start = Robot(data, lambda x: x), iter(claim["divisions"]), [tuple(x) for x in claim["q"]]
    used = [b["coordinate"] for b in data["bodies"]]
    for b in data["bodies"]:  # M does not depend on the joints at the root
        if b["parent"] is None and used.count(b["coordinate"]) == 1:
            start[b["coordinate"]] = (0.0, 0.0)
    boxes = [start]
    while boxes:
        box, k = boxes.pop(), next(order)
        if k < 0:
            if not is_definite(robot.mass_matrix([interval(x) for x in box])):
                return f"M is not proven to be positive definite in {box}"
            continue
        lo, hi = box[k]
        middle = min(max(0.5 * lo + 0.5 * hi, lo), hi)
        for half in ((middle, hi), (lo, middle)):
            boxes.append(box[:k] + [half] + box[k + 1 :])
    return None


def check_digits(data, claim):
    robot = Robot(data, lambda x: x)
    gravity = [number(g) for g in data["gravity"]]
    for s in claim["states"]:
        q, v, a, tau = ([number(x) for x in s[k]] for k in ("q", "v", "a", "tau"))
        zero = [number(0)] * robot.n
        mass, bias = robot.mass_matrix(q), robot.inverse_dynamics(q, v, zero, gravity)
        found = {"mass_matrix": [x for row in mass for x in row], "bias": bias}
        found["inverse_dynamics"] = robot.inverse_dynamics(q, v, a, gravity)
        rows = [row + [t - b] for row, t, b in zip(mass, tau, bias)]  # Gauss-Jordan elimination
        for k in range(robot.n):
            rows[k] = [x.over(rows[k][k]) for x in rows[k]]
            for i in range(robot.n):
                if i != k:
                    rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k])]
        found["forward_dynamics"] = [row[-1] for row in rows]
        for name, claimed in s["enclosures"].items():
            if not all(x.within(interval(c)) for x, c in zip(found[name], claimed)):
                return f"{name} is outside its enclosure at q = {s['q']}"
    return None


CELLS = 16


def check_reach(data, claim):
    """The support function of a frame's positions on a grid of directions, from the tip to the root."""
    step = lambda k: (2 * k - CELLS) * ONE // CELLS  # exact
    vertices = {}
    for axis in range(3):
        for sign in (ONE, -ONE):
            for i in range(CELLS + 1):
                for j in range(CELLS + 1):
                    point = [0, 0, 0]
                    point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = sign, step(i), step(j)
                    vertices[axis, sign, i, j] = point

    def bound(h, m):
        """h is sublinear: weights of a triangle's corners, and a remainder."""
        x = [c.middle().lo for c in m]
        axis = max(range(3), key=lambda k: abs(x[k]))
        size = abs(x[axis])
        if size == 0:
            return sum(c.mag() for c in m) * h["largest"] // ONE + 1
        along = [(x[(axis + k) % 3] * ONE // size + ONE) * CELLS // 2 for k in (1, 2)]
        cell = [min(max(y // ONE, 0), CELLS - 1) for y in along]
        f, g = (min(max(y - k * ONE, 0), ONE) for y, k in zip(along, cell))
        (i, j), sign = cell, ONE if x[axis] > 0 else -ONE
        if f + g <= ONE:
            corners = ((i, j, ONE - f - g), (i + 1, j, f), (i, j + 1, g))
        else:
            corners = ((i + 1, j + 1, f + g - ONE), (i + 1, j, ONE - g), (i, j + 1, ONE - f))
        total, rest = I(0), m
        for i, j, weight in corners:
            weight = I(weight * size // ONE)
            total = total + weight * I(h[axis, sign, i, j])
            rest = [r - weight * I(p) for r, p in zip(rest, vertices[axis, sign, i, j])]
        return total.hi + sum(r.mag() for r in rest) * h["largest"] // ONE + 1

    def relative_to_parent(b, c, box, h, m):
        """m . p + the maximum over the joint's positions of h(R' m)."""
        offset, m = dot(m, c["p"]), times(transposed(c["R"]), m)
        slide = {"prismatic": number(1), "helical": number(b["pitch"])}.get(b["joint"], number(0)) * m[2]
        x = number(b["ratio"]) * box + number(b["offset"])
        if b["joint"] == "prismatic":
            return (I(bound(h, m)) + slide * x + offset).hi
        if b["joint"] == "revolute" and x.hi - x.lo > 63 * ONE // 10:
            x = I(x.lo, x.lo + 63 * ONE // 10)
        steps = max(-(-(x.hi - x.lo) * CELLS // (2 * ONE)), 1)
        angles = [x.lo + (x.hi - x.lo) * k // steps for k in range(steps)] + [x.hi]
        half = I((max(q - p for p, q in zip(angles, angles[1:])) + 1) // 2)
        growth = I(ONE, number(1).over(half.sincos()[1]).hi)
        rest = (growth - number(1)) * I(m[2].mag()) * I(h["largest"])
        values = []
        for angle in angles:
            s, k = I(angle).sincos()
            values.append(bound(h, [m[0] * k + m[1] * s, m[1] * k - m[0] * s, m[2]]))
        best = None
        for p, q, u, v in zip(angles, angles[1:], values, values[1:]):
            top = (growth * I(max(u, v)) + rest + slide * I(p, q)).hi
            best = top if best is None else max(best, top)
        return best + offset.hi

    robot, frame, q = Robot(data, lambda x: x), claim["frame"], [interval(x) for x in claim["q"]]
    point, chain, at = [number(x) for x in frame["translation"]], [], frame["body"]
    while at is not None:
        chain.append(at)
        at = data["bodies"][at]["parent"]
    value = lambda m: dot(m, point).hi
    for body in chain:
        h = {key: value([I(x) for x in vertex]) for key, vertex in vertices.items()}
        h["largest"] = max([0] + [h[axis, sign, CELLS // 2, CELLS // 2] for axis in range(3) for sign in (ONE, -ONE)])
        b = data["bodies"][body]
        value = lambda m, h=h, b=b, body=body: relative_to_parent(b, robot.const[body], q[b["coordinate"]], h, m)
    for half_space in claim["half_spaces"]:
        most = value([number(x) for x in half_space["direction"]])
        if most > number(half_space["at_most"]).lo:
            return f"n . p <= {half_space['at_most']} is not proven, only {most / ONE}"
    return None


CHECKS = {"torques": check_torques, "mass_matrix": check_mass_matrix, "digits": check_digits, "reach": check_reach}


def main(path):
    with open(path, encoding="utf-8") as file:
        certificate = json.load(file)
    if certificate.get("format") != "robot-dynamics certificate 1":
        print("not a certificate of this format")
        return 1
    claim = certificate["claim"]
    fault = CHECKS[claim["kind"]](certificate["robot"], claim)
    print(f"{certificate['robot']['name']}, {claim['kind']}: {fault or 'proven'}")
    return 1 if fault else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
