"""`gyrobench bus`: what the daemon counts on its lines, and what a hand on the wires leaves in it."""
import json
import signal
import subprocess
import time
import unittest

from bench import BIN, DEADLINE_S
from outside_stand import OutsideStand


class Bus(unittest.TestCase):
    def test_every_device_has_its_figures(self):
        with OutsideStand() as bench:
            bench.start()
            asked, end = {}, time.monotonic() + DEADLINE_S
            while len(asked) < 8:
                self.assertLess(time.monotonic(), end, asked)
                buses = {bus["name"]: bus for bus in bench.json("bus")["buses"]}
                asked = {unit["unit"]: unit for bus in buses.values() for unit in bus["all"]["units"]}
            self.assertEqual(sorted(buses), ["a", "b"])
            self.assertEqual(sorted(asked), [1, 2, 3, 11, 12, 13, 21, 31])
            for unit in asked.values():
                self.assertGreater(unit["transactions"], 0, unit)
                self.assertLessEqual(unit["latency_median_s"], unit["latency_99_s"], unit)
                self.assertGreater(unit["latency_median_s"], 1e-3, "8 bytes at 115200 baud and as many back")
            for bus in buses.values():
                self.assertAlmostEqual(bus["all"]["load"], sum(u["load"] for u in bus["all"]["units"]), places=9)
                self.assertLess(bus["all"]["load"], 1.0)
                self.assertLess(bus["expected_load"], 0.9)
                for unit, recent in zip(bus["all"]["units"], bus["recent"]["units"]):
                    self.assertEqual(unit["unit"], recent["unit"])
                    self.assertLessEqual(recent["transactions"], unit["transactions"])
            shown = bench.run("bus").stdout
            self.assertIn("axis.inner encoder", shown)
            self.assertIn("failures", shown)

    def test_a_silent_device_is_counted_as_silent(self):
        with OutsideStand() as bench:
            config = bench.config.read_text()
            bench.config.write_text(config.replace("unit = 31", "unit = 30"))
            bench.start()
            end = time.monotonic() + DEADLINE_S
            while True:
                self.assertLess(time.monotonic(), end)
                units = {u["unit"]: u for bus in bench.json("bus")["buses"] for u in bus["all"]["units"]}
                if 30 in units and units[30]["given_up"]:
                    break
            silent = units[30]
            self.assertGreaterEqual(silent["silent"], silent["given_up"])
            self.assertEqual((silent["unreadable"], silent["refused"], silent["line_lost"]), (0, 0, 0))
            self.assertIsNone(silent["latency_median_s"])

    def test_it_is_shown_again_and_again_until_ctrl_c(self):
        with OutsideStand() as bench:
            bench.start()
            command = [BIN / "gyrobench", "bus", "--every", "0.1", "--json", "--config", bench.config]
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as shown:
                lines = [json.loads(shown.stdout.readline()) for _ in range(3)]
                self.assertTrue(all("buses" in line for line in lines))
                shown.send_signal(signal.SIGINT)
                shown.communicate(timeout=DEADLINE_S)
            self.assertEqual(shown.returncode, 0)


if __name__ == "__main__":
    unittest.main()
