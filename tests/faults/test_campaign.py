"""The campaign's own judgement, and a slice of it: what fails in each way must end as it must."""
import pathlib
import struct
import tempfile
import unittest

import campaign
import record
from kinds import KINDS, PROCEDURES, Scenario, scenarios
from spoilt import marked, spoilt
from truth import Truth

HEAD = "# power-on at utime 1000\nt_s,what,device,value\n"


def truth_of(*lines):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "truth.csv"
        path.write_text(HEAD + "".join(line + "\n" for line in lines))
        return Truth(path)


def turning(axis, begin_s, rate_deg_s, seconds, from_deg=0.0):
    return [f"{begin_s + 0.1 * i:.3f},angle,{axis},{from_deg + 0.1 * i * rate_deg_s:.4f}"
            for i in range(round(10 * seconds) + 1)]


class TruthJudgement(unittest.TestCase):
    def test_an_axis_that_stays_within_its_limits_and_obeys_is_no_breach(self):
        truth = truth_of("1.000,move,inner,20.0000", *turning("inner", 1, 10, 2), "3.100,stop,inner,0.0000")
        self.assertEqual(truth.breaches(400), [])
        self.assertIsNone(truth.fault_s())

    def test_an_axis_beyond_its_limit_is_named_with_how_far_it_went(self):
        (breach,) = truth_of(*turning("outer", 1, 100, 5)).breaches(400)
        self.assertIn("outer", breach)
        self.assertIn("500.0 deg", breach)

    def test_what_turns_after_its_stop_is_a_breach_until_the_next_move(self):
        stop = "1.000,stop,inner,0.0000"
        self.assertIn("after its stop", truth_of(stop, *turning("inner", 1, 1, 5)).breaches(400)[0])
        moved = truth_of(stop, "1.500,move,inner,5.0000", *turning("inner", 1.5, 1, 5))
        self.assertEqual(moved.breaches(400), [])

    def test_a_runaway_must_be_stopped_soon(self):
        fault = "1.000,fault,inner.drive,5.0000"
        soon = truth_of(fault, *turning("inner", 1, 5, 1), "2.000,stop,inner,0.0000")
        self.assertEqual(soon.breaches(400, ("inner", 5)), [])
        late = truth_of(fault, *turning("inner", 1, 5, 9), "10.000,stop,inner,0.0000")
        self.assertIn("ran away for 9.0 s", late.breaches(400, ("inner", 5))[0])
        never = truth_of(fault, *turning("inner", 1, 5, 9))
        self.assertIn("never stopped", never.breaches(400, ("inner", 5))[0])

    def test_way_is_what_was_commanded_from_then_on(self):
        truth = truth_of("1.000,move,inner,20.0000", *turning("inner", 1, 10, 1), "4.000,move,inner,-10.0000")
        self.assertAlmostEqual(truth.commanded_deg("inner", 2.0), 10 + 30, places=3)
        self.assertEqual(truth.commanded_deg("outer", 0.0), 0.0)

    def test_a_heater_is_on_until_it_is_switched_off(self):
        self.assertFalse(truth_of().heater_on())
        self.assertTrue(truth_of("1.000,heater,relays,1.0000").heater_on())
        self.assertFalse(truth_of("1.000,heater,relays,1.0000", "2.000,heater,relays,0.0000").heater_on())

    def test_a_table_is_astray_by_what_it_lacks_when_the_next_command_comes(self):
        truth = truth_of("1.000,move,inner,20.0000", *turning("inner", 1, 10, 1), "4.000,stop,inner,0.0000")
        self.assertAlmostEqual(truth.astray_deg("inner", 0.5), 10, places=3)
        self.assertEqual(truth.astray_deg("inner", 5.0), 0.0)


def event(channel, data):
    return struct.pack(">IqqII", record.SYNC, 0, 0, len(channel), len(data)) + channel.encode() + data


def block(seq, first, n, missed=0, boot=7):
    run_id = b"r\0"
    return event("GYROBENCH_GYRO", struct.pack(">Qq", 1, 0) + struct.pack(">i", len(run_id)) + run_id
                 + struct.pack(">qqdiqddiq", seq, 0, 250000.0, boot, missed, 131.0, 16384.0, n, first))


