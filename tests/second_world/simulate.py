"""The measuring: what the sensor and the reference give out for what truly happens.

xi/s0 = M w + b(T) + effects + noise (the catalogue's forward model). Effects of time and of the reference are not
added as terms: the motion is asked for at the time that is meant, the lag is integrated, the play is played.
Quantisation comes last.
"""
import numpy as np

import catalogue
import geometry

ARW, BRW = 0.0035, 1e-4  # deg/sqrt(s), deg/s/sqrt(s)


class Hidden:
    """An effect in force: candidate, its linear parameters, and the channel that has it (rate effects)."""

    def __init__(self, candidate, theta, channel):
        self.candidate, self.theta, self.channel = candidate, np.asarray(theta, dtype=float), channel

    def is_of(self, kind):
        effect = self.candidate.effect
        if self.candidate.axis is not None:
            return kind == "axis"
        return kind == ("time" if effect in TIME_EFFECTS else "rate")


TIME_EFFECTS = ("angle.latency", "bandwidth.first_order", "angle.clock_drift")


class Sensor:
    """Nuisance truth of one sensor: M (3, 3), b(T) per channel [deg/s], noise."""

    def __init__(self, rng, bench):
        sign = lambda n: rng.choice([-1.0, 1.0], n)
        self.m = sign((3, 3)) * bench["misalignment"] * rng.uniform(0.3, 1.0, (3, 3))
        np.fill_diagonal(self.m, 1.0 + sign(3) * bench["scale_error"] * rng.uniform(0.3, 1.0, 3))
        self.b = [sign(3) * bench["zero_rate_deg_s"] * rng.uniform(0.7, 1.0, 3),
                  sign(3) * bench["bias_slope"], sign(3) * bench["bias_curvature"], sign(3) * bench["bias_cubic"]]
        self.arw, self.brw = ARW * bench["arw_factor"], BRW * bench["brw_factor"]
        self.turn_on_deg_s = 0.03
        self.resolution = resolution(bench)

    def noise(self, bench):
        """Noise as the bound wants it; the gyro's quantisation is white, and the trapezoid adds it as a walk."""
        effective = np.sqrt(self.arw ** 2 + self.resolution ** 2 / 12.0 / bench["gyro_rate_hz"])
        return dict(arw=self.arw, brw=self.brw, arw_effective=float(effective))

    def bias_deg_s(self, temp_degC):
        x = temp_degC - 30.0
        return self.b[0][:, None] + self.b[1][:, None] * x + self.b[2][:, None] * x ** 2 + self.b[3][:, None] * x ** 3


def resolution(bench):
    """Step of the output [deg/s]."""
    return {"deg_s": 0.01, "rad_s": np.degrees(1e-5)}.get(bench["output"], 1.0 / bench["lsb_per_deg_s"])


def bias_walk(rng, scene, brw):
    """Random walk of three offsets, through the gaps, from a start of its own at each power-on."""
    step_s = np.diff(scene.t_s, prepend=scene.t_s[0])
    walk = rng.standard_normal((3, scene.t_s.size)) * brw * np.sqrt(np.maximum(step_s, 0.0))
    starts = np.flatnonzero(np.diff(scene.power_on, prepend=-1))
    walk = np.cumsum(walk, axis=1)
    for a, b in zip(starts, np.append(starts[1:], scene.t_s.size)):
        walk[:, a:b] -= walk[:, a:a + 1]
    return walk, starts


def sensed_rates(scene, hidden):
    """Rates that reach the sensor (3, n): true ones, or late, or behind a lag."""
    delay_s = sum(h.theta[0] for h in hidden if h.candidate.effect == "angle.latency")
    lag_s = sum(h.theta[0] for h in hidden if h.candidate.effect == "bandwidth.first_order")
    if lag_s:
        return catalogue.lagged_rates(scene, abs(lag_s), delay_s)
    if delay_s:
        return scene.of_samples(lambda t_s, table: scene.rates_in_sensor_at(t_s - delay_s, table))
    return scene.w_deg_s


