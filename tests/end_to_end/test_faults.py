"""Faults of devices, disk and network: an error that names the place, a stand that stops, a record that is kept.

A silent device costs real time (its bus waits for it), so the bus of the gyro does not retry here.
"""
import json
import resource
import unittest

from bench import Bench, have_multicast

SCALE = ["run", "scale", "-p", "turns=20", "-p", "rest_s=1", "-p", "initial_rest_s=5"]
QUICK_BUSES = "[bus.b]\nretries = 0\n"
FAULT_AT_S = 40


def scenario(device, kind, at_s=FAULT_AT_S, amount=0, duration_s=None):
    return (f'include = "{{root}}/config/scenarios/typical.toml"\n'
            f'[[fault]]\nat_s = {at_s}\ndevice = "{device}"\nkind = "{kind}"\namount = {amount}\n'
            + (f"duration_s = {duration_s}\n" if duration_s else ""))


class Faults(unittest.TestCase):
    def run_into(self, text, words, extra=QUICK_BUSES):
        with Bench(scenario=text, extra=extra) as bench:
            done = bench.run(*SCALE)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            record = bench.newest_record()
            run = json.loads((record / "run.json").read_text())
            self.assertEqual(run["outcome"], "fault", run["message"])
            for word in words:
                self.assertIn(word, run["message"])
            self.assertIn(b"_FAULT", (record / "events.lcmlog").read_bytes())
            # What was recorded up to the fault is kept and can be analysed.
            self.assertEqual(bench.run("analyze", record).returncode, 0)
            self.assertEqual(bench.json("status")["state"], "fault")
            refused = bench.run(*SCALE)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn("reset", refused.stdout + refused.stderr)

    def test_a_result_that_cannot_be_is_no_run_that_is_done(self):
        # Nobody declared that the sensor lies on its side: its z axis feels next to nothing.
        text = 'include = "{root}/config/scenarios/typical.toml"\n[site]\nmount_deg = [90, 0, 0]\n'
        with Bench(scenario=text) as bench:
            done = bench.run(*SCALE)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            run = json.loads((bench.newest_record() / "run.json").read_text())
            self.assertEqual(run["outcome"], "error")
            for word in ("this result cannot be: the z axis of the sensor", "followed by the output of y", "mount_x_deg"):
                self.assertIn(word, run["message"])
                self.assertIn(word, done.stdout + done.stderr)
            # It is an analysis like any other for who wants to look, and says the same.
            analysis = bench.run("analyze", "latest", "--json")
            self.assertEqual(analysis.returncode, 1)
            self.assertIn("this result cannot be", analysis.stderr)
            self.assertIn("this result cannot be", json.loads(analysis.stdout)["remarks"][0])
            # No fault: with the mounting declared the same part is fine.
            self.assertEqual(bench.json("status")["state"], "idle")
        with Bench(scenario=text, extra="[geometry]\nmount_x_deg = 90\n") as bench:
            self.assertEqual(bench.run("run", "rates", "-p", "rates_deg_s=20", "-p", "angle_deg=90").returncode, 0)

    def test_a_gyro_that_falls_silent(self):
        # While its bus waits, bench time stands still, and with it the answers of the drives' bus: that must be
        # the more patient one.
        self.run_into(scenario("gyro", "silent"), ["gyro", "unit 21"],
                      extra=QUICK_BUSES + "[bus.a]\nresponse_timeout_s = 0.5\n")

    def test_a_reference_that_falls_silent_while_the_drives_still_answer(self):
        self.run_into(scenario("inner.encoder", "silent"), ["inner", "unit 13"],
                      extra="[bus.a]\nretries = 1\n")

    def test_lost_steps_of_a_drive(self):
        self.run_into(scenario("inner.drive", "lost_steps", amount=20000), ["axis.inner", "lost steps"])

    def test_an_alarm_of_a_drive(self):
        self.run_into(scenario("inner.drive", "alarm", amount=3), ["axis.inner", "alarm"])


