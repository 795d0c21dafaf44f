#!/usr/bin/env python3
"""A slice of the campaign of wiring mistakes, and what `commission` says and refuses."""
import sys
import unittest

import campaign
from campaign import benches


class Slice(unittest.TestCase):
    def test_each_mistake_and_some_pairs_are_named_and_mended(self):
        self.assertEqual(campaign.main(["--pairs", "8", "--first-seed", "3"]), 0)


class Said(unittest.TestCase):
    def test_a_person_reads_what_is_wrong_with_its_reason_and_line(self):
        extra = '[virtual.answers]\nmarks = "done"\nwrite_stand_file = "leave"\n'
        with benches.Bench(extra=extra, start=False) as bench:
            (bench.folder / "right.toml").write_text(bench.config.read_text())
            bench.config.write_text(bench.config.read_text() + f'[virtual]\nwired_as = "{bench.folder}/right.toml"\n'
                                    "[axis.inner.encoder]\nsign = -1\n")
            bench.start()
            done = bench.run("run", "commission")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("reversed encoder\n", done.stdout)
            self.assertIn("axis.inner.encoder.sign = 1 (was -1)", done.stdout)
            self.assertFalse((bench.folder / "stand.commissioned.toml").exists())
            # The record can be shown, and the stand is as ready as before.
            self.assertEqual(bench.run("show", "latest").returncode, 0)
            self.assertEqual(bench.status()["state"], "idle")

    def test_stop_ends_it_and_the_axes_stand(self):
        with benches.Bench(extra='[virtual]\npace = 1\n[virtual.answers]\nmarks = "done"\n') as bench:
            bench.run("run", "commission", "--detach")
            while bench.status()["run"]["elapsed_s"] < 4.0:
                pass
            bench.run("stop")
            while bench.status()["state"] != "idle":
                pass
            self.assertEqual(bench.status()["run"]["outcome"], "aborted")
            self.assertFalse(any(axis["moving"] for axis in bench.status()["axes"]))

    def test_other_procedures_may_not(self):
        script = 'procedure = { summary = "tries" }\nfunction run() bench.find_wiring() end\n'
        with benches.Bench(procedures={"tries": script}) as bench:
            done = bench.run("run", "tries")
            self.assertEqual(done.returncode, 1)
            self.assertIn("commissions = true", done.stdout + done.stderr)


if __name__ == "__main__":
    sys.exit(unittest.main())
