#!/usr/bin/env python3
"""`gyrobench hold` on simulated hands: what a user meets. test_hold.py GYROBENCH"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

import campaign
import hand as hands

PROGRAM = str(pathlib.Path(sys.argv.pop()).resolve())
POSES = pathlib.Path(__file__).resolve().parents[2] / "../shared/datasets"


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.table = str(pathlib.Path(self.folder.name) / "poses.csv")

    def call(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)

    def hold(self, *arguments, status=0):
        done = self.call("hold", self.table, "--json", *arguments)
        self.assertEqual(done.returncode, status, done.stderr)
        return json.loads(done.stdout) if done.stdout else None

    def write(self, hand, **table):
        truth, t, gyro, accel = hands.make(hand)
        hands.write(self.table, hand, t, gyro, accel, **table)
        return truth

    def assert_matrix(self, truth, result, sigmas=4.5):
        m = hands.in_accelerometer_frame(truth)[0]
        matrix = result["vector"]["matrix"]
        off = (np.array(matrix["m"]) - m) / np.array(matrix["m_std_error"])
        self.assertLess(np.abs(off).max(), sigmas)


class AnyTable(Folder):
    def test_the_unit_of_the_gyro_does_not_matter(self):
        for unit in ("lsb", "deg_s", "rad_s"):
            with self.subTest(unit=unit):
                truth = self.write(hands.Hand(seed=3), unit=unit)
                self.assert_matrix(truth, self.hold())

    def test_a_unit_that_the_columns_do_not_say_is_named(self):
        for gyro_factor, accel_factor, says in (
                (1000.0, 1.0, "gyro_z_deg_s are in mdeg/s"), (np.pi / 180.0, 1.0, "are in rad/s"),
                (1.0, 1000.0, "in mg, and not in g"), (1.0, 9.80665, "name them accel_x_m_s2")):
            with self.subTest(says=says):
                hand = hands.Hand(seed=3)
                _, t, gyro, accel = hands.make(hand)
                hands.write(self.table, hand, t, gyro_factor * gyro, accel_factor * accel, unit="deg_s")
                missing = " ".join(self.hold(status=1)["missing"])
                self.assertIn("this result cannot be", missing)
                self.assertIn(says, missing)

    def test_unsigned_counts_are_recognised(self):
        truth = self.write(hands.Hand(seed=3), zero=32768)
        result = self.hold()
        self.assert_matrix(truth, result)
        self.assertTrue(any("unsigned" in remark for remark in result["remarks"]))
        self.assertEqual(result["left_out"], [])

    def test_what_was_recognised_is_taken_off_again_where_the_calibration_is_applied(self):
        calibration, corrected = f"{self.folder.name}/cal.json", f"{self.folder.name}/corrected.csv"
        for zero in (32768, 0):
            with self.subTest(zero=zero):
                self.write(hands.Hand(seed=3), zero=zero)
                self.assertEqual(self.hold("--calibration", calibration)["gyro_lsb_zero"], zero)
                self.assertEqual(json.loads(pathlib.Path(calibration).read_text())["gyro_lsb_zero"], zero)
                done = self.call("apply", calibration, self.table, "-o", corrected, "--overwrite")
                self.assertEqual(done.returncode, 0, done.stderr)
                rows = [row for row in pathlib.Path(corrected).read_text().splitlines() if not row.startswith("#")]
                rates = np.genfromtxt(rows, delimiter=",", names=True)
                for axis in "xyz":
                    self.assertLess(abs(np.median(rates[f"gyro_{axis}_deg_s"])), 1.0)

    def test_a_sensitivity_that_is_not_given_comes_from_the_turns(self):
        truth = self.write(hands.Hand(seed=4), give_sensitivity=False)
        result = self.hold()
        self.assertFalse(result["sensitivity_given"])
        scale = np.linalg.norm(truth.m, axis=1) * 32.8
        np.testing.assert_allclose(result["units_per_deg_s"], scale, rtol=1e-3)

    def test_a_reversed_axis_is_found_and_said(self):
        hand = hands.Hand(seed=5)
        truth, t, gyro, accel = hands.make(hand)
        gyro[:, 1] *= -1
        hands.write(self.table, hand, t, gyro, accel)
        result = self.hold()
        self.assertLess(result["vector"]["matrix"]["m"][1][1], -0.9)
        self.assertTrue(any("left-handed" in remark for remark in result["vector"]["remarks"]))

    def test_the_calibration_corrects_the_table(self):
        hand = hands.Hand(seed=6, trembles=False)
        truth = self.write(hand)
        folder = pathlib.Path(self.folder.name)
        self.hold("--calibration", str(folder / "cal.json"))
        done = self.call("apply", str(folder / "cal.json"), self.table, "-o", str(folder / "out.csv"))
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = (folder / "out.csv").read_text().splitlines()
        corrected = np.loadtxt([line for line in lines if not line.startswith("#")][1:], delimiter=",")
        d = np.linalg.norm(truth.t, axis=1)
        u, _, vt = np.linalg.svd(truth.t / d[:, None])
        true_rate = truth.rate / hands.DEG @ (u @ vt).T
        fast = np.abs(true_rate).max(axis=1) > 20
        error = corrected[fast, 1:4] - true_rate[fast]
        self.assertLess(np.sqrt(np.mean(error**2)), 0.06)  # the noise of a sample is 0.035 deg/s


class BadInput(Folder):
    def test_turns_about_one_axis_give_no_number_and_say_what_to_do(self):
        self.write(hands.Hand(seed=1, only_axis=2, faces=False))
        result = self.hold(status=1)
        self.assertIsNone(result["vector"])
        self.assertIsNone(result["verdict"])
        self.assertIn("cannot be told", " ".join(result["missing"]))

    def test_too_few_poses_are_counted(self):
        self.write(hands.Hand(seed=1, poses=6))
        self.assertIn("6 rests", " ".join(self.hold(status=1)["missing"]))

    def test_saturated_turns_are_left_out_and_said(self):
        truth = self.write(hands.Hand(seed=7, lsb_per_deg_s=131.0))
        result = self.hold()
        self.assertTrue(any(left["what"] == "turn" and "saturat" in left["because"] for left in result["left_out"]))
        self.assert_matrix(truth, result)

    def test_gaps_and_missing_values_are_left_out(self):
        hand = hands.Hand(seed=8)
        truth, t, gyro, accel = hands.make(hand)
        in_turn = truth.rests[3][1] + 40
        gyro[in_turn:in_turn + 10, 0] = np.nan
        keep = np.ones(len(t), bool)
        second = truth.rests[6][1] + 30
        keep[second:second + 60] = False
        hands.write(self.table, hand, t[keep], gyro[keep], accel[keep], unit="deg_s")
        result = self.hold()
        self.assertEqual(len(result["left_out"]), 2)
        self.assert_matrix(truth, result)

    def test_repeated_time_stamps_are_mended_and_counted(self):
        hand = hands.Hand(seed=9)
        truth, t, gyro, accel = hands.make(hand)
        t[500:12000:50] = t[499:11999:50]
        hands.write(self.table, hand, t, gyro, accel)
        result = self.hold()
        self.assertIn("repeated_time", [defect["kind"] for defect in result["inputs"][0]["defects"]])
        self.assert_matrix(truth, result, sigmas=6.0)

    def test_no_accelerometer_is_an_error_with_the_column_to_add(self):
        pathlib.Path(self.table).write_text("t_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s\n" +
                                            "".join(f"{i / 100},0,0,{i % 3}\n" for i in range(900)))
        done = self.call("hold", self.table)
        self.assertEqual(done.returncode, 1)
        self.assertIn("accel_x_g", done.stderr)

    def test_a_knocked_turn_is_left_out(self):
        hand = hands.Hand(seed=10)
        truth, t, gyro, accel = hands.make(hand)
        knocked = truth.rests[4][1] + 30
        gyro[knocked:knocked + 10, 0] += 30.0  # 3 deg that the sensor did not turn
        hands.write(self.table, hand, t, gyro, accel)
        result = self.hold()
        self.assertEqual([left["what"] for left in result["left_out"]], ["turn"])
        self.assert_matrix(truth, result)

    def test_a_table_with_a_reference_is_pointed_to_trace(self):
        hand = hands.Hand(seed=3)
        self.write(hand)
        lines = pathlib.Path(self.table).read_text().splitlines()
        head = next(i for i, line in enumerate(lines) if line.startswith("t_s"))
        lines[head] += ",ref_angle_z_deg"
        pathlib.Path(self.table).write_text("\n".join(lines[:head + 1] + [line + ",0" for line in lines[head + 1:]]) + "\n")
        self.assertTrue(any("gyrobench trace" in remark for remark in self.hold()["remarks"]))


class Measured(Folder):
    def test_three_sensors_on_one_plate_agree_with_themselves(self):
        files = [POSES / f"poses-{i}.csv.gz" for i in range(3)]
        if not all(file.exists() for file in files):
            self.skipTest("the measured recordings are not here")
        for file in files:
            self.table = str(file)
            result = self.hold()
            self.assertEqual((result["rests"], result["turns"]), (22, 21), file)
            self.assertLess(result["angle_rms_deg"], 0.2)
            self.assertLess(np.max(result["vector"]["matrix"]["m_std_error"]), 1e-3)


class Odds(unittest.TestCase):
    """A slice of the campaign; its limits are three standard deviations of so few sets."""

    def test_error_intervals_and_g_sensitivity(self):
        for name in ("hand", "laid", "laid g-sensitivity"):
            with self.subTest(name=name):
                changes = campaign.CLASSES[name]
                figures = campaign.campaign(PROGRAM, name, changes, 10, 501)
                self.assertTrue(campaign.holds(figures, changes.get("g_deg_s_g", 0) > 0), figures)


if __name__ == "__main__":
    unittest.main()
