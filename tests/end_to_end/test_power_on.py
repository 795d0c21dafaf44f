"""Runs of one power-on: one name, times that count from it, one zero-rate offset."""
import json
import shutil
import unittest

from bench import Bench

SHORT_SCALE = ["run", "scale", "-p", "turns=4", "-p", "rest_s=1", "-p", "initial_rest_s=5"]
REBOOT_AT_S = 50  # within the second run
REBOOT = ('include = "{root}/config/scenarios/typical.toml"\n'
          f'[[fault]]\nat_s = {REBOOT_AT_S}\ndevice = "gyro"\nkind = "reboot"\n')


def run_json(record):
    return json.loads((record / "run.json").read_text())


def power_on_of(record):
    return run_json(record)["measurement"]["power_on"]


def age_s(run):
    """Time from power-on to the begin of the run."""
    return (run["start_utime"] - run["measurement"]["power_on_utime"]) * 1e-6


def table_of(bench, record):
    """Comment lines and times of the exported table."""
    table = bench.folder / f"{record.name}.csv"
    assert bench.run("export", record, "-o", table).returncode == 0
    lines = table.read_text().splitlines()
    times_s = [float(line.split(",")[0]) for line in lines if line[0] not in "#t"]
    return [line for line in lines if line.startswith("#")], times_s


class PowerOn(unittest.TestCase):
    def records_of_runs(self, bench, count):
        for _ in range(count):
            done = bench.run(*SHORT_SCALE)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return sorted(bench.records.iterdir(), key=lambda record: run_json(record)["start_utime"])

    def offsets(self, bench, *inputs):
        """Names of the zero-rate offsets of each channel that was traced."""
        channels = bench.json("trace", *inputs)["channels"]
        self.assertEqual(len(channels), 3)
        return [sorted(p["name"] for p in channel["baseline"]["parameters"]
                        if p["name"].startswith("zero_rate_offset"))
                for channel in channels if channel["baseline"]["parameters"]]

    def test_two_runs_of_one_power_on_share_one_zero_rate_offset(self):
        with Bench() as bench:
            records = self.records_of_runs(bench, 2)
            runs = [run_json(record) for record in records]
            name = power_on_of(records[0])
            self.assertIn("sensor", name)
            self.assertEqual(power_on_of(records[1]), name)
            self.assertEqual(runs[0]["measurement"]["power_on_utime"], runs[1]["measurement"]["power_on_utime"])

            tables = [table_of(bench, record) for record in records]
            for run, (head, times_s) in zip(runs, tables):
                self.assertIn(f"# power_on = {name}", head)
                self.assertAlmostEqual(times_s[0], age_s(run), delta=0.1)
            self.assertGreater(age_s(runs[0]), 15)
            self.assertLess(tables[0][1][-1], tables[1][1][0])

            # In whatever order they are given; their tables are no other measurements.
            csv = [bench.folder / f"{record.name}.csv" for record in records]
            for inputs in (records, records[::-1], csv):
                self.assertIn(["zero_rate_offset"], self.offsets(bench, *inputs))
                self.assertEqual(len(set(map(tuple, self.offsets(bench, *inputs)))), 1)

            # Records from before the daemon said it: each counts from its begin, and for itself.
            old = []
            for record in records:
                old.append(bench.folder / f"old-{record.name}")
                shutil.copytree(record, old[-1])
                run = run_json(record)
                run["measurement"]["power_on"] = ""
                del run["measurement"]["power_on_utime"]
                (old[-1] / "run.json").write_text(json.dumps(run))
                head, times_s = table_of(bench, old[-1])
                self.assertFalse([line for line in head if "power_on" in line])
                self.assertLess(times_s[0], 0.1)
            self.assertIn(["zero_rate_offset_run_1", "zero_rate_offset_run_2"], self.offsets(bench, *old))

    def test_a_restart_of_the_unit_ends_a_power_on(self):
        with Bench(scenario=REBOOT) as bench:
            before, within, after = self.records_of_runs(bench, 3)
            names = [power_on_of(record) for record in (before, within, after)]
            self.assertTrue(names[0] and names[2])
            self.assertNotEqual(names[0], names[2])
            self.assertGreater(run_json(after)["measurement"]["power_on_utime"],
                               run_json(before)["start_utime"])
            # Which of the two it was of cannot be said of the run that has both.
            self.assertEqual(names[1], "")
            defects = bench.json("trace", within)["inputs"][0]["defects"]
            self.assertIn("unit_restarted", [defect["kind"] for defect in defects])
            self.assertFalse([line for line in table_of(bench, within)[0] if "power_on" in line])
            # It is said, and the unit's clock is as well known as without: not compared across the start.
            self.assertIn("started anew within the run (once)", run_json(within)["message"])
            self.assertIn("started anew within the measurement", json.dumps(bench.json("trace", within)["remarks"]))
            results = [json.loads((record / "result.json").read_text()) for record in (before, within)]
            self.assertIn("started anew within the measurement", json.dumps(results[1]["remarks"]))
            clean, restarted = [result["scale"][0]["alpha_std_error"] for result in results]
            self.assertLess(restarted, 3 * clean)
            self.assertIn(["zero_rate_offset_run_1", "zero_rate_offset_run_2"],
                          self.offsets(bench, before, after))


if __name__ == "__main__":
    unittest.main()