class SilentForAWhile(unittest.TestCase):
    """The run goes on from the command in which the device fell silent, and gives what it would have given."""

    @classmethod
    def setUpClass(cls):
        with Bench(scenario='include = "{root}/config/scenarios/typical.toml"\n') as bench:
            assert bench.run(*SCALE).returncode == 0
            cls.whole = json.loads((bench.newest_record() / "result.json").read_text())["scale"][0]

    def check(self, device, extra, most_left_out=0):
        with Bench(scenario=scenario(device, "silent", duration_s=6), extra=extra) as bench:
            done = bench.run(*SCALE)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            record = bench.newest_record()
            run = json.loads((record / "run.json").read_text())
            self.assertEqual(run["outcome"], "done", run["message"])
            said = [one["text"] for one in run["said"] if one["text"].startswith("suspended: ")]
            self.assertEqual(len(said), 1, run["said"])
            self.assertIn("is back after", said[0])
            self.assertIn("the run was suspended once, for ", run["message"])
            if have_multicast():  # told at once, with what to do
                self.assertIn("to end it now: gyrobench abort", " ".join(done.stdout.split()))
            result = json.loads((record / "result.json").read_text())["scale"][0]
            self.assertIn(self.whole["turns"] - result["turns"], range(most_left_out + 1))
            self.assertLess(abs(result["alpha"] - self.whole["alpha"]), 4 * self.whole["alpha_std_error"])
            # What comes out of the record is what came out live.
            analysis = bench.json("analyze", record)
            self.assertEqual(analysis["scale"][0]["alpha"], result["alpha"])
            self.assertEqual(bench.status()["state"], "idle")

    def test_a_gyro(self):
        # Where the gap of samples reaches into the stop that a turn begins from, that turn is not fitted.
        self.check("gyro", QUICK_BUSES + "[bus.a]\nresponse_timeout_s = 0.5\n", most_left_out=1)

    def test_a_reference(self):
        self.check("inner.encoder", "[bus.a]\nretries = 1\n")

    def test_a_drive(self):
        self.check("inner.drive", "[bus.a]\nretries = 1\n")


class AtStart(unittest.TestCase):
    def check_refused(self, text, words):
        with Bench(scenario=text, extra=QUICK_BUSES) as bench:
            done = bench.run(*SCALE)
            self.assertEqual(done.returncode, 1)
            for word in words:
                self.assertIn(word, done.stdout + done.stderr)
            self.assertFalse(bench.records.exists() and list(bench.records.iterdir()))

    def test_a_device_of_the_wrong_identity_is_named_with_what_was_expected(self):
        self.check_refused(scenario("gyro", "wrong_identity", at_s=0), ["gyro", "expected"])

    def test_a_missing_encoder_is_named_with_its_unit(self):
        self.check_refused(scenario("inner.encoder", "silent", at_s=0), ["encoder.inner", "unit 13"])


class Disk(unittest.TestCase):
    def test_a_full_disk_stops_the_run_in_order_and_keeps_what_was_recorded(self):
        kilobytes = 300
        limit = (kilobytes * 1024, kilobytes * 1024)
        with Bench(before_start=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit)) as bench:
            done = bench.run(*SCALE)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            record = bench.newest_record()
            run = json.loads((record / "run.json").read_text())
            self.assertEqual(run["outcome"], "fault")
            self.assertIn("record", run["message"])
            self.assertEqual(bench.run("analyze", record).returncode, 0)


class NoRoute(unittest.TestCase):
    def test_without_multicast_the_run_is_recorded_and_the_mend_is_named(self):
        with Bench(isolate_network=True) as bench:
            if bench.isolated:
                self.assertIn("ip route add", bench.daemon_log())
            done = bench.run("run", "scale", "-p", "turns=1", "-p", "initial_rest_s=2")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertTrue((bench.newest_record() / "result.json").exists())

    def test_where_lcm_is_required_the_daemon_does_not_start(self):
        bench = Bench(isolate_network=True, extra_lcm="required = true\n", start=False)
        if not bench.isolated:
            self.skipTest("cannot make a network namespace here")
        with bench, self.assertRaisesRegex(RuntimeError, "ip route add"):
            bench.start()


if __name__ == "__main__":
    unittest.main()
