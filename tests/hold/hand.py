"""Simulated hands: held poses with turns between them, as a measurement table.

Written from shared notes of the table's format alone; it shares no code and no formula text with the
estimator. World z points up. The body frame B is that of the housing; gyro and accelerometer are mounted in it
with small angles of their own.

    gyro   y_deg_s = M_B w_B + b(t) + G_B f_B + white noise        (w_B inertial: the Earth turns too)
    accel  a_g     = T_B f_B + o + noise

A turn is smooth, from rest to rest: its angle follows 10 s^3 - 15 s^4 + 6 s^5 about an axis that itself swings.
"""
import dataclasses

import numpy as np

EARTH_DEG_S = 15.041 / 3600.0
DEG = np.pi / 180.0


def cross(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def rotation(v):
    """Rodrigues' formula for one vector or many (n x 3)."""
    v = np.atleast_2d(v)
    angle = np.linalg.norm(v, axis=1)
    safe = np.where(angle < 1e-12, 1.0, angle)
    k = v / safe[:, None]
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    skew = np.zeros((len(v), 3, 3))
    skew[:, 0, 1], skew[:, 0, 2], skew[:, 1, 2] = -k[:, 2], k[:, 1], -k[:, 0]
    skew -= skew.transpose(0, 2, 1)
    return np.eye(3) * cosine + sine * skew + (1.0 - cosine) * k[:, :, None] * k[:, None, :]


@dataclasses.dataclass
class Hand:
    """What is drawn for one set; all figures are standard deviations or ranges."""
    seed: int = 1
    poses: int = 25
    rate_hz: float = 100.0
    rest_s: tuple = (2.0, 4.0)
    turn_s: tuple = (1.0, 4.0)
    turn_deg: tuple = (30.0, 180.0)
    trembles: bool = True          # False: laid down in each pose
    tremble_deg: float = 0.05
    push_g: float = 0.002          # of the tremble, in the acceleration
    sway_g: float = 0.08           # of the hand's way during a turn
    walk_deg_sqrt_s: float = 0.0035
    bias_walk: float = 1e-4        # deg/s/sqrt(s)
    bias_deg_s: float = 2.0
    scale: float = 0.015
    cross: float = 0.01
    accel_noise_g_sqrt_s: float = 0.0004
    accel_scale: float = 0.02
    accel_offset_g: float = 0.03
    g_deg_s_g: float = 0.0
    lsb_per_deg_s: float = 32.8    # a range of 1000 deg/s; 0: not quantised
    accel_lsb_per_g: float = 16384.0
    latitude_deg: float = 48.0
    only_axis: int = -1            # all turns about this axis
    faces: bool = True             # the six faces are among the poses


class Truth:
    pass


def draw_part(hand, random):
    truth = Truth()
    mount = rotation(random.normal(0.0, 0.5 * DEG, 3))[0]
    truth.m = np.eye(3) + np.diag(random.normal(0, hand.scale, 3)) + hand.cross * random.normal(0, 1, (3, 3)) * (1 - np.eye(3))
    truth.t = (np.eye(3) + np.diag(random.normal(0, hand.accel_scale, 3))
               + 0.01 * random.normal(0, 1, (3, 3)) * (1 - np.eye(3))) @ mount
    truth.o = random.normal(0, hand.accel_offset_g, 3)
    truth.g = hand.g_deg_s_g * random.normal(0, 1, (3, 3))
    truth.b = random.normal(0, hand.bias_deg_s, 3)
    return truth


def targets(hand, random):
    """Directions that point up, one a pose."""
    faces = [s * np.eye(3)[i] for i in range(3) for s in (1.0, -1.0)] if hand.faces else []
    more = [random.normal(0, 1, 3) for _ in range(hand.poses - len(faces))]
    ups = faces + [v / np.linalg.norm(v) for v in more]
    random.shuffle(ups)
    return ups


def log_rotation(r):
    """Rotation vectors of small or large rotations (n x 3 x 3), below 180 deg."""
    angle = np.arccos(np.clip((np.trace(r, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    twice = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    factor = np.where(angle < 1e-4, 0.5 + angle**2 / 12.0, angle / np.maximum(1e-300, 2.0 * np.sin(angle)))
    return factor[:, None] * twice


def orientation_with(up, random):
    """Some R_WB for which this direction of B points up."""
    side = np.cross(up, random.normal(0, 1, 3))
    side /= np.linalg.norm(side)
    return np.array([side, np.cross(up, side), up])


def turn_vector(hand, r, up, random):
    """The rotation vector, about axes of B, of a turn that brings `up` up, within the range of angles."""
    if hand.only_axis >= 0:
        return random.uniform(*hand.turn_deg) * DEG * random.choice([-1, 1]) * np.eye(3)[hand.only_axis]
    for _ in range(100):
        vector = log_rotation((r.T @ orientation_with(up, random))[None])[0]
        if hand.turn_deg[0] * DEG <= np.linalg.norm(vector) <= hand.turn_deg[1] * DEG - 0.02:
            break
    return vector


def motion(hand, random):
    """Increments of the rotation from sample to sample: rotation vectors about axes of B [rad], and the rests."""
    dt = 1.0 / hand.rate_hz
    ups = targets(hand, random)
    r = orientation_with(ups[0], random)
    pieces, rests, at = [], [], 0
    for k in range(hand.poses):
        n = int(round(random.uniform(*hand.rest_s) * hand.rate_hz))
        pieces.append(np.zeros((n, 3)))
        rests.append((at, at + n))
        at += n
        if k + 1 == hand.poses:
            break
        n = int(round(random.uniform(*hand.turn_s) * hand.rate_hz))
        s = np.arange(n + 1) / n
        shape = 10 * s**3 - 15 * s**4 + 6 * s**5
        total = turn_vector(hand, r, ups[k + 1], random)
        # A hand does not turn about one axis: another swings out and back on the way.
        bend = np.zeros(3) if hand.only_axis >= 0 else random.normal(0, 0.15, 3) * np.linalg.norm(total)
        way = rotation(shape[:, None] * total) @ rotation((np.sin(np.pi * shape) ** 2)[:, None] * bend)
        pieces.append(log_rotation(np.einsum("nji,njk->nik", way[:-1], way[1:])))
        r = r @ way[-1]
        at += n
    return np.vstack(pieces), rests, dt


def smooth_noise(random, n, low_hz, high_hz, rate_hz, rms):
    """Band-limited noise of three axes."""
    f = np.fft.rfftfreq(n, 1.0 / rate_hz)
    keep = (f >= low_hz) & (f <= high_hz)
    spectrum = np.zeros((len(f), 3), complex)
    spectrum[keep] = random.normal(0, 1, (keep.sum(), 3)) + 1j * random.normal(0, 1, (keep.sum(), 3))
    x = np.fft.irfft(spectrum, n, axis=0)
    return x * (rms / max(1e-300, x.std()))


def make(hand):
    """Truth, and columns t_s, gyro (3, deg/s), accel (3, g)."""
    random = np.random.default_rng(hand.seed)
    truth = draw_part(hand, random)
    steps, rests, dt = motion(hand, random)
    n = len(steps) + 1
    resting = np.zeros(n, bool)
    for first, last in rests:
        resting[first:last + 1] = True
    if hand.trembles:
        wobble = smooth_noise(random, n, 2.0, 8.0, hand.rate_hz, hand.tremble_deg * DEG)
        steps = steps + np.diff(wobble, axis=0)
    # Rates at samples: of a cubic through the increments' sum, which is the angle about B's own axes.
    fine = steps / dt
    rate = np.vstack([fine[:1], 0.5 * (fine[1:] + fine[:-1]), fine[-1:]])
    # The orientation by the exact rotation of rates that go straight between samples (Magnus, two terms and the third).
    a, b = rate[:-1], rate[1:]
    theta = 0.5 * dt * (a + b) + dt * dt / 12.0 * np.cross(a, b)
    r = np.empty((n, 3, 3))
    r[0] = rotation(random.normal(0, 1, 3))[0]
    for i, part in enumerate(rotation(theta)):
        r[i + 1] = r[i] @ part
    heading = random.uniform(0, 2 * np.pi)
    earth = EARTH_DEG_S * np.array([np.cos(hand.latitude_deg * DEG) * np.cos(heading),
                                    -np.cos(hand.latitude_deg * DEG) * np.sin(heading),
                                    np.sin(hand.latitude_deg * DEG)])
    up_b = r[:, 2, :]
    force = up_b.copy()
    moving = 1.0 - np.convolve(resting, np.ones(9) / 9, "same")
    force += moving[:, None] * smooth_noise(random, n, 0.3, 3.0, hand.rate_hz, hand.sway_g)
    if hand.trembles:
        force += smooth_noise(random, n, 2.0, 8.0, hand.rate_hz, hand.push_g)
    earth_b = np.einsum("nji,j->ni", r, earth)
    bias = truth.b + np.cumsum(random.normal(0, hand.bias_walk * np.sqrt(dt), (n, 3)), axis=0)
    gyro = (rate / DEG + earth_b) @ truth.m.T + bias + force @ truth.g.T
    gyro += random.normal(0, hand.walk_deg_sqrt_s / np.sqrt(dt), (n, 3))
    accel = force @ truth.t.T + truth.o + random.normal(0, hand.accel_noise_g_sqrt_s / np.sqrt(dt), (n, 3))
    if hand.lsb_per_deg_s > 0:
        gyro = np.round(gyro * hand.lsb_per_deg_s) / hand.lsb_per_deg_s
        accel = np.round(accel * hand.accel_lsb_per_g) / hand.accel_lsb_per_g
    truth.rests, truth.rate, truth.r, truth.dt, truth.earth = rests, rate, r, dt, earth
    truth.bias_mean = np.mean([bias[first:last + 1].mean(axis=0) for first, last in rests], axis=0)
    return truth, np.arange(n) * dt, gyro, accel


def in_accelerometer_frame(truth):
    """M, G, T in the frame nearest to the accelerometer's three axes: T = diag(d) P Q, P symmetric, Q a rotation."""
    d = np.linalg.norm(truth.t, axis=1)
    u, _, vt = np.linalg.svd(truth.t / d[:, None])
    q = u @ vt
    return truth.m @ q.T, truth.g @ q.T, truth.t @ q.T


def write(path, hand, t, gyro, accel, unit="lsb", give_sensitivity=True, zero=0.0):
    with open(path, "w") as out:
        if unit == "lsb":
            if give_sensitivity:
                out.write(f"# gyro_lsb_per_deg_s = {hand.lsb_per_deg_s:g}\n")
            gyro = np.clip(np.round(gyro * hand.lsb_per_deg_s), -32768, 32767) + zero  # a converter of 16 bits
        if unit == "rad_s":
            gyro = gyro * DEG
        out.write(f"# site_latitude_deg = {hand.latitude_deg:g}\n")
        out.write("t_s," + ",".join(f"gyro_{c}_{unit}" for c in "xyz") + "," + ",".join(f"accel_{c}_g" for c in "xyz") + "\n")
        for row in np.column_stack([t, gyro, accel]):
            out.write("%.5f,%.8g,%.8g,%.8g,%.7f,%.7f,%.7f\n" % tuple(row))
