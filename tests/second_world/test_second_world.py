"""Laws that the second world must obey, whatever is drawn. Needs numpy; without it nothing runs."""
import os
import sys
import tempfile
import unittest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

try:
    import numpy as np
except ImportError:
    print("skipped: this interpreter has no numpy")
    sys.exit(77)

import bound  # noqa: E402
import catalogue  # noqa: E402
import geometry  # noqa: E402
import lag  # noqa: E402
import least_squares  # noqa: E402
import scoring  # noqa: E402
import simulate  # noqa: E402
import tables  # noqa: E402
import thermal  # noqa: E402
import unknown_walk  # noqa: E402
import whitening  # noqa: E402
import worlds  # noqa: E402

QUIET = dict(arw_factor=1e-4, brw_factor=1e-4, reference_noise_deg=1e-9, encoder_bits=40,
             zero_rate_deg_s=0.0, scale_error=0.0, misalignment=0.0, bias_slope=0.0, bias_curvature=0.0,
             bias_cubic=0.0, site=False)


def read_table(path):
    """Header and rows of a table, empty fields as NaN."""
    with open(path, encoding="utf-8") as file:
        lines = [line for line in file.read().splitlines() if not line.startswith("#")]
    rows = [[float(f) if f else np.nan for f in line.split(",")] for line in lines[1:]]
    return lines[0].split(","), np.array(rows)


def unquantised_residual(world):
    """Residual angle of a measurement without counts."""
    gyro = simulate.gyro_output(world.rng, world.scene, world.sensor, world.hidden)
    return least_squares.residual_angle(world, gyro, simulate.reference_angles(world.rng, world.scene, world.hidden))


class Motion(unittest.TestCase):
    def test_rates_integrate_to_the_angles(self):
        world = worlds.World("several_axes", "silent", 0.0, 3)
        table = world.scene.plan.tables[-1]
        t = np.arange(table.start_s, table.end_s, 0.002)
        angles, rates = table.at(t)
        moved = np.cumsum(0.002 * 0.5 * (rates[:, 1:] + rates[:, :-1]), axis=1)
        self.assertLess(np.abs(angles[:, 1:] - angles[:, :1] - moved).max(), 1e-4)

    def test_rate_in_the_sensor_is_the_derivative_of_its_orientation(self):
        t = np.linspace(0.0, 1.0, 20001)
        angles = np.array([30 * t ** 2, 20 + 40 * t, -50 * t])
        rates = np.array([60 * t, 40 + 0 * t, -50 + 0 * t])
        q = geometry.quaternion_of(angles)
        step = geometry.multiply(q[:, :-1] * np.array([[1], [-1], [-1], [-1]]), q[:, 1:])
        middle = geometry.rates_in_sensor(geometry.axis_directions(angles), rates)
        middle = 0.5 * (middle[:, 1:] + middle[:, :-1])
        self.assertLess(np.abs(np.degrees(2.0 * step[1:] / (t[1] - t[0])) - middle).max(), 1e-3)

    def test_gravity_and_the_world_rotate_alike(self):
        angles = np.random.default_rng(1).uniform(-180, 180, (3, 50))
        up = geometry.world_to_sensor(angles, np.array([0.0, 0.0, 1.0]))
        self.assertLess(np.abs(up - geometry.gravity_in_sensor(geometry.axis_directions(angles))).max(), 1e-12)

    def test_without_noise_the_integrated_gyro_is_the_reference(self):
        for name in ("three_encoders", "single_axis_table", "fast_reference", "slow_gyro", "own_clock_reference"):
            world = worlds.World(name, "silent", 0.0, 5, QUIET)
            world.channel = 2
            residual = unquantised_residual(world)
            whole = [np.ptp(residual[part]) for part in world.scene.reading_parts()]
            self.assertLess(max(whole), 3e-3, name)

    def test_trapezoids_err_at_corners_as_much_as_is_said(self):
        squares, variance = 0.0, 0.0
        for seed in range(12):
            world = worlds.World("seldom_logged", "silent", 0.0, seed, dict(QUIET, lsb_per_deg_s=1e7))
            world.channel = 2
            residual = unquantised_residual(world)
            steps = world.scene.integration_variance(2)
            for part, table in zip(world.scene.reading_parts(), world.scene.plan.tables):
                rests = rests_of(table, world.scene.t_read_s[part])
                if len(rests) < 3:
                    continue
                levels = [residual[part][rest].mean() for rest in rests]
                squares += (np.diff(levels) ** 2).sum()
                variance += steps[part][rests[0][-1] + 1:rests[-1][0] + 1].sum()
        self.assertTrue(0.8 < squares / variance < 1.25, squares / variance)

    def test_means_do_not_err_from_rest_to_rest_where_moments_do(self):
        worst, moving = {}, {}
        for sample in ("mean", "moment"):
            world = worlds.World("slow_means", "silent", 0.0, 3, dict(QUIET, sample=sample, lsb_per_deg_s=1e7))
            world.channel = 2
            residual = unquantised_residual(world)
            steps, spans = [], []
            for part, table in zip(world.scene.reading_parts(), world.scene.plan.tables):
                t_s = world.scene.t_read_s[part]
                rests = rests_of(table, t_s)
                steps += list(np.diff([residual[part][rest].mean() for rest in rests]))
                corners = np.array([t for t, _, _ in table.corners()] or [-1e9])
                apart = np.abs(t_s[:, None] - corners).min(axis=1) > 1.6 * table.interval_s
                spans.append(np.ptp(residual[part][apart]))
            worst[sample], moving[sample] = np.abs(steps).max(), max(spans)
        self.assertLess(worst["mean"], 3e-4)
        self.assertGreater(worst["moment"], 10.0 * worst["mean"])
        self.assertLess(moving["mean"], 1e-3)


