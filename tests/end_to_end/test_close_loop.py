"""The stand finds by itself what nothing declares, and says what it asked for and why."""
import json
import unittest

from bench import Bench


class CloseLoop(unittest.TestCase):
    def test_the_loop_names_what_is_hidden_and_its_course_is_kept(self):
        with Bench(base="undeclared.toml") as bench:
            done = bench.run("run", "close_loop", "-p", "fan=false", "-p", "budget_min=12")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("manoeuvre 1: ", done.stdout)
            # What is said on the way is broken to lines, in a file as well.
            course = done.stdout[:done.stdout.index("Scale factor, gyro")]
            self.assertLessEqual(max(len(line) for line in course.splitlines()), 120)
            self.assertIn("chi-square", course)
            record = bench.newest_record()
            run = json.loads((record / "run.json").read_text())
            said = [one["text"] for one in run["said"]]
            # Each manoeuvre lies between two verdicts, and all within the budget.
            asked = [text for text in said if text.startswith("manoeuvre ")]
            verdicts = [text for text in said if text.startswith("after ")]
            self.assertGreaterEqual(len(asked), 2)
            self.assertEqual(len(verdicts), len(asked) + 1)
            self.assertLess(run["said"][-1]["t_s"], 1.1 * 12 * 60)
            trace = json.loads((record / "trace.json").read_text())
            z = next(channel for channel in trace["channels"] if channel["gyro"] == "z")
            named = [name for effect in z["effects"] for name in [effect["id"], *effect["rivals"]]]
            self.assertIn("scale.cubic", named)
            report = (record / "report.html").read_text()
            self.assertIn("Course of the run", report)
            self.assertIn(asked[0].split(";")[0], report)


if __name__ == "__main__":
    unittest.main()
