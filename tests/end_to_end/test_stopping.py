"""What stops the stand: requests of any bytes, a stop beside a script that stalls, signals, a terminal that closes."""
import fcntl
import json
import os
import pty
import resource
import signal
import socket
import subprocess
import termios
import threading
import unittest

from bench import BIN, DEADLINE_S, Bench

HEAD = "procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }\nfunction run(p)\n"
LONG_TURN = HEAD + "bench.turn{ axis='inner', angle_deg=3000, rate_deg_s=3 }\nend\n"
# As many commands as may be: each is cheap, and all of them take the longest that a dry run may.
TALKATIVE = HEAD + "while true do bench.progress(0) end\nend\n"
# Fails in the run alone: no table stops at just the angle that it was told.
FAILS_LIVE = HEAD + ("local done = bench.turn{ axis='inner', angle_deg=5, rate_deg_s=5 }\n"
                     "if done.moved_deg ~= 5 then error('a\\xff') end\nend\n")
PACED = "[virtual]\npace = 20\n"


class Turning(unittest.TestCase):
    def start_turn(self, bench):
        self.assertEqual(bench.run("run", "turn", "--detach").returncode, 0)
        while not bench.status()["run"]["segment"].startswith("inner"):
            self.assertEqual(bench.status()["run"]["outcome"], "")

    def ended(self, bench):
        while not (outcome := bench.status()["run"]["outcome"]):
            self.assertIsNone(bench.daemon.poll())
        return outcome

    def closed(self, bench):
        """The record of a daemon that has ended."""
        return json.loads((bench.newest_record() / "run.json").read_text())


class Bytes(Turning):
    def test_bytes_that_are_no_text_neither_end_the_daemon_nor_its_run(self):
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}) as bench:
            self.start_turn(bench)
            for method, path, body in ((b"GET", b"/v1/\xff", b""), (b"GET", b"/v1/%ff", b""), (b"POST", b"/v1/check", b"\xff"),
                                       (b"POST", b"/v1/runs", b'{"procedure": "\xff"}'),
                                       (b"POST", b"/v1/check", b'{"procedure": "turn", "parameters": {"\xff": "\xff"}}'),
                                       (b"POST", b"/v1/answer", b'{"answer": "\xff"}')):
                answer = bench.ask(method, path, body)
                if answer is not None:
                    self.assertGreaterEqual(answer[0], 400)
                self.assertEqual(bench.status()["run"]["outcome"], "")
            status, answer = bench.ask(b"POST", b"/v1/stop", b"\xff")
            self.assertEqual((status, answer["state"]), (200, "stopping"))
            self.assertEqual(self.ended(bench), "aborted")

    def test_a_script_that_fails_with_such_bytes_is_told_and_recorded(self):
        dry = HEAD + "error('a\\xff')\nend\n"
        with Bench(procedures={"dry": dry, "live": FAILS_LIVE}) as bench:
            for command in ("check", "run"):
                done = bench.run(command, "dry")
                self.assertGreater(done.returncode, 0)
                self.assertIn("dry.lua:3: a\N{REPLACEMENT CHARACTER}", done.stdout + done.stderr)
            done = bench.run("run", "live")
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertIn("live.lua:4: a\N{REPLACEMENT CHARACTER}", bench.status()["run"]["message"])
            run = self.closed(bench)
            self.assertEqual(run["outcome"], "error")
            self.assertIn("live.lua:4: a\N{REPLACEMENT CHARACTER}", run["message"])

    def test_such_bytes_of_the_command_line_are_refused_by_the_program(self):
        with Bench() as bench:
            for arguments in (["run", b"\xff"], ["check", "scale", "-p", b"turns=\xff"], ["answer", b"\xff"],
                              ["analyze", b"\xff"], ["run", "scale", "-p", b"\xff=1"]):
                done = subprocess.run([BIN / "gyrobench", *arguments], capture_output=True, timeout=DEADLINE_S,
                                      env={**os.environ, "GYROBENCH_CONFIG": str(bench.config)})
                self.assertGreater(done.returncode, 0, arguments)
                self.assertTrue(done.stderr, arguments)
            self.assertEqual(bench.status()["state"], "idle")


class BesideADryRun(Turning):
    def stall(self, bench):
        """A dry run under way. Its end is the event."""
        answered = threading.Event()

        def check():
            bench.ask(b"POST", b"/v1/check", b'{"procedure": "talkative"}')
            answered.set()

        threading.Thread(target=check, daemon=True).start()
        return answered

    def test_a_stop_and_all_that_steers_pass_by_a_script_that_stalls(self):
        with Bench(extra=PACED, procedures={"turn": LONG_TURN, "talkative": TALKATIVE}) as bench:
            self.start_turn(bench)
            stalled = self.stall(bench)
            self.assertEqual(bench.ask(b"POST", b"/v1/stop")[0], 200)
            self.assertEqual(self.ended(bench), "aborted")
            self.assertFalse(stalled.is_set())
            # The next request of the same kind waits behind it; one that starts a run does not.
            self.start_turn(bench)
            # The end of the daemon does not wait for it either.
            bench.daemon.send_signal(signal.SIGTERM)
            self.assertEqual(bench.daemon.wait(DEADLINE_S), 0)
            self.assertEqual(self.closed(bench)["outcome"], "aborted")

    def test_a_run_that_is_asked_for_before_a_stop_does_not_begin_after_it(self):
        with Bench(procedures={"talkative": TALKATIVE}) as bench:
            answers = []
            asking = threading.Thread(
                target=lambda: answers.append(bench.ask(b"POST", b"/v1/runs", b'{"procedure": "talkative"}')))
            asking.start()
            while not answers:
                bench.ask(b"POST", b"/v1/stop")
            asking.join()
            self.assertEqual(answers[0][0], 409, answers)
            self.assertIn("nothing has moved", answers[0][1]["error"]["message"])
            self.assertIsNone(bench.status()["run"])

    def test_a_pipe_in_place_of_a_script_is_named_and_waited_for_by_nobody(self):
        with Bench(procedures={}) as bench:
            os.mkfifo(bench.procedures / "x.lua")
            problems = {one["name"]: one["problem"] for one in bench.json("procedures")["procedures"]}
            self.assertIn("expected a file", problems["x"])
            self.assertIn("expected a file", bench.run("check", "x").stderr)


