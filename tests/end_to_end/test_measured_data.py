"""A recording of a real gyro, made by others: the program agrees with plain least squares written here.

The data are no part of the project; without them this skips.
"""
import csv
import gzip
import json
import os
import re
import subprocess
import tempfile
import unittest

from bench import BIN, ROOT

DATA = ROOT.parent / "shared/datasets/stepper-encoder-z-slow.csv.gz"


def integrate(path):
    """Times, integral of the z gyro by the trapezoid rule [deg], reference angle [deg]; repeats left out."""
    times, integral, reference = [], [0.0], []
    last_rate = None
    with gzip.open(path, "rt") as lines:
        for row in csv.DictReader(line for line in lines if not line.startswith("#")):
            t, rate = float(row["t_s"]), float(row["gyro_z_deg_s"])
            if times and t <= times[-1]:
                continue
            if times:
                integral.append(integral[-1] + 0.5 * (rate + last_rate) * (t - times[-1]))
            times.append(t)
            reference.append(float(row["ref_angle_z_deg"]))
            last_rate = rate
    return times, integral, reference


def solve(matrix, right):
    """Gaussian elimination with pivots."""
    n = len(right)
    rows = [list(matrix[i]) + [right[i]] for i in range(n)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][k] * x[k] for k in range(i + 1, n))) / rows[i][i]
    return x


def fit_angle(times, integral, reference):
    """integral = offset + scale * reference + bias * time, ordinary least squares."""
    middle = times[len(times) // 2]
    columns = [[1.0] * len(times), reference, [t - middle for t in times]]
    normal = [[sum(a * b for a, b in zip(p, q)) for q in columns] for p in columns]
    right = [sum(a * b for a, b in zip(p, integral)) for p in columns]
    return solve(normal, right)


@unittest.skipUnless(DATA.exists(), "the measured data are not here")
class MeasuredData(unittest.TestCase):
    def test_scale_and_bias_agree_with_plain_least_squares_within_the_stated_errors(self):
        done = subprocess.run([BIN / "gyrobench", "analyze", DATA, "--json"], capture_output=True, text=True,
                              env={**os.environ, "NO_COLOR": "1"}, check=True)
        result = json.loads(done.stdout)
        result = result[0] if isinstance(result, list) else result
        scale = next(s for s in result["scale"] if s["axis"] in ("z", 2))
        _, slope, bias = fit_angle(*integrate(DATA))
        self.assertLess(abs(scale["alpha"] - 1 / slope), 2 * scale["alpha_std_error"])
        self.assertLess(abs(scale["bias"] - bias), 2 * scale["bias_std_error"])
        defects = {d["kind"]: d["count"] for d in result["defects"]}
        self.assertEqual(defects.get("repeated_time"), 26)

    def test_lags_learned_on_a_slow_recording_explain_most_of_a_faster_one(self):
        faster = DATA.with_name("stepper-encoder-z-medium.csv.gz")
        with tempfile.TemporaryDirectory() as folder:
            calibration = os.path.join(folder, "slow.json")
            subprocess.run([BIN / "gyrobench", "trace", DATA, "--calibration", calibration], check=True,
                           stdout=subprocess.DEVNULL)
            done = subprocess.run([ROOT / "tests/benchmarks/transfer_of_lag.py", calibration, faster], check=True,
                                  capture_output=True, text=True)
        without, with_lags = (float(re.search(rf"^{name} it +([0-9.]+) deg", done.stdout, re.M).group(1))
                              for name in ("without", "with"))
        self.assertLess(with_lags, 0.35 * without)

    def test_what_the_first_part_of_a_motion_teaches_holds_in_the_rest(self):
        moved = DATA.with_name("mocap-hand-slow.csv.gz")
        if not moved.exists():
            self.skipTest("the measured data are not here")
        if subprocess.run(["python3", "-c", "import numpy, pandas"], capture_output=True).returncode != 0:
            self.skipTest("numpy and pandas are not here (scripts/setup.sh bench)")
        done = subprocess.run(["python3", ROOT / "tests/benchmarks/window_rates.py", BIN / "gyrobench", moved],
                              check=True, capture_output=True, text=True)
        for before, after in re.findall(r"^[xyzal]+ +([0-9.]+) +([0-9.]+)$", done.stdout, re.M):
            self.assertLess(float(after), 0.75 * float(before))


if __name__ == "__main__":
    unittest.main()
