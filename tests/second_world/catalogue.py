"""The catalogue's effects as responses of the residual angle, per unit of their parameters.

The residual is z - Phi: the gyro's integrated output less the reference angle about the channel's axis [deg].
Equations and the sizes that such parts show are those of the catalogue's page. Three kinds:
    rate   a term of the channel's rate [deg/s]; its response is the term's integral;
    axis   an error of one stand axis's angle [deg];
    time   an error of time, of the whole sensor; its response is a time times the rate.
"""
import math

import numpy as np

import geometry
import lag
from thermal import play

GEAR = 40.0
EARTH = "bias.earth_rate"  # never hidden; what may pass for it is told from it by who knows the site


class Candidate:
    """One effect with its non-linear parameters fixed: a group of columns with linear parameters."""

    def __init__(self, effect, axis=None, **nonlinear):
        self.effect, self.axis, self.nonlinear = effect, axis, nonlinear

    def __repr__(self):
        extra = "" if self.axis is None else f"@{self.axis}"
        return f"{self.effect}{extra}{self.nonlinear or ''}"


def hysteresis(scene, r):
    """P_r[T] - T with the play operator starting at rest in the first temperature."""
    return scene.over_power_ons(lambda th: play(th.true_degC, r, th.true_degC[0]) - th.true_degC)


def after(scene, table, t_s):
    """1 after an instant: time t_s of table `table`, and in all later tables of the same power-on."""
    later = (scene.table > table) | ((scene.table == table) & (scene.t_s >= t_s))
    return (later & (scene.power_on == scene.plan.power_on[table])).astype(float)


def wave(phase):
    return [np.sin(phase), np.cos(phase)]


def turns(scene):
    """1 while any axis turns: a motor that rests makes no steps, and nothing shakes."""
    return (np.abs(scene.w_deg_s).max(axis=0) > 1e-6).astype(float)


def centred(values):
    return values - values.mean()


def rate_terms(scene, channel, effect, p):
    """Terms of the channel's rate, one an independent linear parameter [deg/s per unit]."""
    w, g = scene.w_deg_s[channel], scene.g
    if effect.startswith("unknown."):
        return unknown_terms(scene, channel, effect, p)
    if effect.startswith(("bias.of(", "scale.of(")):
        x = centred(scene.covariates[effect[effect.index("(") + 1:-1]])
        return [x if effect.startswith("bias") else w * x]
    return {
        EARTH: lambda: [geometry.world_to_sensor(scene.angles_deg, axis)[channel] for axis in np.eye(3)],
        "bias.g_linear": lambda: list(g),
        "bias.g_squared": lambda: [g[0] ** 2, g[1] ** 2],
        "scale.g": lambda: list(g * w),
        "scale.temperature": lambda: [w * centred(scene.temp_degC)],
        "scale.quadratic_odd": lambda: [w * np.abs(w)],
        "scale.cubic": lambda: [w ** 3],
        "scale.quadratic_even": lambda: [w ** 2],
        "scale.asymmetry": lambda: [np.abs(w)],
        "bias.temperature_rate": lambda: [scene.temp_rate],
        "bias.hysteresis": lambda: [hysteresis(scene, p["r_degC"])],
        "bias.warm_up": lambda: [np.exp(-scene.t_s / p["tau_s"])],
        "bias.step": lambda: [after(scene, p["table"], p["t0_s"])],
        "bias.tone": lambda: wave(2 * np.pi * p["f_hz"] * scene.t_s),
        "bias.vibration": lambda: [turns(scene) / (1.0 + ((np.abs(w) - p["f0_deg_s"]) / p["width_deg_s"]) ** 2)],
    }[effect]()


def axis_errors(scene, effect, axis, p):
    """Errors of one axis's angle, z - reading, one an independent linear parameter [deg per unit]."""
    phi = np.radians(scene.angles_deg[axis])
    if effect == "angle.backlash":
        return [backlash(scene.angles_deg[axis], 1e-3) / 1e-3]
    if effect == "angle.step":
        return [((scene.table == p["table"]) & (scene.t_s >= p["t0_s"])).astype(float)]
    return waves(effect, phi, p)


def waves(effect, phi_rad, p):
    """Sine and cosine of a periodic error of the angle."""
    times = {"angle.worm_period": GEAR, "angle.eccentricity_1": 1.0, "angle.eccentricity_2": 2.0}
    return wave(times.get(effect, p.get("k")) * phi_rad)


def backlash(angle_deg, width_deg):
    """True angle less what a sensor behind a play of that width shows: (b/2) sgn(last w) once the play is taken up."""
    return angle_deg - play(angle_deg, width_deg / 2.0, angle_deg[0] - width_deg / 2.0)