class RecordJudgement(unittest.TestCase):
    def read(self, data):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "events.lcmlog"
            path.write_bytes(data)
            return record.read(path)[0]

    def test_what_is_continuous_or_said_to_be_missing_is_no_gap(self):
        blocks = self.read(block(1, 0, 10) + block(2, 10, 10) + block(3, 25, 5, missed=5))
        self.assertEqual(record.unmarked_gaps(blocks), [])

    def test_missing_samples_and_messages_of_which_nothing_is_said_are_gaps(self):
        gaps = record.unmarked_gaps(self.read(block(1, 0, 10) + block(2, 15, 10) + block(4, 25, 5)))
        self.assertEqual(len(gaps), 2)
        self.assertIn("5 samples before sample 15", gaps[0])
        self.assertIn("message 3", gaps[1])

    def test_what_the_first_block_misses_may_lie_behind_its_first_sample(self):
        # It caught up in several requests: samples 0 to 3, then 13 to 18.
        blocks = self.read(block(1, 0, 10, missed=9) + block(2, 19, 10) + block(3, 29, 5))
        self.assertEqual(record.unmarked_gaps(blocks), [])
        more = self.read(block(1, 0, 10, missed=9) + block(2, 20, 10))
        self.assertIn("10 samples before sample 20", record.unmarked_gaps(more)[0])

    def test_a_unit_that_restarted_counts_anew(self):
        blocks = self.read(block(1, 500, 10) + block(2, 0, 0, boot=8) + block(3, 40, 5, boot=8) + block(4, 45, 5, boot=8))
        self.assertEqual(record.unmarked_gaps(blocks), [])
        lost = self.read(block(1, 0, 5, boot=8) + block(2, 5, 5, boot=8) + block(3, 40, 5, boot=8))
        self.assertEqual(len(record.unmarked_gaps(lost)), 1)

    def test_half_an_event_is_a_broken_record(self):
        with self.assertRaises(record.Broken):
            self.read(block(1, 0, 10) + block(2, 10, 10)[:-3])


def result_of(alpha=0.0076, defects=()):
    return {"scale": [{"axis": "z", "alpha": alpha, "alpha_std_error": 1e-7, "remarks": []}], "bias": [],
            "defects": list(defects), "remarks": []}


class ResultJudgement(unittest.TestCase):
    def test_what_is_off_by_far_more_than_its_error_is_spoilt(self):
        clean = [result_of(), None]
        self.assertEqual(spoilt([result_of(0.0076001), None], clean), "")
        self.assertIn("scale of z", spoilt([result_of(0.0077), None], clean))

    def test_a_defect_that_a_clean_run_has_not_is_a_mark(self):
        clean = [result_of(), None]
        self.assertEqual(marked([result_of(), None], clean), "")
        self.assertIn("gap", marked([result_of(defects=[{"kind": "gap"}]), None], clean))


class Scenarios(unittest.TestCase):
    def test_a_scenario_is_what_its_name_says_every_time(self):
        for scenario in scenarios(1, 2 * len(KINDS)):
            again = Scenario(scenario.kind, scenario.procedure, scenario.seed)
            self.assertEqual((again.fault, again.name), (scenario.fault, scenario.name))

    def test_every_kind_and_every_procedure_has_its_turn(self):
        drawn = scenarios(1, 500)
        self.assertEqual({scenario.kind.name for scenario in drawn}, {kind.name for kind in KINDS})
        self.assertEqual({scenario.procedure for scenario in drawn}, set(PROCEDURES))


class Slice(unittest.TestCase):
    def test_what_fails_ends_as_it_must(self):
        kinds = ("bad_crc", "garbage at times", "exception", "reboot of the unit", "reboot of a drive", "frozen reference",
                 "saturation", "alarm", "lost_steps", "jammed", "slipping", "stale at times")
        self.assertEqual(campaign.main(["--scenarios", str(len(kinds)), "--kinds", ",".join(kinds),
                                        "--procedures", "scale,rates,sweep", "--first-seed", "7"]), 0)


if __name__ == "__main__":
    unittest.main()