class Physics(unittest.TestCase):
    def test_play_is_the_same_as_step_by_step(self):
        values = np.cumsum(np.random.default_rng(2).standard_normal(500))
        p, slow = 0.0, []
        for v in values:
            p = max(v - 1.5, min(v + 1.5, p))
            slow.append(p)
        self.assertTrue(np.allclose(thermal.play(values, 1.5, 0.0), slow))

    def test_backlash_is_half_its_width_by_the_sense_of_the_motion(self):
        angle = np.concatenate([np.linspace(0, 10, 500), np.linspace(10, -10, 1000)])
        error = catalogue.backlash(angle, 0.2)
        self.assertAlmostEqual(error[400], 0.1)
        self.assertAlmostEqual(error[1200], -0.1)

    def test_lag_of_a_ramp_is_the_ramp_late_by_tau(self):
        t = np.arange(0.0, 2.0, 0.01)
        y = lag.lagged(lambda s: 30.0 * s[None, :], t, 0.02)[0]
        exact = 30.0 * (t - 0.02 * (1.0 - np.exp(-t / 0.02)))
        self.assertLess(np.abs(y - exact).max(), 1e-9)

    def test_effects_made_by_resampling_are_their_columns_times_their_size(self):
        for effect, theta, extra in (("angle.latency", 1e-3, {}), ("bandwidth.first_order", 2e-3, {"tau_s": 2e-3}),
                                     ("angle.clock_drift", 1e-5, {}), ("angle.backlash", 0.004, {})):
            world = worlds.World("short_run", "silent", 0.0, 9, QUIET)
            axis = 2 if effect == "angle.backlash" else None
            candidate = catalogue.Candidate(effect, axis, **extra)
            world.hidden = [simulate.Hidden(candidate, [theta], world.channel)]
            residual = unquantised_residual(world)
            expected = theta * catalogue.responses(world.scene, world.channel, candidate)[0]
            for part in world.scene.reading_parts():
                left = (residual - expected)[part]
                self.assertLess(left.std(), 0.02 * expected.std() + 4e-4, effect)