def responses(scene, channel, candidate):
    """Columns (p, readings): what one unit of each linear parameter adds to the residual angle."""
    effect, p = candidate.effect, candidate.nonlinear
    if candidate.axis is not None:
        return np.array([scene.projected(candidate.axis, channel, e)
                         for e in axis_errors(scene, effect, candidate.axis, p)])
    if effect == "angle.latency":
        return -scene.at_readings(scene.w_deg_s[channel])[None]
    if effect == "angle.clock_drift":
        return (scene.t_read_s * scene.at_readings(scene.w_deg_s[channel]))[None]
    if effect == "bandwidth.first_order":
        change = lagged_rates(scene, p["tau_s"])[channel] - scene.w_deg_s[channel]
        return scene.integrate(change)[None] / p["tau_s"]
    return np.array([scene.integrate(term) for term in rate_terms(scene, channel, effect, p)])


def slopes(scene, channel, candidate, theta):
    """Columns (q, readings) of the non-linear parameters that a tracer has to find as well, by central differences."""
    found = []
    for name in ("r_degC", "tau_s", "f_hz", "f0_deg_s", "width_deg_s"):
        if name not in candidate.nonlinear or candidate.effect == "bandwidth.first_order":
            continue
        value = candidate.nonlinear[name]
        step = 1e-3 * value if name != "f_hz" else 1e-6
        ends = [theta @ responses(scene, channel, Candidate(candidate.effect, candidate.axis,
                                                            **dict(candidate.nonlinear, **{name: value + s})))
                for s in (-step, step)]
        found.append((ends[1] - ends[0]) / (2.0 * step))
    return found


def lagged_rates(scene, tau_s, delay_s=0.0):
    """The sensor's rates (3, n) behind a lag, as its samples say them."""
    def rates_at(t_s, table):
        angles, rates = table.at(t_s - delay_s)
        return geometry.rates_in_sensor(geometry.axis_directions(angles), rates)

    def lagged_at(t_s, number):
        return np.hstack([lag.lagged(lambda t, table=table: rates_at(t, table), t_s[number == i], tau_s)
                          for i, table in enumerate(scene.plan.tables)])
    return scene.of_samples(lagged_at)


def draw_direction(rng, effect, size):
    """Which linear parameters an effect has, as a vector of length 1.

    Gravity changes a scale along one axis. Of its squares g_z^2 is 1 - g_x^2 - g_y^2, the 1 being the offset's.
    """
    if effect == "scale.g":
        return rng.choice([-1.0, 1.0]) * np.eye(3)[rng.integers(3)]
    if effect == "bias.g_squared":
        return rng.choice([-1.0, 1.0]) * np.array([[1.0, 0.0], [0.0, 1.0], [-0.7071, -0.7071]])[rng.integers(3)]
    direction = rng.standard_normal(size)
    direction /= np.linalg.norm(direction)
    positive = effect in ("angle.latency", "bandwidth.first_order", "angle.backlash")
    return np.abs(direction) if positive else direction


def size_of(spread, term):
    """The coefficient with which a term spreads by so much; 0 of what stays as it is, which shows no effect."""
    own = np.std(term)
    return spread / own if own > 1e-6 else 0.0


def largest(scene, channel, candidate):
    """The largest size that such parts show, in the unit of the linear parameters."""
    top = max(np.abs(scene.w_deg_s[channel]).max(), 1e-9)
    effect = candidate.effect
    if effect.startswith("unknown."):
        return size_of(0.3, unknown_terms(scene, channel, effect, candidate.nonlinear)[0])
    if effect.startswith(("bias.of(", "scale.of(")):
        return size_of(0.1 if effect.startswith("bias") else 0.002, scene.covariates[effect[effect.index("(") + 1:-1]])
    return {"bias.g_linear": 0.1, "bias.g_squared": 0.02, "scale.g": 1e-3, "scale.temperature": 3e-4,
            "scale.quadratic_odd": 2e-3 / top, "scale.cubic": 2e-3 / top ** 2, "scale.quadratic_even": 1e-3 / top,
            "scale.asymmetry": 1e-3, "bias.temperature_rate": 1.0, "bias.hysteresis": 0.1, "bias.warm_up": 0.3,
            "bias.step": 0.5, "bias.tone": 1.0, "bias.vibration": 0.5, "angle.latency": 0.020,
            "bandwidth.first_order": 0.020, "angle.clock_drift": 1e-4, "angle.worm_period": 0.025,
            "angle.ripple": 0.5, "angle.eccentricity_1": 0.05, "angle.eccentricity_2": 0.05, "angle.backlash": 0.1,
            "angle.step": 0.5}[effect]


def draw_candidates(rng, scene, channel):
    """What may be hidden on this bench and what may rival it: the first of each id is the one that may be hidden."""
    found = _rate_candidates(rng, scene, channel)
    found += [Candidate("angle.latency"), Candidate("angle.clock_drift")]
    found += [Candidate("bandwidth.first_order", tau_s=tau) for tau in (0.002, 0.008)]
    if scene.bench["reference"] in ("stand", "single"):
        for axis in axes_felt(scene, channel):
            found += _axis_candidates(rng, scene, axis)
    return found


