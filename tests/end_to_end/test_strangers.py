"""Two daemons on one LCM address and prefix: each is told of the other, and whoever listens tells them apart."""
import os
import subprocess
import unittest

from bench import BIN, DEADLINE_S, Bench, have_multicast

SHORT = ["-p", "initial_rest_s=5", "-p", "window_s=10", "-p", "max_duration_s=60"]


@unittest.skipUnless(have_multicast(), "no multicast here: ip route add 239.255.76.67/32 dev lo")
class TwoDaemons(unittest.TestCase):
    def setUp(self):
        self.first = Bench()
        self.second = Bench()
        self.second.config.write_text(self.second.config.read_text().replace(str(self.second.port), str(self.first.port)))

    def told(self, bench):
        """Its notices, once it has any."""
        while not (notices := bench.status()["notices"]):
            self.assertIsNone(bench.daemon.poll())
        return [notice["text"] for notice in notices]

    def test_each_is_told_once_of_the_other_by_its_instance(self):
        with self.first, self.second:
            for one, other in ((self.first, self.second), (self.second, self.first)):
                (text,) = self.told(one)
                self.assertIn("instance " + other.status()["instance"], text)
                self.assertIn(f":{self.first.port}", text)
                self.assertIn(text, one.daemon_log())
                self.assertIn("another sender publishes", " ".join(one.run("status").stdout.split()))

    def test_a_daemon_that_is_alone_hears_no_stranger_in_itself(self):
        with self.first as bench:
            self.assertEqual(bench.run("run", "bias", *SHORT).returncode, 0)
            self.assertEqual(bench.status()["notices"], [])

    def test_a_run_names_the_stranger_and_passes_its_messages_by(self):
        # Slowly: one that is at rest speaks once a second.
        self.first.config.write_text(self.first.config.read_text() + "[virtual]\npace = 20\n")
        with self.first, self.second:
            done = self.first.run("run", "bias", *SHORT)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("instance " + self.second.status()["instance"], " ".join(done.stdout.split()))

    def test_watch_marks_the_messages_of_the_one_that_is_not_its_benchs(self):
        with self.first, self.second:
            watch = subprocess.Popen([BIN / "gyrobench", "watch"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                     text=True, env={**os.environ, "GYROBENCH_CONFIG": str(self.first.config)})
            try:
                stranger = "STRANGER instance " + self.second.status()["instance"]
                while stranger not in watch.stdout.readline():
                    self.assertIsNone(watch.poll())
            finally:
                watch.terminate()
                watch.communicate(timeout=DEADLINE_S)


if __name__ == "__main__":
    unittest.main()
