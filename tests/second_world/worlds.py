"""One set: bench, sensor, motion and hidden effects from one seed; its tables, and the truth apart from them."""
import itertools
import os
import zlib

import numpy as np

import bound
import catalogue
import classes
import defects
import ideal
import programmes
import scene as scenes
import simulate
from geometry import AXES, CHANNELS
from tables import Column, write_table

BEYOND_LARGEST = 3.0  # an effect stronger than so many times the largest known size is not hidden
WALK_MATTERS_BELOW = 30.0  # standard deviations; a warm-up in a short run is hidden up to there


class World:
    """A set before it is written. kind: single, pair, silent, unknown; level: sigmas of the bound.

    among: ids that the hidden effect is chosen from; a bench that can show none of them hides nothing.
    judged: whether the truth says what the bound permits and what an ideal tracer finds, which takes most of the time.
    """

    def __init__(self, name, kind, level, seed, overrides=None, among=(), judged=True):
        self.name, self.kind, self.level, self.seed, self.among = name, kind, level, seed, among
        self.judged = judged
        self.rng = np.random.default_rng([seed, zlib.crc32(f"{name}:{kind}:{level:g}".encode())])
        self.bench = classes.draw_bench(name, self.rng, overrides)
        self.bench["latitude_deg"] = round(float(self.rng.uniform(-65, 65)), 3)
        self.bench["heading_deg"] = round(float(self.rng.uniform(0, 360)), 1)
        self.sensor = simulate.Sensor(self.rng, self.bench)
        self.scene = scenes.Scene(self.rng, self.bench, programmes.draw_plan(self.rng, self.bench))
        self.channel = self._draw_channel()
        self.candidates = catalogue.draw_candidates(self.rng, self.scene, self.channel)
        if kind == "unknown":
            self.candidates += catalogue.unknown_candidates(self.rng, self.scene, self.channel)
        if self.bench["stamped_late"]:  # the bench has one already
            self.candidates = [c for c in self.candidates if c.effect != "angle.latency"]
        self.bound = bound.Bound(self.scene, self.channel, self.sensor.noise(self.bench), self.candidates)
        self.asked = None
        self.hidden, self.truth = self._hide()

    def _draw_channel(self):
        """The channel whose effect is hidden: z mostly, another where it turns enough."""
        if self.bench["gyro_axes"] == "z" or self.bench["reference"] == "single":
            return 2
        travel = [np.abs(w).sum() / self.bench["gyro_rate_hz"] for w in self.scene.w_deg_s]
        others = [c for c in (0, 1) if travel[c] > 1500.0]
        return int(self.rng.choice(others)) if others and self.rng.uniform() < 0.2 else 2

    # What is hidden.
    def _hide(self):
        wanted = {"silent": 0, "single": 1, "unknown": 1, "pair": 2}[self.kind]
        feasible = self._feasible(self.kind == "unknown")
        chosen = self._choose(feasible, wanted)
        hidden = [simulate.Hidden(self.candidates[i], theta, self.channel) for i, theta in chosen]
        effects = [self._effect_truth(i, theta, [j for j, _ in chosen if j != i]) for i, theta in chosen]
        truth = dict(bench_class=self.name, kind=self.kind, level=self.level, seed=self.seed,
                     channel=CHANNELS[self.channel], effects=effects, wanted=wanted,
                     bench={k: v for k, v in self.bench.items()}, noise=self.sensor.noise(self.bench),
                     m=self.sensor.m.tolist(), b=[b.tolist() for b in self.sensor.b],
                     permitted_alone=None, permitted_among=None, kept_by_walk=None, copies=[],
                     cannot_show=self._cannot_show(),
                     tolerated=classes.tolerated(self.bench), ideal=None, ideal_named=[])
        if self.kind == "single" and chosen:
            self.bound.permitted(self.rng, chosen[0])  # takes its draws: the sets stay as they were
            if self.judged:
                self._ask_the_bound(chosen[0], truth)
        if self.kind == "unknown" and chosen:
            truth["copies"] = self.bound.copies(*chosen[0])
        return hidden, truth

    def _ask_the_bound(self, chosen, truth):
        """Writes into the truth how often one effect of this size can be found; draws of its own."""
        self.asked = self._beside_rivals(chosen)
        permitted = self.asked.permitted(np.random.default_rng([self.seed, 2]), chosen)
        truth["permitted_alone"], truth["permitted_among"] = permitted
        if self.level <= WALK_MATTERS_BELOW:
            truth["kept_by_walk"] = self.bound.kept_by_an_unknown_walk(
                np.random.default_rng([self.seed, 1]), self.scene, self.channel, truth["noise"], chosen)

    def _earth_may_pass_for(self, chosen):
        """What depends on gravity, where the tables do not say where they were measured."""
        return not self.bench["site"] and self.candidates[chosen[0]].effect.startswith("bias.g_")

    def _beside_rivals(self, chosen):
        """The bound with all rivals that a tracer has to rule out."""
        rivals = catalogue.between(self.scene, self.channel)
        if self._earth_may_pass_for(chosen):
            rivals.append(catalogue.Candidate(catalogue.EARTH))
        return bound.Bound(self.scene, self.channel, self.sensor.noise(self.bench), [*self.candidates, *rivals])

    def _feasible(self, unknown):
        """First candidates of each id that can show `level` sigmas within the sizes that parts have."""
        found, seen = [], set()
        for i, candidate in enumerate(self.candidates):
            if candidate.effect in seen or unknown != candidate.effect.startswith("unknown."):
                continue
            seen.add(candidate.effect)
            if self.among and candidate.effect not in self.among:
                continue
            direction = catalogue.draw_direction(self.rng, candidate.effect, len(self.bound.columns[i]))
            amplitude = self.level * self.bound.sigma(i, direction)
            if amplitude <= BEYOND_LARGEST * catalogue.largest(self.scene, self.channel, candidate):
                found.append((i, amplitude * direction))
        return found

    def _choose(self, feasible, wanted):
        """Draws what is hidden; of two effects each must stay visible beside the other."""
        order = [feasible[i] for i in self.rng.permutation(len(feasible))]
        if wanted < 2:
            return [self._refined(i, theta) for i, theta in order[:wanted]]
        for first, second in itertools.combinations(order, 2):
            if self._apart(first, second) and self._apart(second, first):
                return [first, second]
        return []

    def _apart(self, one, other):
        """Whether an effect keeps seven tenths of its significance when the other is free as well."""
        (i, theta), size = one, np.linalg.norm(one[1])
        covariance = self.bound.covariance(i, [other[0]], [])
        left = size / np.sqrt((theta / size) @ covariance @ (theta / size))
        return left > 0.7 * self.level

    def _refined(self, i, theta):
        """The lag is not linear: its column is taken again at the size that it has."""
        candidate = self.candidates[i]
        if candidate.effect != "bandwidth.first_order":
            return i, theta
        for _ in range(2):
            candidate.nonlinear["tau_s"] = float(theta[0])
            self.bound = bound.Bound(self.scene, self.channel, self.sensor.noise(self.bench), self.candidates)
            theta = np.array([self.level * self.bound.sigma(i, np.ones(1))])
        return i, theta

    def _effect_truth(self, i, theta, others):
        """What is true of one effect, with the bound of its parameters and of its amplitude |theta|."""
        candidate = self.candidates[i]
        slopes = catalogue.slopes(self.scene, self.channel, candidate, theta)
        covariance = self.bound.covariance(i, others, slopes)
        amplitude = float(np.linalg.norm(theta))
        along = theta / amplitude
        seen = self.bound.kept[self.bound.columns[i]] > 1e-7
        return dict(id=candidate.effect, axis=None if candidate.axis is None else AXES[candidate.axis],
                    nonlinear=dict(candidate.nonlinear), values=theta.tolist(),
                    std_errors=[float(s) if seen else None for s, seen in zip(np.sqrt(np.diag(covariance)), seen)],
                    amplitude=amplitude,
                    amplitude_std_error=float(np.sqrt(along @ covariance @ along)))

    def _cannot_show(self):
        """Ids that stay below 5 sigma at the largest known size."""
        best = {}
        for i, c in enumerate(self.candidates):
            direction = np.ones(len(self.bound.columns[i])) / np.sqrt(len(self.bound.columns[i]))
            ratio = catalogue.largest(self.scene, self.channel, c) / self.bound.sigma(i, direction)
            best[c.effect] = max(best.get(c.effect, 0.0), ratio)
        return sorted(effect for effect, ratio in best.items() if ratio < 5.0)

    # What is written.
    def write(self, folder):
        """Writes the tables; returns their paths."""
        rng, scene, bench = self.rng, self.scene, self.bench
        out = simulate.gyro_output(rng, scene, self.sensor, self.hidden)
        gyro = simulate.quantised(bench, self.sensor, out)
        if bench["reference"] == "quaternion":
            reads = simulate.reference_quaternions(rng, scene, self.hidden)
        else:
            reads = simulate.reference_angles(rng, scene, self.hidden)
        self._ask_the_ideal(gyro, reads)
        common = self._common_columns(rng)
        paths = []
        for i, (part, read_part) in enumerate(zip(scene.parts(), scene.reading_parts())):
            columns = self._table_columns(part, read_part, gyro, reads, common)
            if bench["defects"]:
                columns = defects.damaged(rng, columns)
            if bench["cells_missing"]:
                columns = defects.with_missing_cells(rng, columns, bench["cells_missing"])
            if bench["logged_late_s"]:
                columns = defects.stamped_late(rng, columns, bench["logged_late_s"], scene.most_late_s)
            if bench["packets_s"]:
                columns = defects.in_packets(rng, columns, bench["packets_s"] * (1.0 + bench["packets_off"]),
                                             bench["stamp_decimals"])
            paths.append(os.path.join(folder, f"run_{i + 1:02d}.csv"))
            write_table(paths[-1], self._keys(i), columns)
        return paths

    def _ask_the_ideal(self, gyro, reads):
        """Writes into the truth what an ideal tracer says of one effect in these data, before a logger damages them."""
        if self.asked is not None and self.truth["permitted_alone"] is not None:
            residual = ideal.residual_deg(self.scene, self.channel, gyro, reads)
            named = self.asked.named(residual)
            self.truth["ideal"] = ideal.word(named, self.truth["effects"][0]["id"])
            self.truth["ideal_named"] = named
        self.bound.given = self.asked = None  # hundreds of megabytes, of no more use

    def _keys(self, i):
        bench, plan = self.bench, self.scene.plan
        keys = {"sensor": "G-%04d" % (self.seed % 9973)}
        if bench["nominal_key"] and bench["output"] in ("lsb", "unsigned"):
            keys["gyro_lsb_per_deg_s"] = f"{bench['lsb_per_deg_s']:g}"
        if bench["output"] == "unsigned" and bench["unsigned_key"]:
            keys["gyro_lsb_zero"] = 32768
        if bench["gear_key"] and bench["reference"] != "quaternion":
            keys["gear_ratio"] = 40
        if bench["site"]:
            keys["site_latitude_deg"], keys["site_heading_deg"] = bench["latitude_deg"], bench["heading_deg"]
        if bench["power_ons"] != "each":
            keys["power_on"] = plan.power_on[i] + 1
        return keys

    def _common_columns(self, rng):
        """Thermometer, accelerometer and covariates at the gyro's times: (name, values, decimals)."""
        scene, bench = self.scene, self.bench
        found = []
        if bench["thermometer"]:
            shown = scene.shown_degC + bench["temp_noise_degC"] * rng.standard_normal(scene.t_s.size)
            step = bench["temp_resolution_degC"]
            found.append(("temp_degC", np.rint(shown / step) * step, 3))
        if bench["accelerometer"] != "absent":
            bad = bench["accelerometer"] == "uncalibrated"
            scale = 1.0 + (0.03 if bad else 0.0) * rng.uniform(-1, 1, 3)
            offset = (0.05 if bad else 0.002) * rng.uniform(-1, 1, 3)
            for axis in range(3):
                noise = 0.005 * rng.standard_normal(scene.t_s.size)
                found.append((f"accel_{CHANNELS[axis]}_g", scale[axis] * scene.g[axis] + offset[axis] + noise, 4))
        return found + [(name, values, 4) for name, values in scene.covariates.items()]

    def _table_columns(self, part, read_part, gyro, reads, common):
        """Rows of one table: gyro samples and readings merged by time."""
        scene, bench = self.scene, self.bench
        unit = {"lsb": "lsb", "unsigned": "lsb"}.get(bench["output"], bench["output"])
        decimals = {"lsb": 0, "deg_s": 2, "rad_s": 5}[unit]
        t_s, t_read_s = scene.t_s[part], scene.t_read_s[read_part] - scene.stamped_late_s
        rows = np.union1d(t_s, t_read_s) if bench["own_clock"] else t_s
        at_gyro, at_read = np.searchsorted(rows, t_s), np.searchsorted(rows, t_read_s - 1e-7)

        def spread(values, where):
            if where.size == rows.size:
                return values
            full = np.full(rows.size, np.nan)
            full[where] = values
            return full
        columns = [Column("t_s", rows, 6 if bench["own_clock"] else bench["stamp_decimals"])]
        columns += [Column(f"gyro_{c}_{unit}", spread(gyro["xyz".index(c), part], at_gyro), decimals)
                    for c in bench["gyro_axes"]]
        names, values, digits = self._reference_columns(reads[:, read_part])
        if bench["unfilled"]:
            values = [v if n == "ref_inner_deg" else np.full(v.size, np.nan) for n, v in zip(names, values)]
            if not bench["thermometer"]:
                columns.append(Column("temp_degC", np.full(rows.size, np.nan), 3))
        columns += [Column(n, spread(v, at_read), digits) for n, v in zip(names, values)]
        return columns + [Column(n, spread(v[part], at_gyro), d) for n, v, d in common]

    def _reference_columns(self, reads):
        kind = self.bench["reference"]
        if kind == "none":
            return [], [], 0
        if kind == "stand":
            return [f"ref_{axis}_deg" for axis in AXES], reads, 5
        if kind == "single":
            return ["ref_angle_z_deg"], reads[2:], 5
        return ["ref_qw", "ref_qx", "ref_qy", "ref_qz"], reads, 7
