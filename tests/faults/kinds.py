"""Faults that the campaign puts in, one a scenario, and what each must lead to. Drawn from a seed."""
import random

AXES = ["outer", "middle", "inner"]
DRIVES = [f"{axis}.drive" for axis in AXES]
ENCODERS = [f"{axis}.encoder" for axis in AXES]
ALL = ["gyro", *DRIVES, *ENCODERS]

LONG_S, SHORT_S = (60.0, 120.0), (0.05, 0.3)

# How a run may end: done, resumed (a device was waited for), stopped (a fault that names the device), refused (the
# analysis says that its result cannot be), not_begun.
ANY = {"done", "resumed", "stopped", "refused", "not_begun"}
ENDS = {"stopped", "not_begun"}
HELD = ENDS | {"resumed"}


class Kind:
    """name: of the row in the table. kind: of the scenario. devices: of which one is drawn. keys: further keys of
    [[fault]]; a pair is a range to draw from. ends: how a run may end in which the fault has acted. acts: when it has:
    "at once"; "in motion": its axis was told to turn by `enough_deg` after the begin; "astray": the table was so far
    from where it was told to go. marks: a run that goes on must say that something was, whatever its result is."""

    def __init__(self, name, devices, ends, kind=None, acts="at once", enough_deg=0.0, marks=False, **keys):
        self.name, self.kind, self.devices, self.ends, self.marks = name, kind or name, devices, ends, marks
        self.acts, self.enough_deg, self.keys = acts, enough_deg, keys


KINDS = [
    Kind("silent for long", ALL, HELD, "silent", duration_s=LONG_S),
    Kind("silent for an instant", ALL, {"done", "resumed"}, "silent", duration_s=SHORT_S),
    Kind("garbage", ALL, HELD, duration_s=LONG_S),
    Kind("garbage at times", ALL, {"done", "resumed"}, "garbage", probability=(0.01, 0.05), duration_s=(2.0, 8.0)),
    Kind("bad_crc", ALL, HELD, duration_s=LONG_S),
    Kind("bad_crc at times", ALL, {"done", "resumed"}, "bad_crc", probability=(0.01, 0.05), duration_s=(2.0, 8.0)),
    Kind("late", ALL, {"done", "resumed"}, amount=(0.002, 0.02), duration_s=(1.0, 20.0)),
    Kind("exception", ALL, HELD, amount=[0, 2, 4, 6], duration_s=LONG_S),
    Kind("exception at times", ALL, ANY, "exception", probability=(0.01, 0.05), duration_s=(2.0, 8.0)),
    Kind("stale at times", ALL, ANY, "stale", probability=(0.01, 0.1), duration_s=(2.0, 30.0)),
    Kind("stale", ALL, ANY, duration_s=LONG_S),
    Kind("wrong_identity", ["gyro", *DRIVES], ANY, duration_s=LONG_S),
    Kind("reboot of the unit", ["gyro"], ANY, "reboot", marks=True),
    Kind("reboot of a drive", DRIVES, HELD, "reboot"),
    Kind("reboot of a reference", ENCODERS, {"done", "resumed"}, "reboot"),
    Kind("frozen sensor", ["gyro"], ANY, "frozen", marks=True, duration_s=(0.5, 60.0)),
    Kind("frozen reference", ENCODERS, HELD, "frozen", acts="in motion", enough_deg=10.0, duration_s=LONG_S),
    Kind("frozen drive", DRIVES, ANY, "frozen", acts="in motion", enough_deg=10.0, duration_s=LONG_S),
    Kind("jump of the sensor", ["gyro"], ANY, "jump", amount=(-20.0, 20.0), duration_s=LONG_S),
    Kind("jump of a reference", ENCODERS, ANY, "jump", amount=(3.0, 200.0), duration_s=(0.05, 60.0)),
    Kind("jump of a drive's count", DRIVES, ANY, "jump", amount=(5000.0, 100000.0), duration_s=LONG_S),
    Kind("dropout", ENCODERS, ANY, amount=[-1, 0, 4095], duration_s=(0.02, 30.0)),
    Kind("loose", ENCODERS, ANY, acts="in motion", enough_deg=10.0, amount=(0.2, 0.9), duration_s=LONG_S),
    Kind("saturation", ["gyro"], ANY, marks=True, amount=[-1, 1], duration_s=(0.2, 30.0)),
    Kind("overheating", ["gyro"], ANY, amount=(20.0, 150.0), duration_s=LONG_S),
    Kind("clock_jump", ["gyro"], ANY, amount=(-2.0, 2.0)),
    Kind("alarm", DRIVES, ENDS, amount=[1, 3, 14, 0x1A]),
    Kind("lost_steps", DRIVES, ENDS, acts="astray", enough_deg=3.0, amount=(5000.0, 50000.0)),
    Kind("a few lost_steps", DRIVES, ANY, "lost_steps", amount=(10.0, 500.0)),
    Kind("jammed", DRIVES, ENDS, acts="astray", enough_deg=3.0, duration_s=LONG_S),
    Kind("slipping", DRIVES, ENDS, acts="astray", enough_deg=3.0, amount=(0.2, 0.9), duration_s=LONG_S),
    Kind("emergency_stop", DRIVES, HELD, duration_s=LONG_S),
    Kind("limit_plus", DRIVES, ANY, duration_s=LONG_S),
    Kind("limit_minus", DRIVES, ANY, duration_s=LONG_S),
    Kind("runaway", DRIVES, ENDS, amount=(2.0, 20.0), duration_s=LONG_S),
]

