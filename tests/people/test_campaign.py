"""The campaign's own judgement, and a slice of it: one program a world, as people make it."""
import unittest

import campaign
from judge import judge, loop_of
from worlds import EFFECTS, all_worlds


def effect(name, rivals=()):
    return {"id": name, "rivals": list(rivals),
            "parameters": [{"name": "c", "value": 1.0, "std_error": None, "unit": "1"}]}


def trace_of(**channels):
    return {"channels": [{"gyro": axis, "verdict": "explained" if effects else "none", "effects": effects}
                         for axis, effects in channels.items()]}


class Judgement(unittest.TestCase):
    def counts(self, trace, truth, hidden=None):
        judged = judge(trace, truth, hidden)
        return [len(judged[kind]) for kind in ("true", "false", "wrong")]

    def test_what_is_not_in_the_world_is_a_false_name(self):
        self.assertEqual(self.counts(trace_of(z=[effect("angle.ripple")]), set()), [0, 1, 0])
        self.assertEqual(self.counts(trace_of(z=[]), set()), [0, 0, 0])

    def test_a_name_is_true_by_its_id_or_by_a_rival(self):
        self.assertEqual(self.counts(trace_of(z=[effect("scale.cubic")]), {"scale.cubic"}), [1, 0, 0])
        by_rival = trace_of(z=[effect("scale.quadratic_odd", ["scale.cubic"])])
        self.assertEqual(self.counts(by_rival, {"scale.cubic"}, "scale.cubic"), [1, 0, 0])
        self.assertTrue(judge(by_rival, {"scale.cubic"}, "scale.cubic")["hidden_named"])

    def test_a_false_name_in_the_place_of_what_is_hidden_is_a_wrong_one(self):
        wrong = trace_of(x=[], z=[effect("angle.backlash")])
        self.assertEqual(self.counts(wrong, {"scale.cubic"}, "scale.cubic"), [0, 1, 1])
        extra = trace_of(x=[effect("bias.tone")], z=[effect("scale.cubic"), effect("angle.backlash")])
        self.assertEqual(self.counts(extra, {"scale.cubic"}, "scale.cubic"), [1, 2, 0])

    def test_what_is_hidden_in_the_z_axis_is_false_of_the_others_and_what_all_share_is_not(self):
        both = trace_of(x=[effect("scale.cubic")], z=[effect("scale.cubic")])
        self.assertEqual(self.counts(both, {"scale.cubic"}, "scale.cubic"), [1, 1, 0])
        self.assertFalse(judge(trace_of(x=[effect("scale.cubic")], z=[]), {"scale.cubic"}, "scale.cubic")["hidden_named"])
        shared = trace_of(x=[effect("angle.latency")], z=[effect("angle.latency")])
        self.assertEqual(self.counts(shared, {"angle.latency"}, "angle.latency"), [2, 0, 0])

    def test_a_loop_is_settled_by_its_last_word(self):
        said = [{"text": "manoeuvre 1: turns"}, {"text": "after 2 min"}, {"text": "settled: nothing else"}]
        run = {"said": said, "start_utime": 0, "end_utime": 120_000_000}
        self.assertEqual(loop_of(run), {"settled": True, "ended": "settled: nothing else", "minutes": 2.0,
                                        "manoeuvres": 1})
        self.assertFalse(loop_of({**run, "said": said[:2]})["settled"])


class Worlds(unittest.TestCase):
    def test_every_effect_has_a_world_in_which_it_is_all_the_truth(self):
        worlds = all_worlds()
        for name in EFFECTS:
            self.assertEqual(worlds[f"quiet+{name}"].truth, {name})


class Slice(unittest.TestCase):
    # Two runs of one kind of which nothing is to be said, and one of an effect that such a run shows.
    def test_short_runs_name_nothing_where_nothing_is_and_what_is_where_it_is(self):
        self.assertEqual(campaign.main(["--seeds", "1", "--procedures", "scale+scale", "--scenarios",
                                        "full-sequence", "--most-false", "0"]), 0)
        job = campaign.Job(all_worlds()["quiet+angle.latency"], "scale", 3, 1)
        rows = campaign.perform(job, None)
        self.assertEqual([row["error"] for row in rows], [""])
        self.assertTrue(rows[0]["hidden_named"], rows)

    # The pair that the README proposes. A delay of the reference was called two clocks that part in every second one.
    def test_a_delay_in_bias_and_scale_together_is_no_drift_of_the_clock(self):
        rows = campaign.perform(campaign.Job(all_worlds()["typical"], "bias+scale", 3, 30055), None)
        self.assertEqual([row["error"] for row in rows], [""] * 3)
        self.assertEqual([row["false"] for row in rows], [[]] * 3)

    # Of a strong effect its own shape leaves a little, which passed for a scale factor of temperature and rate, or waves.
    def test_beside_a_strong_effect_nothing_is_named_that_its_shape_leaves(self):
        for world, procedure, seed in (("quiet+angle.backlash", "sweep", 77351), ("quiet+angle.clock_drift", "poses", 77156)):
            rows = campaign.perform(campaign.Job(all_worlds()[world], procedure, 3, seed), None)
            self.assertEqual([(row["error"], row["false"], row["hidden_named"]) for row in rows], [("", [], True)])


if __name__ == "__main__":
    unittest.main()
