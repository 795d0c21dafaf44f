"""`gyrobench devices` on the lines of a virtual stand that is a process of its own."""
import json
import os
import pty
import signal
import subprocess
import unittest

from bench import BIN, DEADLINE_S, ROOT
from outside_stand import OutsideStand, RELAYS

UNITS = "1-3,11-13,21,22,31"


class Devices(unittest.TestCase):
    def scan(self, bench, *arguments, status=0):
        done = bench.run("devices", "--units", UNITS, "--json", *arguments)
        self.assertEqual(done.returncode, status, done.stderr)
        return {line["bus"]: line for line in json.loads(done.stdout)["lines"]}

    def test_what_the_stand_file_has_answers_as_that(self):
        with OutsideStand() as bench:
            found = [(line["bus"], unit["unit"], unit["kind"], unit["expected"])
                     for line in self.scan(bench).values() for unit in line["found"]]
            axes = ("outer", "middle", "inner")
            self.assertEqual(found, [("a", i + 1, "drive", f"axis.{name} drive") for i, name in enumerate(axes)]
                             + [("a", i + 11, "encoder", f"axis.{name} encoder") for i, name in enumerate(axes)]
                             + [("a", RELAYS, "relay unit", "relays"), ("b", 21, "gyro unit", "gyro")])

    def test_one_line_alone_is_asked_where_it_is_named(self):
        with OutsideStand() as bench:
            self.assertEqual(list(self.scan(bench, "--bus", "b")), ["b"])

    def test_swapped_numbers_and_a_missing_device_are_named(self):
        with OutsideStand() as bench:
            wrong = bench.folder / "wrong.toml"
            wrong.write_text(f'include = "{bench.config}"\n[axis.inner.drive]\nunit = 13\n'
                             '[axis.inner.encoder]\nunit = 3\n[gyro]\nunit = 22\n')
            lines = self.scan(bench, "--config", wrong, "--baud", "115200", status=1)
            told = " ".join(lines["a"]["advice"])
            self.assertIn("Unit 3 is to be axis.inner encoder, and answers as drive", told)
            self.assertIn("Unit 13 is to be axis.inner drive, and answers as encoder", told)
            self.assertEqual(lines["b"]["missing"], [{"unit": 22, "device": "gyro"}])
            self.assertIn("unit 21 of bus b, which is not in the stand file, may be it", lines["b"]["advice"][0])
            self.assertEqual([(u["unit"], u["expected"]) for u in lines["b"]["found"]], [(21, "")])

    def test_what_was_not_asked_is_said_at_the_end(self):
        with OutsideStand() as bench:
            some = bench.run("devices", "--units", "1-3", "--bus", "a")
            self.assertIn("The 3 devices of the stand file that were asked answer as expected. Nothing is known of "
                          "axis.outer encoder, axis.middle encoder, axis.inner encoder, relays, gyro.", " ".join(some.stdout.split()))
            told = json.loads(bench.run("devices", "--units", "1-3,11-13", "--bus", "a", "--json").stdout)
            self.assertEqual(told["not_asked"], [{"bus": "a", "unit": RELAYS, "device": "relays"},
                                                 {"bus": "b", "unit": 21, "device": "gyro"}])
            every = bench.run("devices", "--units", UNITS)
            self.assertIn("All 8 devices of the stand file answer as expected.", every.stdout)

    def expecting(self, bench, pulses):
        """A stand file that wants so many pulses a turn of the inner and the outer drive."""
        other = bench.folder / "other.toml"
        drives = "".join(f"[axis.{name}.drive]\npulses_per_turn = {pulses}\n" for name in ("inner", "outer"))
        other.write_text(f'include = "{bench.config}"\n{drives}')
        return other

    def test_drives_are_set_as_the_stand_file_says(self):
        with OutsideStand() as bench:
            other = self.expecting(bench, 5000)
            before = self.scan(bench, "--config", other, "--bus", "a", status=1)
            self.assertEqual(sum("set the drive" in advice for advice in before["a"]["advice"]), 2)
            done = bench.run("devices", "--units", UNITS, "--config", other, "--bus", "a", "--write", "--yes", "--json")
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            told = json.loads(done.stdout)
            self.assertEqual(told["written"], [
                {"bus": "a", "unit": unit, "device": f"axis.{name} drive", "parameter": "pulses per turn",
                 "from": 10000, "to": 5000, "saved": True, "error": ""} for unit, name in ((1, "outer"), (3, "inner"))])
            self.assertTrue(told["as_expected"])
            again = bench.run("devices", "--units", UNITS, "--config", other, "--bus", "a", "--write")
            self.assertEqual(again.returncode, 0, again.stderr)
            self.assertIn("Nothing to write: the drives that answered are set as the stand file says.", again.stdout)

    def test_drives_that_hold_each_others_value_are_not_written_without_a_look(self):
        with OutsideStand() as bench:
            outer = bench.folder / "outer.toml"
            outer.write_text(f'include = "{bench.config}"\n[axis.outer.drive]\npulses_per_turn = 5000\n')
            write = ("devices", "--units", "1-3", "--bus", "a", "--write", "--yes", "--config")
            self.assertEqual(bench.run(*write, outer).returncode, 0)
            inner = bench.folder / "inner.toml"
            inner.write_text(f'include = "{bench.config}"\n[axis.inner.drive]\npulses_per_turn = 5000\n')
            done = bench.run(*write, inner)
            self.assertEqual(done.returncode, 2)
            self.assertIn("units 1 and 3 hold each other's pulses per turn", done.stderr)
            self.assertEqual(bench.run(*write, outer).returncode, 0)

    def test_nothing_is_written_without_a_yes(self):
        with OutsideStand() as bench:
            self.assertEqual(bench.run("devices", "--write", "--json").returncode, 2)
            other = self.expecting(bench, 5000)
            done = bench.run("devices", "--units", "1-3", "--config", other, "--bus", "a", "--write")
            self.assertEqual(done.returncode, 2)
            self.assertIn("give --yes", done.stderr)
            self.assertIn("0x0001", done.stdout)
            master, slave = pty.openpty()
            try:
                os.write(master, b"n\n")
                asked = subprocess.run(
                    [BIN / "gyrobench", "devices", "--units", "1-3", "--config", other, "--bus", "a", "--write"],
                    stdin=slave, capture_output=True, text=True, timeout=DEADLINE_S)
            finally:
                os.close(master)
                os.close(slave)
            self.assertIn("Write these 2 values into the drives? Nothing moves. [y/N]", asked.stdout)
            self.assertIn("Nothing was written.", asked.stdout)
            self.scan(bench, "--bus", "a")

    def test_what_was_found_before_ctrl_c_is_shown(self):
        with OutsideStand() as bench:
            master, slave = pty.openpty()
            asking = subprocess.Popen([BIN / "gyrobench", "devices", "--config", bench.config], stdout=subprocess.PIPE,
                                      stderr=slave, text=True)
            try:
                os.close(slave)
                shown = b""
                while b"unit 2" not in shown:  # the bar has it from the second number on
                    shown += os.read(master, 4096)
                asking.send_signal(signal.SIGINT)
                told, _ = asking.communicate(timeout=DEADLINE_S)
            finally:
                asking.kill()
                asking.wait()
                os.close(master)
            self.assertEqual(asking.returncode, 1)
            told = " ".join(told.split())
            self.assertIn("then stopped by Ctrl-C", told)
            self.assertIn("axis.outer drive", told)
            self.assertIn("Nothing is known of ", told)

    def test_nothing_is_asked_beside_a_daemon(self):
        with OutsideStand() as bench:
            bench.start()
            done = bench.run("devices")
            self.assertEqual(done.returncode, 1)
            self.assertIn("in use by gyrobenchd", done.stderr)
            self.assertEqual(bench.status()["state"], "idle")

    def test_a_stand_that_is_virtual_has_no_lines(self):
        with OutsideStand() as bench:
            done = bench.run("devices", "--config", ROOT / "config/virtual.toml")
            self.assertEqual(done.returncode, 2)
            self.assertIn("gyrobench-stand --config", done.stderr)


if __name__ == "__main__":
    unittest.main()