# Requests that a device gets until a short run is well under way.
ABOUT_PER_RUN = {"gyro": 600, "drive": 60, "encoder": 1200, "relays": 40}

# Each shipped procedure, short; the axes that it turns; for how many seconds at least.
PROCEDURES = {
    "bias": ("bias:initial_rest_s=5:window_s=10:max_duration_s=60", ["inner"], 40),
    "scale": ("scale:turns=8:rest_s=1:initial_rest_s=5", ["inner"], 30),
    "poses": ("poses:poses=6:rest_s=3:initial_rest_s=5", ["outer", "middle"], 35),
    "rates": ("rates:axes=z:rates_deg_s=20:angle_deg=90:rest_s=1:initial_rest_s=5", ["inner", "outer"], 35),
    "sweep": ("sweep:frequencies_hz=0.4,0.8:duration_s=5:initial_rest_s=5", ["inner"], 12),
    "thermal": ("thermal:rest_s=5:warm_up_s=40:cooling_s=30", ["inner"], 90),
    "full": ("full:warm_up_s=20:fan=false", ["inner", "middle"], 200),
    "close_loop": ("close_loop:budget_min=3:initial_rest_s=10", ["inner"], 150),
    "hold": ("hold:poses=10:rest_s=2", ["outer", "middle", "inner"], 60),
}


class Scenario:
    """One fault in one procedure. `fault`: keys of its [[fault]]; `must`: how the run may end where it has acted."""

    def __init__(self, kind, procedure, seed):
        draw = random.Random(f"{kind.name}/{procedure}/{seed}")
        self.kind, self.procedure, self.seed = kind, procedure, seed
        self.command, axes, self.lasts_s = PROCEDURES[procedure]
        # The fan and the heater of `thermal` are behind a relay unit.
        self.stand = "relays.toml" if procedure == "thermal" else "virtual.toml"
        has_relays = kind.devices is ALL and procedure == "thermal"
        self.device = draw.choice([*kind.devices, *(3 * ["relays"] if has_relays else [])])
        # An axis that does not turn cannot show what needs motion.
        if kind.acts != "at once":
            self.device = f"{draw.choice(axes)}.{self.device.split('.')[1]}"
        self.fault = {"device": self.device, "kind": kind.kind}
        for key, value in kind.keys.items():
            self.fault[key] = round(draw.uniform(*value), 3) if isinstance(value, tuple) else (
                draw.choice(value) if isinstance(value, list) else value)
        self.begin(draw, axes)
        # A device that does not answer at all is given up at the first try, since each try costs two seconds of real time.
        self.retries = 0 if kind.ends == HELD and kind.acts == "at once" else 2
        self.name = f"{kind.name}/{self.device}/{procedure}/seed{seed}"

    def begin(self, draw, axes):
        """By the clock, by a move, or by a request: a third each where a move is to be expected."""
        event = draw.choice(["power_on", "move", "request"])
        if event == "move" and self.procedure != "bias":
            self.fault.update(on="move", axis=draw.choice(axes), count=draw.randint(1, 3),
                              at_s=round(draw.uniform(0.0, 3.0), 3))
        elif event == "request":
            part = self.device.split(".")[-1]
            self.fault.update(on="request", count=draw.randint(3, ABOUT_PER_RUN[part]))
        else:
            # The clocks are compared for 20 s before a procedure begins; a few faults come before that.
            self.fault["at_s"] = round(draw.uniform(15.0, 20.0 + self.lasts_s), 3)

    def toml(self):
        lines = ['include = "{root}/config/scenarios/typical.toml"', "[[fault]]"]
        return "\n".join(lines + [f"{key} = {quoted(value)}" for key, value in self.fault.items()]) + "\n"


# The long ones, a minute of processor time each, come one time in twelve.
OFTEN = [name for name in PROCEDURES if name not in ("full", "close_loop")]
IN_TURN = [*OFTEN, "full", *OFTEN, "close_loop", *OFTEN]


def quoted(value):
    return f'"{value}"' if isinstance(value, str) else value


def scenarios(first_seed, count, kinds=None, procedures=None):
    """`count` of them: every kind in turn, each time with another procedure and seed."""
    kinds = [kind for kind in KINDS if not kinds or kind.name in kinds]
    names = procedures or IN_TURN
    return [Scenario(kinds[i % len(kinds)], names[(i + i // len(kinds)) % len(names)], first_seed + i)
            for i in range(count)]