class Bounds(unittest.TestCase):
    def test_whitening_is_generalised_least_squares(self):
        rng = np.random.default_rng(4)
        n, arw, brw = 90, 0.0035, 1e-3
        dt = rng.uniform(0.05, 0.2, n)
        starts = np.zeros(n, dtype=np.int8)
        starts[0], starts[40], starts[70] = 2, 1, 2
        dt[40] = 12.0
        variance = rng.uniform(1e-5, 1e-4, n)
        within = rng.uniform(0.0, 1e-5, n) * (rng.uniform(size=n) < 0.2)
        columns = rng.standard_normal((3, n)).cumsum(axis=1)
        whitener = whitening.Whitener(dt, variance, within, starts, arw, brw)
        white = whitener(list(columns), stretch=16)
        covariance = dense_covariance(dt, variance, within, starts, arw, brw)
        free = dense_free(dt, starts)
        inverse = np.linalg.inv(covariance)
        gram = columns @ inverse @ columns.T
        cross = columns @ inverse @ free
        gram -= cross @ np.linalg.solve(free.T @ inverse @ free, cross.T)
        self.assertTrue(np.allclose(white.T @ white, gram, rtol=1e-4))

    def test_estimates_scatter_as_the_bound_and_chi_square_is_one(self):
        errors, chi = [], []
        for seed in range(24):
            world = worlds.World("short_run", "single", 20.0, 100 + seed)
            if not world.hidden or world.channel != 2:
                continue
            residual = least_squares.residual_angle(world, *least_squares.measured(world))
            estimates, sigmas, chi_square = least_squares.fit(world, residual)
            seen = world.bound.kept[world.bound.columns[world.candidates.index(world.hidden[0].candidate)]] > 1e-5
            errors += list(((estimates - world.hidden[0].theta) / sigmas)[seen])
            chi.append(chi_square)
        self.assertGreater(len(chi), 12)
        self.assertLess(abs(np.mean(chi) - 1.0), 0.02)
        rms = np.sqrt(np.mean(np.square(errors)))
        self.assertTrue(0.65 < rms < 1.4, rms)
        self.assertLess(np.abs(errors).max(), 4.0)

    def test_chi_square_is_one_beside_corners_that_nobody_sees(self):
        for name in ("seldom_logged", "slow_means", "means_before"):
            chi = []
            for seed in range(9):
                world = worlds.World(name, "silent", 0.0, 300 + seed, dict(programme="medium"))
                world.channel = 2
                residual = least_squares.residual_angle(world, *least_squares.measured(world))
                chi.append(least_squares.fit(world, residual)[2])
            self.assertLess(abs(np.mean(chi) - 1.0), 0.1, name)

    def test_half_the_noise_doubles_the_sigmas_of_a_candidate(self):
        sigmas = []
        for factor in (1.0, 0.5):
            noise = dict(reference_noise_deg=0.01 * factor, arw_factor=factor, brw_factor=factor, encoder_bits=30,
                         lsb_per_deg_s=1e5)
            world = worlds.World("three_encoders", "silent", 0.0, 2, dict(noise, programme="medium"))
            at = [c.effect for c in world.candidates].index("angle.latency")
            sigmas.append(world.bound.sigma(at, np.ones(1)))
        self.assertAlmostEqual(sigmas[0] / sigmas[1], 2.0, places=4)

    def test_what_is_permitted_grows_from_nothing_to_all(self):
        world = worlds.World("single_axis_table", "silent", 0.0, 6)
        at = [c.effect for c in world.candidates].index("angle.eccentricity_2")
        toward = np.array([0.6, 0.8])
        sigma = world.bound.sigma(at, toward)
        rng = np.random.default_rng(1)
        shares = [world.bound.permitted(rng, (at, level * sigma * toward))[0] for level in (0.0, 5.0, 100.0)]
        self.assertLess(shares[0], 0.02)
        self.assertLess(shares[0], shares[1])
        self.assertGreater(shares[2], 0.98)

    def test_the_earth_passes_for_a_g_sensitivity_that_is_no_larger(self):
        quiet = dict(reference_noise_deg=0.001, arw_factor=0.02, brw_factor=0.01, encoder_bits=30, lsb_per_deg_s=1e6,
                     site=False)
        world = worlds.World("three_encoders", "silent", 0.0, 2, quiet)
        at = [c.effect for c in world.candidates].index("bias.g_linear")
        along = np.eye(3)[world.channel]  # what gravity makes along the axis, the Earth's vertical part makes as well
        rng = np.random.default_rng(3)
        for size_deg_s_per_g, share in ((0.5 * geometry.EARTH_RATE_DEG_S, 0.0), (5.0 * geometry.EARTH_RATE_DEG_S, 1.0)):
            truth = (at, size_deg_s_per_g * along)
            self.assertGreater(world.bound.permitted(rng, truth)[0], 0.95)
            alone, among = world._beside_rivals(truth).permitted(rng, truth)
            self.assertAlmostEqual(alone, share, delta=0.05)
            self.assertGreater(among, 0.95)

    def test_a_walk_of_unknown_size_takes_from_slow_effects_alone(self):
        rng, times_s = np.random.default_rng(4), np.arange(0.0, 1200.0, 0.2)
        starts = np.zeros(times_s.size, dtype=int)
        starts[0] = 2
        none = np.zeros(times_s.size)
        readings = unknown_walk.Readings(np.diff(times_s, prepend=0.0), starts, np.full(times_s.size, 1e-6), none,
                                         0.0035, 1e-4)
        slow = 300.0 * np.exp(-times_s / 300.0)  # integral of an offset that dies away
        fast = np.sin(2.0 * np.pi * times_s / 3.0)
        shares = []
        for column in (slow, fast):
            white = whitening.Whitener(readings.dt_s, readings.variance_deg2, none, starts, 0.0035, 1e-4)([column])
            theta = 7.0 / np.linalg.norm(white)
            known, unknown = unknown_walk.gains(rng, readings, [], [column], np.array([theta]))
            self.assertAlmostEqual(known.mean(), 7.0 ** 2 + 1.0, delta=4.0)
            shares.append(unknown.mean() / known.mean())
        self.assertLess(shares[0], 0.8)
        self.assertGreater(shares[1], 0.9)

    def test_the_drawn_noise_is_white_under_the_noise_that_it_was_drawn_with(self):
        for dt_s, brw in ((0.1, 1e-3), (20.0, 1e-3)):  # the second: the bias walks much within a step
            starts = np.zeros(4000, dtype=int)
            starts[[0, 1500]] = [2, 1]
            steps_s = np.full(4000, dt_s)
            steps_s[1500] = 50.0 * dt_s  # a gap
            within = np.where(np.arange(4000) % 7 == 3, 1e-5, 0.0)
            readings = unknown_walk.Readings(steps_s, starts, np.full(4000, 1e-5), within, 0.0035, brw)
            noise = readings.noise(np.random.default_rng(5), 20)
            whiten = whitening.Whitener(steps_s, readings.variance_deg2, within, starts, 0.0035, brw)
            white = whitening.Whitener.in_order(whiten(list(noise)), 4000)
            for first, last in ((10, 1490), (1510, 3990), (1501, 1510)):
                part = white[first:last]
                self.assertAlmostEqual(part.var(), 1.0, delta=5.0 * np.sqrt(2.0 / part.size))
                self.assertAlmostEqual((part[1:] * part[:-1]).mean(), 0.0, delta=5.0 / np.sqrt(part.size))

    def test_some_readings_are_spread_evenly_and_keep_every_start(self):
        starts = np.zeros(100000, dtype=int)
        starts[[0, 777, 50001]] = [2, 1, 2]
        some = unknown_walk.some_readings(starts)
        self.assertLessEqual(some.size, unknown_walk.MOST_READINGS + 3)
        self.assertTrue({0, 777, 50001} <= set(some))
        self.assertLessEqual(np.diff(some).max(), 7)

    def test_a_set_keeps_its_fast_effects_and_loses_slow_ones_to_an_unknown_walk(self):
        kept = {}
        for wanted in ("bias.warm_up", "scale.quadratic_even"):
            world = worlds.World("short_run", "single", 5.0, 4, among=[wanted])
            self.assertEqual([e["id"] for e in world.truth["effects"]], [wanted])
            kept[wanted] = world.truth["kept_by_walk"]
        self.assertGreater(kept["scale.quadratic_even"], 0.85)
        self.assertLess(kept["bias.warm_up"], 0.6)
        self.assertIsNone(worlds.World("short_run", "single", 100.0, 4).truth["kept_by_walk"])

    def test_what_the_baseline_absorbs_does_not_spoil_what_is_permitted(self):
        world = worlds.World("single_axis_table", "single", 20.0, 7005)  # g-dependent scale is absorbed there
        at = [c.effect for c in world.candidates].index("angle.latency")
        theta = np.array([20.0 * world.bound.sigma(at, np.ones(1))])
        self.assertGreater(world.bound.permitted(np.random.default_rng(1), (at, theta))[1], 0.99)

    def test_a_jump_at_a_temperature_that_is_passed_once_is_a_step_in_time(self):
        warming = worlds.World("fast_reference", "unknown", 20.0, 140069)
        self.assertEqual(warming.truth["effects"][0]["id"], "unknown.bias_jump")
        self.assertIn("bias.step", warming.truth["copies"])
        swaying = worlds.World("own_clock_reference", "unknown", 20.0, 140048)  # flat between two temperatures
        self.assertEqual(swaying.truth["copies"], [])

    def test_nothing_that_depends_on_temperature_is_hidden_where_there_is_one_temperature(self):
        world = worlds.World("unfilled_columns", "unknown", 20.0, 8402022, judged=False)
        self.assertEqual(np.ptp(world.scene.temp_degC), 0.0)
        by_temperature = [c for c in world.candidates if c.effect in ("unknown.bias_jump", "unknown.bias_flat")]
        self.assertEqual(len(by_temperature), 2)
        for candidate in by_temperature:
            self.assertEqual(catalogue.largest(world.scene, world.channel, candidate), 0.0)
            self.assertNotIn(candidate.effect, [effect["id"] for effect in world.truth["effects"]])

    def test_the_chance_is_of_all_channels_and_of_all_that_is_tried(self):
        self.assertAlmostEqual(bound.threshold(1, 1, 0.01), 6.6349, places=3)
        one = bound.chi_square_tail(bound.threshold(1, 1, bound.FALSE_DISCOVERY / 3.0), 1)
        self.assertAlmostEqual(1.0 - (1.0 - one) ** 3, 0.009, places=4)
        self.assertGreater(bound.threshold(60), bound.threshold(1))
        self.assertGreater(bound.threshold(60, 3), bound.threshold(60, 2))

    def test_one_in_twenty_exceeds_the_tabulated_quantiles_of_chi_square(self):
        for freedom, quantile in ((1, 3.8415), (2, 5.9915), (3, 7.8147), (4, 9.4877), (5, 11.0705)):
            self.assertAlmostEqual(bound.chi_square_tail(quantile, freedom), 0.05, places=4)


