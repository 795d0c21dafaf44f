"""A stand whose clocks part: the daemon's trace, that of its record and that of its table name it, and nothing else."""
import json
import unittest

from bench import Bench

DRIFT_PPM = 800
SCENARIO = f"""
include = "{{root}}/config/scenarios/ideal.toml"
[encoder]
clock_drift_rel = {DRIFT_PPM * 1e-6}
"""


def drifts(trace):
    """eps of each channel [ppm]; fails where another effect is named."""
    found = {}
    for channel in trace["channels"]:
        for effect in channel["effects"]:
            if effect["id"] != "angle.clock_drift":
                raise AssertionError(f"{channel['gyro']}: {effect['id']}")
            found[channel["gyro"]] = effect["parameters"][0]["value"]
    return found


class ClockDrift(unittest.TestCase):
    def test_is_one_effect_in_the_daemon_in_the_record_and_in_a_table(self):
        with Bench(scenario=SCENARIO) as bench:
            done = bench.run("run", "rates", "-p", "axes=z", "-p", "rates_deg_s=20,40")
            self.assertEqual(done.returncode, 0, done.stderr)
            record, table = bench.newest_record(), bench.folder / "run.csv"
            by_daemon = drifts(json.loads((record / "trace.json").read_text()))
            by_record = bench.json("trace", record)
            self.assertEqual(bench.run("export", record, "-o", table).returncode, 0)
            by_table = drifts(bench.json("trace", table))
        self.assertTrue(by_daemon)
        self.assertIn("put on the gyro's clock", " ".join(by_record["remarks"]))
        for channel, eps in by_daemon.items():
            self.assertLess(abs(abs(eps) - DRIFT_PPM), 0.02 * DRIFT_PPM)
            self.assertAlmostEqual(drifts(by_record)[channel], eps, delta=1e-3 * DRIFT_PPM)
            self.assertAlmostEqual(by_table[channel], eps, delta=1e-2 * DRIFT_PPM)


if __name__ == "__main__":
    unittest.main()
