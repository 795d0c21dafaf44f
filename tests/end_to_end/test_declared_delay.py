"""What is declared is known: the delay of the gyro's filter, which its device map states, is no effect."""
import json
import unittest

from bench import Bench

# Three axes read in turn, turns about each: what readings at different times make of a motion's begin would be found
# here.
SHORT_RATES = ["rates", "-p", "rates_deg_s=10,20,40", "-p", "angle_deg=90", "-p", "initial_rest_s=20"]
NO_EFFECTS = 'include = "{root}/config/scenarios/full-sequence.toml"\n'
DECLARED_S = 0.0048  # filter 3 in config/devices/gyro-unit.toml
EXCESS = 0.5


class DeclaredDelay(unittest.TestCase):
    def traced(self, bench):
        done = bench.run("run", *SHORT_RATES)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        record = bench.newest_record()
        run = json.loads((record / "run.json").read_text())
        self.assertEqual(run["measurement"]["gyro_delay_s"], DECLARED_S)
        return {channel["gyro"]: channel for channel in json.loads((record / "trace.json").read_text())["channels"]}

    def test_a_part_without_effects_on_a_perfect_stand_has_none_with_the_default_filter(self):
        with Bench(scenario=NO_EFFECTS) as bench:
            channels = self.traced(bench)
            self.assertEqual({axis: channel["verdict"] for axis, channel in channels.items()},
                             {"x": "none", "y": "none", "z": "none"})
            # The same by way of the table, whose head says the delay.
            table = bench.folder / "run.csv"
            self.assertEqual(bench.run("export", "latest", "-o", table).returncode, 0)
            self.assertIn(f"# gyro_delay_s = {DECLARED_S}\n", table.read_text())
            for of_record, of_table in zip(bench.json("analyze", "latest")["scale"],
                                           bench.json("analyze", table)["scale"], strict=True):
                self.assertAlmostEqual(of_table["alpha"] / of_record["alpha"], 1.0, delta=1e-7)

    def test_a_delay_beyond_the_declared_one_is_named_with_the_difference(self):
        with Bench(scenario=NO_EFFECTS + f"[gyro]\nfilter_delay_rel = {EXCESS}\n") as bench:
            for axis, channel in self.traced(bench).items():
                latency = [effect for effect in channel["effects"]
                           if "angle.latency" in [effect["id"], *effect["rivals"]]]
                self.assertEqual(len(latency), 1, (axis, channel["summary"]))
                tau = next(p for p in latency[0]["parameters"] if p["name"] == "tau")
                self.assertAlmostEqual(tau["value"], EXCESS * DECLARED_S, delta=max(4 * tau["std_error"], 1e-4))


if __name__ == "__main__":
    unittest.main()