def gyro_output(rng, scene, sensor, hidden):
    """Outputs xi/s0 [deg/s] of three channels before quantisation, (3, n)."""
    bench = scene.bench
    rates = sensed_rates(scene, hidden)
    if bench["site"]:
        earth = geometry.earth_in_world(bench["latitude_deg"], bench["heading_deg"])
        rates = rates + geometry.world_to_sensor(scene.angles_deg, earth)
    out = sensor.m @ rates + sensor.bias_deg_s(scene.temp_degC)
    walk, starts = bias_walk(rng, scene, sensor.brw)
    for a in starts[1:]:
        out[:, a:] += sensor.turn_on_deg_s * rng.standard_normal((3, 1))
    out += walk
    out += sensor.arw * np.sqrt(bench["gyro_rate_hz"]) * rng.standard_normal(out.shape)
    for h in hidden:
        if h.is_of("rate"):
            terms = catalogue.rate_terms(scene, h.channel, h.candidate.effect, h.candidate.nonlinear)
            out[h.channel] += sum(theta * term for theta, term in zip(h.theta, terms))
    return out


def quantised(bench, sensor, out):
    """Outputs as printed, in the unit of the table; counts of an unsigned converter stand around 32768."""
    if bench["output"] in ("lsb", "unsigned"):
        zero = 32768.0 if bench["output"] == "unsigned" else 0.0
        return np.clip(np.rint(out * bench["lsb_per_deg_s"]), -32768, 32767) + zero
    if bench["output"] == "rad_s":
        return np.rint(np.radians(out) / 1e-5) * 1e-5
    return np.rint(out / sensor.resolution) * sensor.resolution


def reference_angles(rng, scene, hidden):
    """Readings (3, n) of the three axes [deg], each with its errors, noise and counts."""
    bench = scene.bench
    t_s = scene.t_read_s.copy()
    for h in hidden:
        if h.candidate.effect == "angle.clock_drift":
            t_s = t_s * (1.0 - h.theta[0])
    angles, _ = scene.motion_at(t_s, scene.table_read)
    read = angles.copy()
    for h in hidden:
        if h.is_of("axis"):
            read[h.candidate.axis] -= axis_error(scene, h, angles[h.candidate.axis])
    read += bench["reference_noise_deg"] * rng.standard_normal(read.shape)
    count_deg = 360.0 / 2 ** bench["encoder_bits"]
    zero_deg = 0.0 if bench["encoder_zero_on_count"] else rng.uniform(0.0, count_deg, (3, 1))
    return np.rint((read + zero_deg) / count_deg) * count_deg - zero_deg


def axis_error(scene, h, angle_deg):
    """z less reading [deg] at the readings, of one hidden effect of one axis."""
    effect, p = h.candidate.effect, h.candidate.nonlinear
    if effect == "angle.backlash":
        return catalogue.backlash(angle_deg, abs(h.theta[0])) * np.sign(h.theta[0])
    if effect == "angle.step":
        return h.theta[0] * ((scene.table_read == p["table"]) & (scene.t_read_s >= p["t0_s"]))
    terms = catalogue.waves(effect, np.radians(angle_deg), p)
    return sum(theta * term for theta, term in zip(h.theta, terms))


def reference_quaternions(rng, scene, hidden):
    """Readings (4, n): the true orientation turned by a small random vector in S."""
    t_s = scene.t_read_s.copy()
    for h in hidden:
        if h.candidate.effect == "angle.clock_drift":
            t_s = t_s * (1.0 - h.theta[0])
    angles, _ = scene.motion_at(t_s, scene.table_read)
    noise_rad = np.radians(scene.bench["reference_noise_deg"]) * rng.standard_normal((3, t_s.size))
    small = np.vstack([np.ones(t_s.size), noise_rad / 2.0])
    q = geometry.multiply(geometry.quaternion_of(angles), small)
    return q / np.sqrt((q ** 2).sum(axis=0))