class Crowd(Turning):
    def test_of_connections_that_say_nothing_neither_ends_a_run_nor_keeps_a_stop_out(self):
        few = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (160, 160))
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}, before_start=few) as bench:
            self.start_turn(bench)
            crowd = []
            for _ in range(400):
                crowd.append(socket.socket(socket.AF_UNIX))
                crowd[-1].connect(str(bench.folder / "control.sock"))
            # Not only once they have been silent for 10 s, and are dropped for that.
            self.assertEqual(bench.ask(b"POST", b"/v1/stop", timeout_s=5)[0], 200)
            self.assertEqual(self.ended(bench), "aborted")
            self.assertTrue((bench.newest_record() / "result.json").exists())
            for connection in crowd:
                connection.close()


def own_terminal():
    """A terminal that the daemon shall be started in, and what it does before it starts."""
    master, slave = pty.openpty()

    def enter():
        os.setsid()
        fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
        os.close(master)

    return master, slave, enter


def full_pipe():
    """The end for writing of a pipe that takes no more, and that for reading, which nobody reads."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    try:
        while os.write(writing, bytes(4096)):
            pass
    except BlockingIOError:
        os.set_blocking(writing, True)
    return reading, writing


class ALogThatNobodyReads(Turning):
    def test_holds_up_neither_a_stop_nor_the_end(self):
        reading, writing = full_pipe()
        into_it = lambda: os.dup2(writing, 2)
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}, before_start=into_it) as bench:
            self.start_turn(bench)
            self.assertEqual(bench.ask(b"POST", b"/v1/stop")[0], 200)
            self.assertEqual(self.ended(bench), "aborted")
            self.start_turn(bench)
            bench.daemon.send_signal(signal.SIGTERM)
            self.assertEqual(bench.daemon.wait(DEADLINE_S), 0)
            self.assertEqual(self.closed(bench)["outcome"], "aborted")
        os.close(reading)
        os.close(writing)

    def test_holds_up_no_stop_that_the_bench_makes_by_itself(self):
        reading, writing = full_pipe()
        into_it = lambda: os.dup2(writing, 2)
        alarm = ('include = "{root}/config/scenarios/typical.toml"\n'
                 '[[fault]]\ndevice = "inner.drive"\nkind = "alarm"\namount = 14\non = "move"\nat_s = 2\n')
        with Bench(extra=PACED, scenario=alarm, procedures={"turn": LONG_TURN}, before_start=into_it) as bench:
            self.start_turn(bench)
            self.assertEqual(self.ended(bench), "fault")
            self.assertIn("alarm 14", bench.status()["run"]["message"])
        os.close(reading)
        os.close(writing)


class Signals(Turning):
    def check_ends_in_order(self, bench):
        self.assertEqual(bench.daemon.wait(DEADLINE_S), 0, bench.daemon_log())
        self.assertIn("stopped", bench.daemon_log())
        run = self.closed(bench)
        self.assertEqual(run["outcome"], "aborted")
        self.assertIn("the daemon was told to end", run["message"])
        self.assertTrue((bench.newest_record() / "result.json").exists())

    def test_signals_that_end_end_in_order(self):
        for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT, signal.SIGQUIT):
            with self.subTest(number), Bench(extra=PACED, procedures={"turn": LONG_TURN}) as bench:
                self.start_turn(bench)
                bench.daemon.send_signal(number)
                self.check_ends_in_order(bench)

    def test_a_second_signal_changes_nothing(self):
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}) as bench:
            self.start_turn(bench)
            for number in (signal.SIGINT, signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                bench.daemon.send_signal(number)
            self.check_ends_in_order(bench)

    def test_a_terminal_that_closes_ends_the_run_in_order(self):
        master, slave, enter = own_terminal()
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}, before_start=enter) as bench:
            os.close(slave)
            self.start_turn(bench)
            os.close(master)
            self.check_ends_in_order(bench)

    def test_who_wants_it_to_outlive_its_terminal_starts_it_so(self):
        ignore = lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}, before_start=ignore) as bench:
            self.start_turn(bench)
            bench.daemon.send_signal(signal.SIGHUP)
            self.assertEqual(bench.status()["run"]["outcome"], "")

    def test_other_signals_change_nothing(self):
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}) as bench:
            self.start_turn(bench)
            for number in (signal.SIGUSR1, signal.SIGUSR2, signal.SIGPIPE, signal.SIGALRM, signal.SIGTSTP, signal.SIGIO):
                bench.daemon.send_signal(number)
                self.assertEqual(bench.status()["run"]["outcome"], "", number)
            bench.ask(b"POST", b"/v1/stop")
            self.assertEqual(self.ended(bench), "aborted")


if __name__ == "__main__":
    unittest.main()
