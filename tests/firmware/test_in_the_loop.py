"""`gyrobench run scale` on a stand whose gyro unit is the firmware in an emulated processor.

    test_in_the_loop.py STAND_WITH_FIRMWARE

The resonator of the processor is 0.25 % off: the clock ratio shows it, and the scale factor does not.
"""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))

from outside_stand import OutsideStand  # noqa: E402

STAND_WITH_FIRMWARE = sys.argv.pop()
TICK_REL, SCALE_REL = 0.0025, 0.012
SCENARIO = f"""
based_on = "ideal"
[gyro]
scale_rel = [0.0, 0.0, {SCALE_REL}]
angle_random_walk_deg_sqrt_s = [0.002, 0.002, 0.002]
[encoder]
noise_deg = 0.0015
[unit]
tick_rel = {TICK_REL}
[bus]
turnaround_s = 0.004
"""


class FirmwareInTheLoop(unittest.TestCase):
    def test_the_scale_factor_is_right_and_the_resonator_is_in_the_clock_ratio(self):
        with OutsideStand(program=STAND_WITH_FIRMWARE, stand_scenario=SCENARIO) as bench:
            bench.start()
            while bench.json("status")["state"] != "idle":  # each try is a process, so no busy loop
                pass
            bench.json("run", "scale", "-p", "turns=4", "-p", "initial_rest_s=10", "-p", "rest_s=1")
            result = bench.json("show", "latest")["result"]
        self.assertEqual(result["defects"], [])
        self.assertAlmostEqual(result["samples"], 200 * result["duration_s"], delta=2)
        (scale,) = result["scale"]
        self.assertEqual(scale["turns"], 8)
        # Rate over output: what the part gives too much.
        nominal = 1.0 / 131.0
        self.assertLess(abs(scale["alpha"] - nominal / (1.0 + SCALE_REL)), 4.0 * scale["alpha_std_error"])
        self.assertLess(scale["alpha_std_error"], 3e-4 * nominal)
        # Seconds of the host for one of the unit.
        self.assertLess(abs(scale["tick_ratio"] - 1.0 / (1.0 + TICK_REL)), 5.0 * scale["tick_ratio_std_error"])
        self.assertLess(scale["tick_ratio_std_error"], 3e-5)


if __name__ == "__main__":
    unittest.main()
