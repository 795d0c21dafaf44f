"""A calibration keeps its promise: on a run that it never saw, `apply` gives the error that the trace foretold.

The tables are made here, by equations written here; error is the angle's in windows of 10 s, each window's mean removed.
"""
import csv
import json
import math
import os
import pathlib
import random
import subprocess
import tempfile
import unittest

from bench import BIN, ROOT

RATE_HZ = 50
DURATION_S = 900
WINDOW_S = 10
LSB_PER_DEG_S = 131
DATA = ROOT.parent / "shared/datasets"


def gyrobench(*arguments):
    done = subprocess.run([BIN / "gyrobench", *map(str, arguments)], capture_output=True, text=True,
                          env={**os.environ, "NO_COLOR": "1", "GYROBENCH_CONFIG": ""})
    if done.returncode != 0:
        raise RuntimeError(f"gyrobench {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def write_run(path, seed):
    """Turns both ways at five speeds. The gyro: 1.2 % of scale, an offset that follows the supply, another
    gain for each sign. The bench: an encoder off its centre by 0.05 deg, which is no error of the gyro."""
    rng = random.Random(seed)
    dt = 1 / RATE_HZ
    angle, last_rate, turn, speed = 0.0, 0.0, -1, 0.0
    with open(path, "w") as table:
        table.write(f"# gyro_lsb_per_deg_s = {LSB_PER_DEG_S}\n# sensor = S1\n"
                    "t_s,gyro_z_lsb,ref_angle_z_deg,supply_v\n")
        for i in range(DURATION_S * RATE_HZ):
            t = i * dt
            if int(t / 8) != turn:
                turn = int(t / 8)
                speed = rng.choice([3, 8, 15, 25, 40]) * rng.choice([-1, 1])
            rate = 0.0 if t % 8 < 2 else speed
            angle += 0.5 * (rate + last_rate) * dt
            last_rate = rate
            supply = 3.3 + 0.15 * math.sin(t / 21 + seed)
            output = 1.012 * rate + 0.4 + 0.8 * (supply - 3.3) + 0.002 * abs(rate)
            xi = LSB_PER_DEG_S * output + rng.gauss(0, 0.0035 * math.sqrt(RATE_HZ) * LSB_PER_DEG_S)
            reference = angle + 0.05 * math.sin(math.radians(angle)) + rng.gauss(0, 0.003)
            table.write(f"{t:.3f},{round(xi)},{reference:.5f},{supply:.4f}\n")


def window_error_deg(path):
    """Root mean square of (integral of the rate - reference) in windows, each window's mean removed."""
    with open(path) as lines:
        rows = [(float(r["t_s"]), float(r["gyro_z_deg_s"]), float(r["ref_angle_z_deg"]))
                for r in csv.DictReader(line for line in lines if not line.startswith("#"))]
    difference, integral, squares, count, window = [], 0.0, 0.0, 0, []
    for (t0, w0, _), (t, w, reference) in zip(rows, rows[1:]):
        integral += 0.5 * (w0 + w) * (t - t0)
        window.append(integral - reference)
        if len(window) == WINDOW_S * RATE_HZ:
            mean = sum(window) / len(window)
            squares += sum((d - mean) ** 2 for d in window)
            count += len(window)
            window = []
    return math.sqrt(squares / count)


class Promise(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def calibrate_and_apply(self):
        write_run(self.path / "seen.csv", 1)
        write_run(self.path / "unseen.csv", 2)
        trace = json.loads(gyrobench("trace", self.path / "seen.csv", "--json",
                                     "--calibration", self.path / "cal.json"))
        gyrobench("apply", self.path / "cal.json", self.path / "unseen.csv", "-o", self.path / "corrected.csv")
        return trace["channels"][0], json.loads((self.path / "cal.json").read_text())

    def test_applied_to_a_run_that_it_never_saw_it_gives_the_error_that_was_foretold(self):
        channel, calibration = self.calibrate_and_apply()
        ids = {effect["id"] for effect in channel["effects"]}
        self.assertIn("bias.of(supply_v)", ids)
        self.assertIn("angle.eccentricity_1", ids)
        terms = {term["id"]: term for term in calibration["channels"][0]["terms"]}
        self.assertFalse(terms["angle.eccentricity_1"]["applied"])
        # What the reference does wrong stays in the comparison with it: it is added to what was foretold.
        promised = math.hypot(channel["heldout_angle_rms_deg"]["after"], 0.05 / math.sqrt(2))
        self.assertLess(window_error_deg(self.path / "corrected.csv"), 1.15 * promised)
        self.assertLess(channel["heldout_angle_rms_deg"]["after"], 0.5 * channel["heldout_angle_rms_deg"]["before"])

    def test_the_same_data_and_seed_give_the_same_calibration_but_for_its_date(self):
        write_run(self.path / "seen.csv", 1)
        made = []
        for name in ("a.json", "b.json"):
            gyrobench("trace", self.path / "seen.csv", "-q", "--calibration", self.path / name)
            made.append(json.loads((self.path / name).read_text()))
            del made[-1]["created"]
        self.assertEqual(made[0], made[1])


if __name__ == "__main__":
    unittest.main()