class Tables(unittest.TestCase):
    def test_text_reads_back_as_the_numbers(self):
        rng = np.random.default_rng(7)
        values = np.concatenate([rng.normal(0, 300, 400), [0.0, -0.004, 0.05, np.nan, 99999.99, -1.0]])
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "t.csv")
            columns = [tables.Column("a", values, 3), tables.Column("b", np.rint(values), 0)]
            tables.write_table(path, {"sensor": "G"}, columns, block=100)
            names, rows = read_table(path)
        self.assertEqual(names, ["a", "b"])
        self.assertTrue(np.allclose(rows[:, 0], values, atol=5.01e-4, equal_nan=True))
        self.assertTrue(np.array_equal(rows[:, 1], np.rint(values), equal_nan=True))

    def test_equal_seeds_give_equal_bytes_and_others_do_not(self):
        texts = [self.text_of("single_axis_table", seed) for seed in (11, 11, 12)]
        self.assertEqual(texts[0], texts[1])
        self.assertNotEqual(texts[0], texts[2])

    def test_a_table_has_no_word_of_the_truth(self):
        known = {"sensor", "gyro_lsb_per_deg_s", "gyro_lsb_zero", "gear_ratio", "site_latitude_deg",
                 "site_heading_deg", "power_on"}
        for name in ("single_axis_table", "short_run", "quaternion_hand", "fast_gyro"):
            for line in self.text_of(name, 8).decode().splitlines():
                if line.startswith("#"):
                    self.assertIn(line[1:].split("=")[0].strip(), known)

    def test_rows_of_a_clock_of_its_own_have_only_the_reading(self):
        with tempfile.TemporaryDirectory() as folder:
            world = worlds.World("own_clock_reference", "silent", 0.0, 2, dict(programme="short"))
            names, rows = read_table(world.write(folder)[0])
        gyro, read = (np.isfinite(rows[:, names.index(n)]) for n in ("gyro_z_lsb", "ref_inner_deg"))
        self.assertTrue((gyro != read).all())
        self.assertGreater(np.diff(rows[:, 0]).min(), 0.0)

    def test_a_set_is_the_same_whether_the_bound_is_asked_or_not(self):
        self.assertEqual(self.text_of("short_run", 12), self.text_of("short_run", 12, judged=True))

    @staticmethod
    def text_of(name, seed, judged=False):
        with tempfile.TemporaryDirectory() as folder:
            text = b""
            for path in worlds.World(name, "single", 20.0, seed, judged=judged).write(folder):
                with open(path, "rb") as file:
                    text += os.path.basename(path).encode() + file.read()
        return text.replace(b"run_01.csv", b"").replace(b"run_02.csv", b"")


