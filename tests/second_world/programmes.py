"""Programmes of motion: each returns the tables of one set and what the room's temperature does.

Poses of the stand (outer, middle, inner) [deg]: z up (0, 0, .), z horizontal (0, 90, .), z down (0, 180, .);
x vertical (., 90, 90) and y vertical (., 90, 0), turned by the outer axis; x horizontal, turned by the middle axis.
The numbers of the full sequence are those of the catalogue's page ("The full sequence").
"""
import numpy as np

from motion import Table

OUTER, MIDDLE, INNER = 0, 1, 2
SPEEDS_DEG_S = (2.5, 5.0, 8.0, 12.0, 18.0, 25.0, 32.0, 40.0)
ANGLES_DEG = (36.0, 72.0, 90.0, 135.0, 180.0, 270.0, 360.0, 360.0)
REST_S = 2.0


class Plan:
    """Tables one after the other, with gaps; tables of one power-on share its time and its temperature.

    tables: motion.Table; power_on: index of each table's power-on; targets: per power-on a list of
    (time since power-on [s], temperature that the sensor goes towards [degC]).
    """

    def __init__(self, rng, bench):
        self.rng, self.bench = rng, bench
        self.tables, self.power_on, self.targets = [], [], []

    def new_power_on(self):
        mode, count = self.bench["power_ons"], len(self.tables)
        return not self.tables or mode == "each" or (mode == "two" and count == 3)

    def table(self, pose_deg, target_degC=None):
        """Begins a table; a new target of temperature begins with it."""
        if self.new_power_on():
            start_s = 0.0
            self.targets.append([(0.0, self.first_target_degC())])
        else:
            start_s = self.tables[-1].end_s + self.bench["gap_s"]
        if target_degC is not None and self.bench["thermal"] != "constant":
            self.targets[-1].append((start_s, target_degC))
        beside_deg = self.bench["off_zero_deg"]
        if beside_deg:
            pose_deg = np.asarray(pose_deg) + self.rng.uniform(-beside_deg, beside_deg, 3)
        self.tables.append(Table(start_s, pose_deg, 1.0 / self.bench["gyro_rate_hz"],
                                 self.bench["straight_ramps_deg_s2"]))
        self.power_on.append(len(self.targets) - 1)
        return self.tables[-1]

    def first_target_degC(self):
        return 38.0

    def both_ways(self, table, axis, angle_deg, speed_deg_s):
        for sign in (1.0, -1.0):
            table.turn((axis, sign * angle_deg, speed_deg_s))
            table.rest(REST_S)

    def speeds(self, table, axis, pairs):
        """Turns + and - at each (angle, speed), in random order."""
        table.rest(REST_S)
        for i in self.rng.permutation(len(pairs)):
            self.both_ways(table, axis, *pairs[i])

    def sines(self, table, axis, waves):
        """A drive that only ramps goes to and fro instead."""
        table.rest(REST_S)
        for amplitude_deg, frequency_hz, duration_s in waves:
            if self.bench["straight_ramps_deg_s2"]:
                self.both_ways(table, axis, 9.0 * amplitude_deg, 2.0 * np.pi * frequency_hz * amplitude_deg)
                continue
            edge_s = max(1.0 / frequency_hz, 2.0)
            table.wave(axis, [amplitude_deg], [frequency_hz], [0.0], duration_s, edge_s)
            table.settle()
            table.rest(REST_S)


def full(plan):
    """The full sequence in its ten parts."""
    all_speeds = list(zip(ANGLES_DEG, SPEEDS_DEG_S))
    plan.table((0, 0, 0)).rest(900.0)
    for middle_deg in (0, 90, 180):
        plan.speeds(plan.table((0, middle_deg, 0)), INNER, all_speeds)
    for inner_deg in (90, 0):
        plan.speeds(plan.table((0, 90, inner_deg)), OUTER, [(360, 12), (360, 25), (360, 40)])
    plan.speeds(plan.table((0, 0, 0)), MIDDLE, [(360, 8), (360, 18), (360, 32)])
    cooled = plan.table((0, 0, 0), target_degC=27.0)
    cooled.rest(60.0)
    plan.speeds(cooled, INNER, [(360, 18), (360, 32)])
    cooled.rest(60.0)
    warmed = plan.table((0, 0, 0), target_degC=38.0)
    warmed.rest(60.0)
    plan.speeds(warmed, INNER, [(360, 12), (360, 40)])
    warmed.rest(120.0)
    plan.sines(plan.table((0, 90, 0)), INNER, [(10, 0.2, 15), (5, 0.4, 15), (5, 0.6, 15), (5, 0.8, 15)])


