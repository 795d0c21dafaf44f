"""The stands that the campaign runs on, and what is hidden in each: ids of effects, as the tracer may name them.

A world is a scenario of config/scenarios as it is, or `quiet` (a typical stand and part without any effect) with one
effect of the scenario's keys. What is true of a world is said here by hand, from stand/README.md; nothing of the
analysis is asked.
"""
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What the default stand and part have beyond a perfect one, as far as the tracer compares gyro and reference. Worm and
# backlash turn the table itself, which gyro and encoder both see.
# Readings meet the encoder's refresh, every 0.1 ms, at the same moment throughout a run and at another in the next: the
# delays of two runs differ by up to that.
TYPICAL = {"angle.latency", "angle.latency_of_run", "angle.eccentricity_1", "angle.eccentricity_2", "bias.g_linear",
           "scale.temperature"}

SHIPPED = {
    "typical": TYPICAL,
    "cold-start": TYPICAL,
    "ideal": set(),
    "full-sequence": set(),
    "undeclared": TYPICAL | {"scale.cubic"},
}

# typical.toml without what TYPICAL lists. A value that is refreshed every 0.1 ms is 0.05 ms late in the mean.
QUIET = {
    "drawn": {"gyro_g_linear_deg_s_per_g": 0.0, "gyro_scale_temperature_per_degC": 0.0},
    "encoder": {"latency_s": 0.0, "refresh_s": 1e-6, "eccentricity_1_deg": 0.0, "eccentricity_2_deg": 0.0},
}


def on_z(*row):
    """A row for the z axis of a 3x3 matrix."""
    return [0.0] * 6 + [float(value) for value in row]


def z(value):
    return [0.0, 0.0, value]


# Of each effect: the id that is true, and the keys of the scenario that make it, at the size of a part in which it
# matters ("high" in the table of levels that the blind trials use, where that has the effect).
EFFECTS = {
    "bias.g_linear": {"gyro": {"g_linear_deg_s_per_g": on_z(0.03, 0.02, 0.05)}},
    "bias.g_squared": {"gyro": {"g_squared_deg_s_per_g2": on_z(0.05, 0.0, 0.0)}},
    "scale.g": {"gyro": {"scale_g_per_g": on_z(0.0, 0.0, 1e-3)}},
    "scale.temperature": {"gyro": {"scale_temperature_per_degC": z(3e-4)}},
    "scale.quadratic_odd": {"gyro": {"quadratic_odd_per_deg_s": z(5e-5)}},
    "scale.cubic": {"gyro": {"cubic_per_deg2_s2": z(1.25e-6)}},
    "scale.quadratic_even": {"gyro": {"quadratic_even_per_deg_s": z(2.5e-5)}},
    "scale.asymmetry": {"gyro": {"asymmetry_rel": z(1e-3)}},
    "bias.temperature_rate": {"gyro": {"temperature_rate_deg_s_per_degC_s": z(1.0)}},
    "bias.hysteresis": {"gyro": {"hysteresis_deg_s_per_degC": z(0.03)}},
    "bias.warm_up": {"gyro": {"warm_up_deg_s": z(0.3)}},
    "bias.step": {"gyro.bias_step": {"at_s": 120.0, "deg_s": z(0.1)}},
    "bias.tone": {"gyro.tone": {"frequency_hz": 2.0, "deg_s": z(0.1)}},
    "bias.vibration": {"mechanics": {"resonance_deg_s": 20.0, "resonance_width_deg_s": 2.0,
                                     "resonance_vibration_g": 0.1},
                       "gyro": {"vibration_deg_s_per_g2": z(5.0)}},
    "angle.latency": {"gyro": {"filter_delay_rel": 0.5}},
    "bandwidth.first_order": {"gyro": {"extra_lag_s": 0.005}},
    "angle.clock_drift": {"encoder": {"clock_drift_rel": 1e-4}},
    "angle.worm_period": {"encoder": {"worm_1_deg": 0.01}},
    "angle.ripple": {"encoder": {"ripple_deg": 0.02, "ripple_per_turn": 360.0}},
    "angle.eccentricity_1": {"encoder": {"eccentricity_1_deg": 0.03}},
    "angle.eccentricity_2": {"encoder": {"eccentricity_2_deg": 0.01}},
    "angle.backlash": {"encoder": {"backlash_deg": 0.02}},
    "angle.step": {"encoder": {"step_at_s": 120.0, "step_deg": 0.1}},
}

LISTS = {"gyro.bias_step", "gyro.tone"}  # written [[section]]


def merged(*layers):
    """Sections of keys, the later layer in front."""
    out = {}
    for layer in layers:
        for section, keys in layer.items():
            out.setdefault(section, {}).update(keys)
    return out


def toml(include, sections):
    """A scenario file: another one, with these keys in front of its own."""
    lines = [f'include = "{ROOT}/config/scenarios/{include}.toml"']
    for section, keys in sections.items():
        lines.append(f"[[{section}]]" if section in LISTS else f"[{section}]")
        lines += [f"{key} = {value}" for key, value in keys.items()]
    return "\n".join(lines) + "\n"


class World:
    """name; scenario: the text of its file; truth: ids of the effects in it; hidden: the one that was put in, or
    None."""

    def __init__(self, name, scenario, truth, hidden=None):
        self.name, self.scenario, self.truth, self.hidden = name, scenario, set(truth), hidden


def all_worlds():
    """Every world by its name, those that are shipped first."""
    worlds = [World(name, toml(name, {}), truth, "scale.cubic" if name == "undeclared" else None)
              for name, truth in SHIPPED.items()]
    worlds.append(World("quiet", toml("typical", QUIET), set()))
    worlds += [World(f"quiet+{effect}", toml("typical", merged(QUIET, keys)), {effect}, effect)
               for effect, keys in EFFECTS.items()]
    return {world.name: world for world in worlds}