class Scoring(unittest.TestCase):
    @staticmethod
    def channel(*effects, unseen=()):
        return dict(effects=[dict(id=e[0], rivals=list(e[1:])) for e in effects],
                    unidentifiable=[dict(id=u) for u in unseen])

    def test_words(self):
        for expected, channel in (("exact", self.channel(("a",))), ("among", self.channel(("b", "a"))),
                                  ("wrong", self.channel(("b",))), ("extra", self.channel(("a",), ("b",))),
                                  ("nothing", self.channel()), ("listed", self.channel(unseen=["a"]))):
            self.assertEqual(scoring.verdict_on(channel, ["a"]), expected)
        self.assertEqual(scoring.verdict_on(self.channel(("a",)), ["a", "b"]), "partial")
        self.assertEqual(scoring.verdict_on(self.channel(("b",), ("a",)), ["a", "b"]), "exact")


def rests_of(table, t_s):
    """Indices of the times in each rest between turns of a table, its first and last tenths of a second left out."""
    angles, _ = table.at(t_s)
    still = np.concatenate([[False], np.abs(np.diff(angles, axis=1)).max(axis=0) < 1e-9])
    cut = np.flatnonzero(np.diff(still.astype(int))) + 1
    return [part[2:-2] for part in np.split(np.arange(t_s.size), cut) if still[part[0]] and part.size > 8]


