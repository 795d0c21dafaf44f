"""Runs that need a hand which is not there, or a fan and a heater that do nothing: an error that says what to do, and a
closed record."""
import json
import unittest

from bench import ROOT, Bench

SHORT_TURNS = ["-p", "angle_deg=30", "-p", "rates_deg_s=20"]
ANSWERED = '[virtual.answers]\nno_change = "end"\n'


def virtual_without_answers(idle_pace):
    """Of a stand file without a simulation: nothing answers in the operator's place."""
    return f'[virtual]\nscenario = "{ROOT}/config/scenarios/typical.toml"\nidle_pace = {idle_pace}\n'


class Operator(unittest.TestCase):
    def check_ended_in_order(self, bench, arguments, words):
        done = bench.run("run", *arguments)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        record = bench.newest_record()
        run = json.loads((record / "run.json").read_text())
        self.assertEqual(run["outcome"], "error", run["message"])
        self.assertIn("end_utime", run)
        for word in words:
            self.assertIn(word, run["message"])
            self.assertIn(word, done.stdout + done.stderr)
        # What was recorded up to the end is whole.
        self.assertTrue((record / "result.json").exists())
        self.assertEqual(bench.run("analyze", record).returncode, 0)
        # No fault: the next run may begin at once.
        self.assertEqual(bench.json("status")["state"], "idle")
        return run

    def test_an_operator_who_never_answers_is_waited_for_and_then_the_run_ends(self):
        with Bench(base="stand.toml", extra=virtual_without_answers(idle_pace=1000)) as bench:
            run = self.check_ended_in_order(
                bench, ["thermal", "-p", "warm_up_s=5", "-p", "patience_s=600", *SHORT_TURNS],
                ["thermal.lua:", "nobody answered 'Switch the fan on", "fan_on", "within 600 s", "run it again"])
            self.assertGreater(run["end_utime"] - run["start_utime"], 600e6)
            self.assertEqual(bench.run("run", "scale", "-p", "turns=1", "-p", "initial_rest_s=2").returncode, 0)

    def test_a_fan_that_does_not_cool_is_said_with_the_reading_and_what_was_expected(self):
        scenario = 'include = "{root}/config/scenarios/typical.toml"\n[room]\nfan_drop_degC = 0\n'
        with Bench(scenario=scenario, extra=ANSWERED) as bench:
            self.check_ended_in_order(
                bench, ["thermal", "-p", "warm_up_s=600", "-p", "cooling_s=60", *SHORT_TURNS],
                ["cooling changed the gyro's own thermometer by", "expected -1 degC", "does the fan run"])

    def test_a_heater_that_does_not_heat_is_said(self):
        scenario = 'include = "{root}/config/scenarios/typical.toml"\n[room]\nheater_rise_degC = 0\n'
        with Bench(scenario=scenario, extra=ANSWERED) as bench:
            self.check_ended_in_order(
                bench, ["thermal", "-p", "warm_up_s=1200", "-p", "cooling_s=0", "-p", "rewarming_s=30", *SHORT_TURNS],
                ["warming changed the gyro's own thermometer by", "expected +1 degC", "is a heater connected"])

    def test_a_stand_that_switches_fan_and_heater_asks_nobody_and_leaves_them_off(self):
        with Bench(base="relays.toml", extra="[virtual.answers]\nno_change = \"end\"\n") as bench:
            done = bench.run("run", "thermal", "-p", "warm_up_s=600", "-p", "cooling_s=120", "-p", "rewarming_s=60",
                             *SHORT_TURNS)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            said = [line["text"] for line in json.loads((bench.newest_record() / "run.json").read_text())["said"]]
            self.assertEqual([text for text in said if "switched" in text],
                             ["fan switched on", "fan switched off", "heater switched on", "heater switched off"])
            self.assertEqual(bench.json("status")["outputs"], {"fan": False, "heater": False})

    def test_a_heater_of_the_stand_that_does_not_heat_is_said_and_switched_off(self):
        scenario = 'include = "{root}/config/scenarios/typical.toml"\n[room]\nheater_rise_degC = 0\nfan_drop_degC = 0\n'
        with Bench(base="relays.toml", scenario=scenario, extra=ANSWERED) as bench:
            self.check_ended_in_order(
                bench, ["thermal", "-p", "warm_up_s=1200", "-p", "cooling_s=0", "-p", "rewarming_s=30", *SHORT_TURNS],
                ["warming changed the gyro's own thermometer by", "expected +1 degC", "is a heater connected"])
            self.assertEqual(bench.json("status")["outputs"], {"fan": False, "heater": False})

    def heater_on(self, bench):
        """A run that has just switched the heater on, in no hurry."""
        done = bench.run("run", "thermal", "-p", "cooling_s=0", "-p", "warm_up_s=0", "-p", "rewarming_s=3600",
                         *SHORT_TURNS, "--detach")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        while not bench.json("status")["outputs"]["heater"]:
            self.assertEqual(bench.json("status")["run"]["outcome"], "")

    def wait_for_the_end(self, bench):
        while bench.json("status")["run"]["outcome"] == "":
            self.assertIsNone(bench.daemon.poll())
        return json.loads((bench.newest_record() / "run.json").read_text())

    def test_an_abort_and_a_stop_leave_no_heater_on(self):
        with Bench(base="relays.toml", extra="[virtual]\npace = 20\n") as bench:
            for command in ("abort", "stop"):
                self.heater_on(bench)
                self.assertEqual(bench.run(command).returncode, 0)
                self.assertEqual(self.wait_for_the_end(bench)["outcome"], "aborted")
                self.assertEqual(bench.json("status")["outputs"], {"fan": False, "heater": False})

    def test_relays_that_fall_silent_end_the_run_and_are_off_when_they_are_back(self):
        scenario = ('include = "{root}/config/scenarios/typical.toml"\n'
                    '[[fault]]\ndevice = "relays"\nkind = "silent"\nat_s = 120\nduration_s = 6\n')
        with Bench(base="relays.toml", scenario=scenario, extra="[virtual]\npace = 20\nidle_pace = 50\n") as bench:
            self.heater_on(bench)
            run = self.wait_for_the_end(bench)
            self.assertEqual(run["outcome"], "fault", run["message"])
            for word in ("relays", "the heater cannot be switched off, disconnect it by hand"):
                self.assertIn(word, run["message"])
            while bench.json("status")["outputs"] != {"fan": False, "heater": False}:
                self.assertIsNone(bench.daemon.poll())

    def test_a_sensor_that_gets_too_hot_ends_the_run_with_everything_off(self):
        with Bench(base="relays.toml", extra="[relays]\nheater_max_degC = 35\n") as bench:
            done = bench.run("run", "thermal", "-p", "warm_up_s=600", "-p", "cooling_s=0", *SHORT_TURNS)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            run = json.loads((bench.newest_record() / "run.json").read_text())
            self.assertEqual(run["outcome"], "fault", run["message"])
            self.assertIn("heater_max_degC = 35", run["message"])
            status = bench.json("status")
            self.assertEqual(status["outputs"], {"fan": False, "heater": False})
            self.assertEqual(status["fault"]["source"], "relays")


if __name__ == "__main__":
    unittest.main()
