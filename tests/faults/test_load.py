"""The campaigns of load and of endurance: their own judgement, and a slice of each."""
import argparse
import concurrent.futures
import os
import pathlib
import types
import unittest

import load
import soak

STALLING_DISK = os.environ.get("GYROBENCH_STALLING_DISK")


def block(first, n, missed=0, seq=0, boot=1):
    return types.SimpleNamespace(first=first, n=n, missed=missed, seq=seq, boot_count=boot)


class Judgement(unittest.TestCase):
    def judge(self, missed, message, outcome="done"):
        blocks = [block(0, 1200, seq=1), block(1200 + missed, 1200, missed, seq=2)]
        return load.judge({"outcome": outcome, "message": message}, blocks)[1]

    def test_samples_that_are_there_or_told_as_lost_are_as_they_must_be(self):
        self.assertEqual(self.judge(0, ""), [])
        self.assertEqual(self.judge(400, "400 samples of the gyro were lost"), [])

    def test_samples_that_are_lost_and_not_told_are_not(self):
        self.assertIn("does not say so", self.judge(400, "")[0])
        unmarked = load.judge({"outcome": "done", "message": ""}, [block(0, 1200, seq=1), block(1300, 1200, seq=2)])[1]
        self.assertIn("100 samples", unmarked[0])

    def test_a_run_that_ended_otherwise_is_told(self):
        self.assertIn("ended fault", self.judge(0, "x", outcome="fault")[0])

    def test_the_percentile_is_of_sorted_times_and_never_beyond_them(self):
        self.assertEqual(load.percentile(list(range(1000)), 0.99), 990)
        self.assertEqual(load.percentile([3.0], 0.99), 3.0)

    def grown(self, by_mib, descriptors=0, lost=0):
        rows = [{"memory_mib": 50 + (5 if i % 3 else 0) + by_mib * i, "descriptors": 20 + descriptors * i, "lost": lost}
                for i in range(40)]
        return soak.judge(rows, argparse.Namespace(most_growth=5, most_descriptors=0))

    def test_what_comes_and_goes_is_no_growth_and_what_stays_is(self):
        self.assertEqual(self.grown(0), [])
        self.assertIn("memory has grown", self.grown(1)[0])
        self.assertIn("descriptors have grown", self.grown(0, descriptors=1)[0])
        self.assertIn("40 samples were lost", self.grown(0, lost=1)[0])


class Slice(unittest.TestCase):
    def test_stops_pass_by_a_crowd_and_no_sample_is_lost_in_silence(self):
        # The storm begins once clocks were compared for 20 s: the stops fit into them.
        library = pathlib.Path(STALLING_DISK) if STALLING_DISK else None
        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            storm = pool.submit(load.storm, library)
            for name in ("running", "suspended", "fault"):
                self.assertEqual(len(load.stops_in(name, 3)[0]), 3)
            row, found = storm.result()
        self.assertEqual(found, [], row)

    def test_half_an_hour_of_runs_neither_grows_nor_loses_anything(self):
        self.assertEqual(soak.main(["--hours", "0.5"]), 0)


if __name__ == "__main__":
    unittest.main()
