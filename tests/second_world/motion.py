"""Motion of the stand's axes as smooth pieces that can be asked for any time.

An axis is a chain of pieces. Each piece is a function of the time u [s] since it began and gives the angle
gained [deg] and the rate [deg/s].

The trapezoid rule on samples dt apart is off by dt^2/12 times the acceleration. Ramps are raised cosines, so nothing
of it is left after a turn, and accelerations are limited so that it stays at about a millidegree within: what a table
is defined to be integrated by must not pass for an effect. Some benches have straight ramps instead, as stepper drives
do: where one begins or ends between two samples the acceleration jumps by a, and no rule of integration knows where.
"""
import numpy as np

ACCELERATION_DEG_S2 = 80.0
LEAST_ACCELERATION_DEG_S2 = 8.0
TRAPEZOID_ERROR_DEG = 1.05e-3


def allowed_acceleration(interval_s):
    """Acceleration [deg/s^2] at which the trapezoid rule is off by no more than a millidegree."""
    return 12.0 * TRAPEZOID_ERROR_DEG / interval_s ** 2


class Rest:
    """Stands still."""

    def __init__(self, duration_s):
        self.duration_s, self.gain_deg, self.turns = duration_s, 0.0, False

    def at(self, u):
        return np.zeros(u.size), np.zeros(u.size)


class Ramp:
    """From rest to a rate, or back: rate = v (1 - cos(pi u / T)) / 2, or its mirror."""

    def __init__(self, rate_deg_s, duration_s, up):
        self.rate, self.duration_s, self.up, self.turns = rate_deg_s, duration_s, up, True
        self.gain_deg = rate_deg_s * duration_s / 2.0

    def at(self, u):
        sign = 1.0 if self.up else -1.0
        k = np.pi / self.duration_s
        angle = self.rate / 2.0 * (u - sign * np.sin(k * u) / k)
        return angle, self.rate / 2.0 * (1.0 - sign * np.cos(k * u))


class StraightRamp:
    """From rest to a rate, or back, at a constant acceleration."""

    def __init__(self, rate_deg_s, duration_s, up):
        self.rate, self.duration_s, self.up, self.turns = rate_deg_s, duration_s, up, True
        self.gain_deg = rate_deg_s * duration_s / 2.0

    def at(self, u):
        slope = self.rate / self.duration_s
        if self.up:
            return slope * u ** 2 / 2.0, slope * u
        return self.rate * u - slope * u ** 2 / 2.0, self.rate - slope * u


class Cruise:
    """A constant rate."""

    def __init__(self, rate_deg_s, duration_s):
        self.rate, self.duration_s, self.turns = rate_deg_s, duration_s, True
        self.gain_deg = rate_deg_s * duration_s

    def at(self, u):
        return self.rate * u, np.full(u.size, self.rate)


class Waves:
    """A sum of sines under an envelope that rises and falls smoothly: a vibration table, or a hand.

    angle = e(u) sum_i A_i (sin(2 pi f_i u + p_i)),  e = (1 - cos(pi u / E)) / 2 in the first E seconds, likewise last.
    """

    def __init__(self, amplitudes_deg, frequencies_hz, phases_rad, duration_s, edge_s):
        self.amplitudes, self.frequencies, self.phases = amplitudes_deg, frequencies_hz, phases_rad
        self.duration_s, self.edge_s, self.gain_deg, self.turns = duration_s, edge_s, 0.0, True

    def _envelope(self, u):
        k = np.pi / self.edge_s
        from_end = np.minimum(u, self.duration_s - u)
        rising = np.where(u < self.duration_s - u, 1.0, -1.0)
        inside = np.clip(from_end, 0.0, self.edge_s)
        return (1.0 - np.cos(k * inside)) / 2.0, rising * k * np.sin(k * inside) / 2.0

    def at(self, u):
        angle, rate = np.zeros(u.size), np.zeros(u.size)
        for amplitude, frequency, phase in zip(self.amplitudes, self.frequencies, self.phases):
            omega = 2.0 * np.pi * frequency
            angle += amplitude * np.sin(omega * u + phase)
            rate += amplitude * omega * np.cos(omega * u + phase)
        envelope, slope = self._envelope(u)
        return envelope * angle, envelope * rate + slope * angle