def medium(plan):
    """Four to six tables: a shorter rest, five speeds in two or three poses, the other axes, sines."""
    rng = plan.rng
    plan.table((0, 0, 0)).rest(rng.uniform(240, 420))
    pairs = [(90, 5), (180, 12), (360, 20), (360, 32), (360, rng.uniform(35, 60))]
    poses = [0, 180, 90][:rng.integers(2, 4)]
    for middle_deg in poses:
        plan.speeds(plan.table((0, middle_deg, 0)), INNER, pairs)
    mixed = plan.table((0, 90, 90), target_degC=28.0)
    plan.speeds(mixed, OUTER, [(360, 15), (360, 40)])
    plan.speeds(mixed, MIDDLE, [(90, 10), (180, 30)])
    if rng.uniform() < 0.6:
        plan.sines(plan.table((0, 90, 0)), INNER, [(10, 0.2, 20), (5, 0.5, 20), (4, 0.9, 20)])


def short(plan):
    """One to three tables of two to five minutes: what somebody measures between two meetings."""
    rng = plan.rng
    for i in range(rng.integers(1, 4)):
        middle_deg = (0, 180, 90)[i]
        table = plan.table((0, middle_deg, 0))
        table.rest(rng.uniform(10, 40))
        pairs = [(360, rng.uniform(30, 90)), (180, rng.uniform(10, 30)), (90, rng.uniform(4, 10))]
        plan.speeds(table, INNER, pairs[:rng.integers(2, 4)])
        if rng.uniform() < 0.5:
            plan.sines(table, INNER, [(10, rng.uniform(0.2, 0.5), 15), (5, rng.uniform(0.6, 1.2), 15)])


def single(plan):
    """A single-axis table, its axis vertical: rests, turns at several speeds, a sweep, sines, in one to four tables."""
    rng = plan.rng
    for i in range(rng.integers(1, 5)):
        table = plan.table((0, 0, 0), target_degC=(None, 28.0, 38.0, 30.0)[i])
        table.rest(rng.uniform(60, 300))
        top = rng.uniform(40, 120)
        plan.speeds(table, INNER, [(360, top * part) for part in (0.1, 0.25, 0.5, 0.75, 1.0)])
        if rng.uniform() < 0.7:
            plan.sines(table, INNER, [(15, 0.2, 20), (8, 0.5, 20), (5, 1.0, 20)])


def slow(plan):
    """One to three slow speeds on part of a turn, once or twice, as a table with little room or time is used."""
    rng = plan.rng
    for i in range(rng.integers(1, 3)):
        table = plan.table((0, 0, 0), target_degC=(None, 30.0)[i])
        table.rest(rng.uniform(20, 60))
        angle_deg = rng.choice([90.0, 120.0, 180.0])
        speeds = np.sort(rng.uniform(1.0, 5.0, rng.integers(1, 4)))
        plan.speeds(table, INNER, [(angle_deg, speed) for speed in speeds])


def to_and_fro(plan):
    """One to three tables, each of one axis at one to three speeds, with rests between the turns or without."""
    rng = plan.rng
    for i in range(rng.integers(1, 4)):
        table = plan.table(((0, 0, 0), (0, 90, 0), (0, 0, 0))[i], target_degC=(None, 30.0, None)[i])
        axis = (INNER, OUTER, MIDDLE)[rng.integers(3)] if i else INNER
        table.rest(rng.uniform(20, 90))
        rest_s = rng.choice([0.0, rng.uniform(3, 10)])
        for speed in rng.uniform(4, 60, rng.integers(1, 4)):
            for _ in range(rng.integers(4, 9)):
                for sign in (1.0, -1.0):
                    table.turn((axis, sign * 6.0 * speed, speed))
                    if rest_s:
                        table.rest(rest_s)
            table.rest(rng.uniform(5, 20))


def one_way(plan):
    """One to four tables in other poses, in each of which one axis turns by the same again and again, one way."""
    rng = plan.rng
    speed = rng.uniform(15, 45)
    for pose in ((0, 0, 0), (0, 90, 0), (0, 180, 0), (90, 90, 0))[:rng.integers(1, 5)]:
        table = plan.table(pose)
        table.rest(20.0)
        for _ in range(rng.integers(15, 26)):
            table.turn((INNER, 3.5 * speed, speed))
            table.rest(rng.uniform(3, 5))


