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
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("reversed encoder\n", done.stdout)
            self.assertIn("axis.inner.encoder.sign = 1 (was -1)", done.stdout)
            self.assertFalse((bench.folder / "stand.commissioned.toml").exists())
            # The record shows the same, and the stand is as ready as before.
            self.assertIn("axis.inner.encoder.sign = 1 (was -1)", bench.run("show", "latest").stdout)
            self.assertEqual(bench.status()["state"], "idle")

    def test_a_person_may_answer_while_a_drive_is_unwell(self):
        with benches.Bench(start=False) as bench:
            (bench.folder / "right.toml").write_text(bench.config.read_text())
            bench.config.write_text(bench.config.read_text() + f'[virtual]\nwired_as = "{bench.folder}/right.toml"\n'
                                    "[axis.middle.drive]\npulses_per_turn = 5000\n"
                                    '[axis.outer.encoder]\nword_order = "low_first"\n')
            no_answers = (benches.ROOT / "config/virtual.toml").read_text().replace('marks = "done"\n', "").replace(
                'write_stand_file = "leave"\n', "").replace("stand.toml", f"{benches.ROOT}/config/stand.toml").replace(
                "scenarios/", f"{benches.ROOT}/config/scenarios/")
            (bench.folder / "base.toml").write_text(no_answers)
            bench.config.write_text(bench.config.read_text().replace(f"{benches.ROOT}/config/virtual.toml",
                                                                     f"{bench.folder}/base.toml"))
            bench.start()
            bench.run("run", "commission", "--detach")
            for answer in ("done", "write"):
                while bench.status()["state"] != "asking":
                    self.assertNotEqual(bench.status()["run"]["outcome"], "fault", bench.status())
                self.assertEqual(bench.run("answer", answer).returncode, 0)
            while not bench.status()["run"]["outcome"]:
                pass
            self.assertEqual(bench.status()["run"]["outcome"], "done", bench.status())
            written = (bench.folder / "stand.commissioned.toml").read_text()
            self.assertIn('word_order = "high_first"', written)
            self.assertIn("pulses_per_turn = 10000", written)

    def test_an_answer_that_is_none_is_refused(self):
        with benches.Bench(extra='[virtual.answers]\nmarks = "yes"\n') as bench:
            done = bench.run("run", "commission")
            self.assertEqual(done.returncode, 1)
            self.assertIn("expected one of done", done.stdout + done.stderr)

    def test_a_limit_input_that_acts_stops_it(self):
        scenario = campaign.SCENARIO + '[[fault]]\ndevice = "middle.drive"\nkind = "limit_plus"\non = "move"\ncount = 4\n'
        inputs = ("inputs_address = 0x0179\nemergency_stop_input_bit = 0\nlimit_plus_input_bit = 1\n"
                  "limit_minus_input_bit = 2\n")
        with benches.Bench(scenario=scenario, start=False) as bench:
            drive = (benches.ROOT / "config/devices/leadshine-rs.toml").read_text()
            (bench.folder / "drive.toml").write_text(drive + inputs)
            maps = "".join(f'[axis.{axis}.drive]\nmap = "{bench.folder}/drive.toml"\n' for axis in campaign.AXES)
            bench.config.write_text(bench.config.read_text() + '[virtual.answers]\nmarks = "done"\n' + maps)
            bench.start()
            done = bench.run("run", "commission")
            self.assertIn("axis.middle: its limit input acts", done.stdout + done.stderr)
            self.assertFalse(any(axis["moving"] for axis in bench.status()["axes"]))

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