class AxisPath:
    """One axis over one table: pieces one after the other, from `start_s` and `start_deg`."""

    def __init__(self, start_s, start_deg):
        self.starts_s, self.starts_deg, self.pieces = [], [], []
        self.end_s, self.end_deg = start_s, start_deg

    def add(self, piece):
        self.starts_s.append(self.end_s)
        self.starts_deg.append(self.end_deg)
        self.pieces.append(piece)
        self.end_s += piece.duration_s
        self.end_deg += piece.gain_deg

    def turns(self):
        return any(piece.turns for piece in self.pieces)

    def at(self, t_s):
        """Angle [deg] and rate [deg/s] at increasing times; outside the table the axis rests."""
        angle, rate = np.full(t_s.size, self.end_deg), np.zeros(t_s.size)
        edges = np.searchsorted(t_s, self.starts_s + [self.end_s])
        angle[:edges[0]] = self.starts_deg[0]
        for i, piece in enumerate(self.pieces):
            part = slice(edges[i], edges[i + 1])
            if piece.turns:
                gained, rate[part] = piece.at(t_s[part] - self.starts_s[i])
                angle[part] = self.starts_deg[i] + gained
            else:
                angle[part] = self.starts_deg[i]
        return angle, rate


class Table:
    """Motion of one table: three axes in step. Times count from power-on."""

    def __init__(self, start_s, pose_deg, interval_s, straight_ramps_deg_s2=0.0):
        self.start_s, self.interval_s = start_s, interval_s
        self.acceleration, self.straight_ramps_deg_s2 = allowed_acceleration(interval_s), straight_ramps_deg_s2
        self.paths = [AxisPath(start_s, angle) for angle in pose_deg]

    @property
    def end_s(self):
        return max(path.end_s for path in self.paths)

    def rest(self, duration_s):
        for path in self.paths:
            path.add(Rest(duration_s))

    def _align(self):
        for path in self.paths:
            if path.end_s < self.end_s:
                path.add(Rest(self.end_s - path.end_s))

    def turn(self, *moves):
        """Turns at once; each move is (axis index, angle [deg] with sign, speed [deg/s])."""
        for axis, angle_deg, speed_deg_s in moves:
            ramp, ramp_s = self._ramp(speed_deg_s)
            speed = min(speed_deg_s, abs(angle_deg) / ramp_s)
            rate = np.copysign(speed, angle_deg)
            path = self.paths[axis]
            path.add(ramp(rate, ramp_s, True))
            path.add(Cruise(rate, abs(angle_deg) / speed - ramp_s))
            path.add(ramp(rate, ramp_s, False))
        self._align()

    def _ramp(self, speed_deg_s):
        """Kind and duration of a ramp to that speed. A straight one has two samples at least in it, and does not begin
        and end at the same part of an interval between samples, where its errors would be one another's."""
        if self.straight_ramps_deg_s2:
            return StraightRamp, max(speed_deg_s / self.straight_ramps_deg_s2, 2.25 * self.interval_s)
        acceleration = np.clip(self.acceleration, LEAST_ACCELERATION_DEG_S2, ACCELERATION_DEG_S2)
        return Ramp, max(np.pi / 2.0 * speed_deg_s / acceleration, 0.3, 8.0 * self.interval_s)

    def corners(self):
        """Where the acceleration of an axis jumps: (time [s], axis, jump [deg/s^2])."""
        found = []
        for axis, path in enumerate(self.paths):
            for start_s, piece in zip(path.starts_s, path.pieces):
                if isinstance(piece, StraightRamp):
                    jump = piece.rate / piece.duration_s * (1.0 if piece.up else -1.0)
                    found += [(start_s, axis, jump), (start_s + piece.duration_s, axis, -jump)]
        return found

    def wave(self, axis, amplitudes_deg, frequencies_hz, phases_rad, duration_s, edge_s):
        """Starts a motion of one axis; each sine is made smaller where its acceleration would be too large."""
        frequencies_hz = np.asarray(frequencies_hz)
        limits_deg = self.acceleration / (2.0 * np.pi * frequencies_hz) ** 2
        amplitudes_deg = np.minimum(amplitudes_deg, limits_deg)
        self.paths[axis].add(Waves(amplitudes_deg, frequencies_hz, phases_rad, duration_s, edge_s))

    def settle(self):
        """Ends a motion of several axes."""
        self._align()

    def at(self, t_s):
        """Angles (3, n) [deg] and rates of the axes (3, n) [deg/s]."""
        both = [path.at(t_s) for path in self.paths]
        return np.array([angle for angle, _ in both]), np.array([rate for _, rate in both])

    def turning_axes(self):
        return [path.turns() for path in self.paths]