def between(scene, channel):
    """Rivals at more values of what nobody tells a tracer: the play, the time constant, where a resonance is."""
    top_deg_s = np.abs(scene.w_deg_s[channel]).max()
    found = [Candidate("bias.hysteresis", r_degC=r) for r in (0.3, 0.8, 1.1, 2.0, 3.0)]
    found += [Candidate("bias.warm_up", tau_s=t) for t in (60.0, 180.0, 450.0, 1100.0)]
    return found + [Candidate("bias.vibration", f0_deg_s=f, width_deg_s=3.0)
                    for f in np.linspace(0.1, 1.0, 10) * top_deg_s if f > 2.0]


def axes_felt(scene, channel):
    """Stand axes that turn by 90 deg or more while the channel feels them, that which is felt most first."""
    travel = [np.abs(scene.directions[a, channel, 1:] * np.diff(scene.angles_deg[a])
                     * (np.diff(scene.table) == 0)).sum() for a in range(3)]
    return [a for a in np.argsort(travel)[::-1] if travel[a] > 90.0]


def _rate_candidates(rng, scene, channel):
    top = np.abs(scene.w_deg_s[channel]).max()
    plain = ["bias.g_linear", "bias.g_squared", "scale.g", "scale.temperature", "scale.quadratic_odd", "scale.cubic",
             "scale.quadratic_even", "scale.asymmetry", "bias.temperature_rate"]
    found = [Candidate(effect) for effect in plain]
    found += [Candidate("bias.hysteresis", r_degC=r) for r in (rng.uniform(0.4, 2.5), 0.5, 1.5)]
    found += [Candidate("bias.warm_up", tau_s=t) for t in (np.exp(rng.uniform(4.6, 6.5)), 120.0, 300.0, 700.0)]
    found += [Candidate("bias.step", **instant(rng, scene)) for _ in range(8)]
    found += [Candidate("bias.tone", f_hz=f) for f in (np.exp(rng.uniform(*np.log(TONES_HZ))), 0.05, 0.5)]
    found += [Candidate("bias.vibration", f0_deg_s=f, width_deg_s=rng.uniform(1.5, 5.0))
              for f in (rng.uniform(0.2, 0.75) * top, 0.25 * top, 0.5 * top, 0.75 * top)]
    for name in scene.covariates:
        found += [Candidate(f"bias.of({name})"), Candidate(f"scale.of({name})")]
    return found


def _axis_candidates(rng, scene, axis):
    found = [Candidate(effect, axis) for effect in
             ("angle.eccentricity_1", "angle.eccentricity_2", "angle.backlash")]
    if scene.bench["gear_key"]:
        found.append(Candidate("angle.worm_period", axis))
    orders = [k for k in rng.permutation(np.arange(*RIPPLES)) if k not in (40, 80)][:3]
    found += [Candidate("angle.ripple", axis, k=int(k)) for k in orders]
    found += [Candidate("angle.step", axis, **instant(rng, scene, axis)) for _ in range(6)]
    return found


TONES_HZ = (math.exp(-3.0), math.exp(1.2))
RIPPLES = (3, 120)


def instant(rng, scene, axis=None):
    """A table and a time well inside it; for an axis's angle a table in which the axis turns."""
    fitting = [i for i, t in enumerate(scene.plan.tables) if axis is None or t.turning_axes()[axis]]
    i = int(rng.choice(fitting))
    table = scene.plan.tables[i]
    share = rng.uniform(0.1, 0.9)
    return dict(table=i, t0_s=float(table.start_s + share * (table.end_s - table.start_s)))


def unknown_candidates(rng, scene, channel):
    """Effects that no catalogue has: products of two quantities, and an offset that jumps or stops with temperature."""
    found = [Candidate("unknown.product", pair=pair) for pair in
             (("abs_w", "T"), ("g_x", "T"), ("g_z", "T"), ("abs_w", "g_x"), ("abs_w", "g_z"))]
    order = [found[i] for i in rng.permutation(len(found))]
    low, high = np.quantile(scene.temp_degC, [0.25, 0.75])
    at = rng.uniform(low, high)
    return order[:1] + [Candidate("unknown.bias_jump", at_degC=at),
                        Candidate("unknown.bias_flat", from_degC=at, to_degC=at + 2.0), *crossing(scene, at)]


def crossing(scene, at_degC):
    """The step of the offset that a jump at a temperature is where that temperature is passed once; none where it is
    not passed."""
    passed = np.flatnonzero((scene.temp_degC > at_degC) != (scene.temp_degC[0] > at_degC))
    return [Candidate("bias.step", table=int(scene.table[i]), t0_s=float(scene.t_s[i])) for i in passed[:1]]


def unknown_terms(scene, channel, effect, p):
    """Terms of the rate of effects out of the catalogue [deg/s per unit]."""
    quantity = {"abs_w": np.abs(scene.w_deg_s[channel]), "g_x": scene.g[0], "g_z": scene.g[2],
                "T": centred(scene.temp_degC)}
    if effect == "unknown.product":
        return [quantity[p["pair"][0]] * quantity[p["pair"][1]]]
    if effect == "unknown.bias_jump":
        return [(scene.temp_degC > p["at_degC"]).astype(float)]
    return [np.clip(scene.temp_degC, p["from_degC"], p["to_degC"])]
