"""Laws of what an ideal tracer has to ask for, and of what it says of written data. Needs numpy; without it nothing runs."""
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
import ideal  # noqa: E402
import places  # noqa: E402
import simulate  # noqa: E402
import worlds  # noqa: E402


def written(world):
    """Samples and readings as they would be written."""
    gyro = simulate.quantised(world.bench, world.sensor,
                              simulate.gyro_output(world.rng, world.scene, world.sensor, world.hidden))
    if world.bench["reference"] == "quaternion":
        return gyro, simulate.reference_quaternions(world.rng, world.scene, world.hidden)
    return gyro, simulate.reference_angles(world.rng, world.scene, world.hidden)


def without_baseline(world, column):
    """A whitened column of which the baseline is taken off."""
    free = len(world.bound.given) - len(world.bound.gram)
    white = world.bound.whiten([*world.bound.given[:free], column])
    model, left = white[:, :-1], white[:, -1]
    model = model / np.linalg.norm(model, axis=0)
    return left - model @ np.linalg.lstsq(model, left, rcond=1e-10)[0]


class Places(unittest.TestCase):
    def test_rows_of_scores_pass_as_often_as_so_many_that_have_nothing_in_common(self):
        rng, gain = np.random.default_rng(1), 12.0
        for apart in (0.003, 0.03, 0.3):
            score = rng.standard_normal(60000)
            largest = np.abs(score)
            for _ in range(99):
                score = (1.0 - apart) * score + np.sqrt(1.0 - (1.0 - apart) ** 2) * rng.standard_normal(score.size)
                largest = np.maximum(largest, np.abs(score))
            passed = np.mean(largest ** 2 > gain)
            foretold = (1.0 + 99.0 * places.tests_to_the_next(apart, gain)) * bound.chi_square_tail(gain, 1)
            self.assertAlmostEqual(passed / foretold, 1.0, delta=0.15, msg=str(apart))

    def test_waves_of_any_frequency_pass_as_often_as_is_foretold(self):
        rng, gain = np.random.default_rng(2), 16.0
        t_s = np.arange(0.0, 100.0, 0.25)
        f_hz = np.arange(0.5, 1.5, 0.001)
        waves = np.concatenate([np.sin(2 * np.pi * np.outer(f_hz, t_s)), np.cos(2 * np.pi * np.outer(f_hz, t_s))])
        passed = 0
        for _ in range(10):
            scores = (waves @ rng.standard_normal((t_s.size, 1000))).reshape(2, f_hz.size, 1000)
            passed += np.sum((scores ** 2).sum(axis=0).max(axis=0) / (0.5 * t_s.size) > gain)
        count = np.sqrt(4 * np.pi / 12.0) * 100.0 * 1.0 * np.sqrt(0.5 * gain)  # as places.count has it
        self.assertAlmostEqual(passed / 1e4 / (count * bound.chi_square_tail(gain, 2)), 1.0, delta=0.2)

    def test_steps_at_any_reading_pass_as_often_as_is_foretold(self):
        world = worlds.World("quaternion_hand", "silent", 0.0, 3)
        (count,) = {round(n, 6) for c, n in zip(world.candidates, world.bound.places) if c.effect == "bias.step"}
        scores, draws, gain = [], 4000, 12.0
        noise = np.random.default_rng(4).standard_normal((world.scene.t_read_s.size, draws)).astype(np.float32)
        order = world.bound.whiten.in_order
        for table, (first, reads) in enumerate(zip(world.scene.parts(), world.scene.reading_parts())):
            for t_s in world.scene.t_read_s[reads][4:-4:4]:
                step = catalogue.Candidate("bias.step", table=table, t0_s=float(t_s))
                white = without_baseline(world, catalogue.responses(world.scene, world.channel, step)[0])
                white = order(white[:, None], world.scene.t_read_s.size)[:, 0]
                if np.linalg.norm(white) > 0.0:
                    scores.append(white / np.linalg.norm(white))
        largest = np.zeros(draws)
        for begin in range(0, len(scores), 50):
            part = np.array(scores[begin:begin + 50], dtype=np.float32) @ noise
            largest = np.maximum(largest, (part ** 2).max(axis=0))
        foretold = count * bound.chi_square_tail(gain, 1)
        self.assertAlmostEqual(np.mean(largest > gain) / foretold, 1.0, delta=0.4)


class Ideal(unittest.TestCase):
    def test_without_its_effect_the_residual_of_the_written_data_is_white_noise(self):
        for name, seed in (("fast_reference", 7200003), ("single_axis_table", 7200007), ("quaternion_hand", 7200008),
                           ("short_run", 7200018), ("slow_turns", 7200032)):
            world = worlds.World(name, "silent", 0.0, seed)
            residual = ideal.residual_deg(world.scene, world.channel, *written(world))
            left = without_baseline(world, residual)
            self.assertAlmostEqual(np.sqrt((left ** 2).sum() / residual.size), 1.0, delta=0.03, msg=name)

    def test_it_names_what_stands_out_and_nothing_where_nothing_is_hidden(self):
        for name, seed in (("single_axis_table", 5), ("short_run", 6), ("quaternion_hand", 7), ("three_encoders", 8)):
            strong = worlds.World(name, "single", 100.0, seed)
            with tempfile.TemporaryDirectory() as folder:
                strong.write(folder)
            self.assertIn(strong.truth["ideal"], ("exact", "among"), name)
            silent = worlds.World(name, "silent", 0.0, seed)
            residual = ideal.residual_deg(silent.scene, silent.channel, *written(silent))
            self.assertEqual(silent.bound.named(residual), [], name)


if __name__ == "__main__":
    unittest.main()