def dense_covariance(dt, variance, within, starts, arw, brw):
    """Covariance of the readings, step by step, with known starts."""
    n = dt.size
    state = np.zeros((2, 2 * n))  # sensitivity of (angle, bias) to 2 n unit noises
    rows = []
    for i in range(n):
        walk = arw ** 2 * dt[i] + within[i]
        q = np.array([[walk + brw ** 2 * dt[i] ** 3 / 3, brw ** 2 * dt[i] ** 2 / 2],
                      [brw ** 2 * dt[i] ** 2 / 2, brw ** 2 * dt[i]]])
        state = np.array([[1.0, dt[i]], [0.0, 1.0]]) @ state
        state[:, 2 * i:2 * i + 2] += np.linalg.cholesky(q)
        if starts[i]:
            state[0] = 0.0
        if starts[i] == 2:
            state[1] = 0.0
        rows.append(state[0].copy())
    rows = np.array(rows)
    return rows @ rows.T + np.diag(variance)


def dense_free(dt, starts):
    """Columns of the unknown angle of each table and the unknown bias of each power-on."""
    columns, angle, bias = [], None, None
    for i, start in enumerate(starts):
        if start:
            angle = np.zeros(starts.size)
            columns.append(angle)
            lever = 0.0
        else:
            lever += dt[i]
        if start == 2:
            bias = np.zeros(starts.size)
            columns.append(bias)
        angle[i], bias[i] = 1.0, lever
    return np.array(columns).T


if __name__ == "__main__":
    unittest.main()