def round_speed(plan):
    """One or two tables in which one axis makes equal turns to and fro at one round speed, all timed alike: what an
    encoder's steps make of the readings is the same in each."""
    rng = plan.rng
    speed = rng.choice([10.0, 20.0, 30.0, 40.0, 45.0])
    angle_deg = rng.choice([360.0, 360.0, 180.0, 350.0])
    for i in range(rng.integers(1, 3)):
        table = plan.table(((0, 0, 0), (0, 90, 0))[i])
        table.rest(20.0)
        for _ in range(10):
            for sign in (1.0, -1.0):
                table.turn((INNER, sign * angle_deg, speed))
                table.rest(3.0)


def oblique(plan):
    """Outer and middle axis turn in poses of the inner ones that are no whole part of a turn."""
    rng = plan.rng
    plan.table((0, 0, 0)).rest(rng.uniform(120, 400))
    for _ in range(rng.integers(2, 4)):
        plan.speeds(plan.table((0, rng.uniform(0, 180), 0)), INNER, [(180, 12), (360, 25), (360, 40)])
    for _ in range(rng.integers(3, 8)):
        plan.speeds(plan.table((0, rng.uniform(60, 120), rng.uniform(0, 360))), OUTER, [(360, 15), (360, 32)])
    for _ in range(rng.integers(2, 5)):
        plan.speeds(plan.table((0, 0, rng.uniform(0, 360))), MIDDLE, [(180, 10), (360, 24)])


def hand(plan):
    """A hand: rests, and smooth random motion about all axes, in one to three tables."""
    rng = plan.rng
    for _ in range(rng.integers(1, 4)):
        table = plan.table((rng.uniform(-90, 90), rng.uniform(-40, 40), rng.uniform(-90, 90)))
        table.rest(rng.uniform(10, 30))
        for _ in range(rng.integers(2, 5)):
            duration_s = rng.uniform(40, 90)
            for axis, reach_deg in ((OUTER, 90.0), (MIDDLE, 50.0), (INNER, 90.0)):
                frequencies = rng.uniform(0.03, 0.5, 6)
                amplitudes = reach_deg * rng.uniform(0.2, 1.0, 6) / 6.0 / np.sqrt(frequencies / 0.1)
                table.wave(axis, amplitudes, frequencies, rng.uniform(0, 2 * np.pi, 6), duration_s, 4.0)
            table.settle()
            table.rest(rng.uniform(3, 15))


def several(plan):
    """Several axes at once: the full set of speeds about the inner axis, then turns of two and three axes together."""
    rng = plan.rng
    plan.table((0, 0, 0)).rest(300.0)
    for middle_deg in (0, 90, 180):
        plan.speeds(plan.table((0, middle_deg, 0)), INNER, list(zip(ANGLES_DEG[3:], SPEEDS_DEG_S[3:])))
    table = plan.table((0, 30, 0), target_degC=28.0)
    table.rest(30.0)
    for _ in range(rng.integers(6, 12)):
        signs = rng.choice([-1.0, 1.0], 3)
        moves = [(OUTER, signs[0] * 180.0, rng.uniform(10, 30)), (MIDDLE, signs[1] * 60.0, rng.uniform(8, 20)),
                 (INNER, signs[2] * 360.0, rng.uniform(15, 40))]
        table.turn(*[moves[i] for i in rng.permutation(3)[:rng.integers(2, 4)]])
        table.rest(REST_S)


def poses(plan):
    """Rests of one to six minutes in six to twelve poses, a table each."""
    rng = plan.rng
    plan.table((0, 0, 0)).rest(rng.uniform(300, 900))
    for i in range(rng.integers(5, 12)):
        pose_deg = [(0, 180, 0), (0, 90, 0), (0, 90, 90), (0, 90, 180), (0, 90, 270), (0, 0, 0)][i % 6]
        table = plan.table(pose_deg, target_degC=27.0 if i == 6 else None)
        table.rest(rng.uniform(60, 360))


PROGRAMMES = dict(poses=poses, full=full, medium=medium, short=short, single=single, slow=slow,
                  to_and_fro=to_and_fro, one_way=one_way, round_speed=round_speed, oblique=oblique, hand=hand,
                  several=several)


def draw_plan(rng, bench):
    """The plan of motion of one set."""
    plan = Plan(rng, bench)
    PROGRAMMES[bench["programme"]](plan)
    return plan
