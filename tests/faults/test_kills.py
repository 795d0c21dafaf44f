"""The judgement of the campaign of kills and power cuts, and a slice of it."""
import random
import unittest

import kills

LOG = bytes(range(1, 251)) * 100


class Cuts(unittest.TestCase):
    def test_leave_what_had_reached_the_disk_and_make_whole_pages_zero(self):
        rng = random.Random(1)
        some_zero = 0
        for _ in range(200):
            synced = rng.randint(0, len(LOG))
            left = kills.cut(LOG, synced, rng)
            self.assertEqual(left[:synced], LOG[:synced])
            self.assertLessEqual(len(left), len(LOG))
            for begin in range(0, len(left), kills.PAGE):
                page = slice(max(begin, synced), min(begin + kills.PAGE, len(left)))
                self.assertIn(left[page], (LOG[page], bytes(len(left[page]))))
            some_zero += left != LOG[:len(left)]
        self.assertGreater(some_zero, 50)


class Invented(unittest.TestCase):
    ROWS = [("1.0", "5", ""), ("2.0", "6", "0.5"), ("2.0", "", "0.7")]

    def test_a_row_may_have_lost_one_of_its_parts(self):
        self.assertEqual(kills.invented([("2.0", "6", ""), ("2.0", "", "0.5"), ("2.0", "", "0.7"), ("1.0", "5", "")], self.ROWS), [])

    def test_other_values_and_other_times_were_not_measured(self):
        for row in (("1.0", "4", ""), ("2.0", "6", "0.7"), ("3.0", "5", ""), ("1.0", "5", "0.5")):
            self.assertEqual(kills.invented([row], self.ROWS), [row])


class Slice(unittest.TestCase):
    def test_nothing_is_lost_and_the_next_start_is_in_order(self):
        self.assertEqual(kills.main(["--kills", "4", "--cuts", "9", "--resumes", "1", "--seed", "3"]), 0)


if __name__ == "__main__":
    unittest.main()
