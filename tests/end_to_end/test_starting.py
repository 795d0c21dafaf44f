"""What a daemon finds at its start: another one, an axis that moves, an output that is on, a record that nobody closed."""
import ctypes
import json
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import threading
import time
import unittest

from bench import BIN, DEADLINE_S, Bench
from outside_stand import OutsideStand

HEAD = "procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }\nfunction run(p)\n"
LONG_TURN = HEAD + "bench.turn{ axis='inner', angle_deg=3000, rate_deg_s=3 }\nend\n"
SHORT_REST = HEAD + "bench.rest{ duration_s=1 }\nend\n"
PACED = "[virtual]\npace = 20\n"


def start_second(config):
    """A second daemon, which is to end by itself."""
    return subprocess.run([BIN / "gyrobenchd", "--config", config], capture_output=True, text=True, timeout=DEADLINE_S)


class TheNextRun(unittest.TestCase):
    def test_may_be_started_by_whoever_sees_the_end_of_the_one_before(self):
        # The end was shown a moment before there was room for another run: one start of four was refused.
        with Bench(procedures={"short": SHORT_REST}) as bench:
            for _ in range(30):
                code, answer = bench.ask(b"POST", b"/v1/runs", b'{"procedure": "short"}')
                self.assertLess(code, 300, answer)
                while not bench.status()["run"].get("outcome"):
                    pass


class AnotherDaemon(unittest.TestCase):
    def check_refused(self, bench, second, what):
        self.assertEqual(second.returncode, 1, second.stderr)
        for word in (what, "in use by gyrobenchd", f"process {bench.daemon.pid}", f"{bench.folder}/control.sock"):
            self.assertIn(word, second.stderr)
        self.assertIsNone(bench.daemon.poll())

    def test_of_the_same_stand_file_is_refused_and_switches_nothing(self):
        with OutsideStand() as bench:
            bench.start()
            before = bench.status()["utime"]
            self.check_refused(bench, start_second(bench.config), "bus a")
            status = bench.status()
            self.assertGreater(status["utime"], before)
            self.assertTrue(all(device["ok"] for device in status["devices"]), status["devices"])

    def test_of_another_stand_file_on_the_same_line_is_refused(self):
        with OutsideStand() as bench:
            bench.start()
            # By another name of the line.
            os.symlink(bench.folder / "bus-a", bench.folder / "other-name")
            other = bench.folder / "other.toml"
            other.write_text(bench.config.read_text().replace("records =", "records = 'other' #")
                             .replace(f"{bench.folder}/control.sock", f"{bench.folder}/other.sock")
                             .replace(f"{bench.folder}/bus-a", f"{bench.folder}/other-name"))
            self.check_refused(bench, start_second(other), "bus a")
            self.assertFalse((bench.folder / "other.sock").exists())

    def test_with_the_same_records_or_socket_is_refused(self):
        with Bench() as bench:
            text = bench.config.read_text()
            other = bench.folder / "other.toml"
            other.write_text(text.replace(f"{bench.folder}/control.sock", f"{bench.folder}/other.sock"))
            self.check_refused(bench, start_second(other), "folder of records")
            other.write_text(text.replace(f'records = "{bench.records}"', "records = 'other'"))
            self.check_refused(bench, start_second(other), "control socket")

    def test_that_was_killed_is_in_nobodys_way(self):
        with Bench() as bench:
            bench.daemon.kill()
            bench.daemon.wait(DEADLINE_S)
            bench.start()

    def test_a_file_in_place_of_the_socket_is_left_alone(self):
        with Bench(start=False) as bench:
            (bench.folder / "control.sock").write_text("somebody's")
            second = start_second(bench.config)
            self.assertEqual(second.returncode, 1)
            self.assertIn("something else than a socket", second.stderr)
            self.assertEqual((bench.folder / "control.sock").read_text(), "somebody's")


class Found(unittest.TestCase):
    def test_an_axis_that_moves_is_stopped_and_an_output_that_is_on_is_off(self):
        with OutsideStand() as bench:
            bench.heat()
            bench.move_inner(angle_deg=900, rpm=60)  # 9 deg/s of the table
            self.assertTrue(bench.inner_is_moving())
            bench.start()
            status = bench.status()
            notices = [notice["text"] for notice in status["notices"]]
            self.assertEqual(len(notices), 1, notices)
            for word in ("axis.inner", "was moving", "stopped"):
                self.assertIn(word, notices[0])
                self.assertIn(word, bench.daemon_log())
            self.assertIn(notices[0][:40], bench.run("status").stdout)
            inner = [axis for axis in status["axes"] if axis["name"] == "inner"][0]
            self.assertLess(inner["commanded_deg"], 800)
            self.assertAlmostEqual(inner["commanded_deg"], inner["reference_deg"], delta=5)
            bench.run("reset")
            self.assertEqual(bench.status()["notices"], [])
            bench.stop()
            # In the stand's own truth.
            self.assertFalse(bench.inner_is_moving())
            self.assertLess(bench.inner_deg(), 800)
            self.assertFalse(bench.heats())

    def test_an_axis_that_moves_waits_for_no_record_that_nobody_closed(self):
        with OutsideStand() as bench:
            bench.move_inner(angle_deg=900, rpm=60)
            record = bench.records / "20260101-000000-turn"
            record.mkdir(parents=True)
            (record / "run.json").write_text('{"outcome": "running"}')
            os.mkfifo(record / "events.lcmlog")  # takes until somebody writes it
            starting = threading.Thread(target=bench.start)
            starting.start()
            try:
                deadline = time.monotonic() + DEADLINE_S
                log = bench.folder / "daemon.log"
                while not (log.exists() and "was moving" in log.read_text()) and time.monotonic() < deadline:
                    bench.run("status")  # a process, so no busy loop
                self.assertIn("axis.inner: the drive was moving when it was opened: stopped", bench.daemon_log())
            finally:
                os.close(os.open(record / "events.lcmlog", os.O_WRONLY))
                starting.join()
            self.assertEqual(json.loads((record / "run.json").read_text())["outcome"], "interrupted")

    def test_a_run_whose_daemon_was_killed_is_closed_as_interrupted(self):
        script = LONG_TURN.replace("bench.turn", "bench.rest{ duration_s=30 } bench.turn")
        with Bench(extra=PACED, procedures={"turn": script}) as bench:
            self.assertEqual(bench.run("run", "turn", "--detach").returncode, 0)
            while not bench.status()["run"]["segment"].startswith("inner"):
                self.assertIsNone(bench.daemon.poll())
            begin = bench.status()["run"]["elapsed_s"]
            while bench.status()["run"]["elapsed_s"] < begin + 30:  # its log is synced once a second
                self.assertIsNone(bench.daemon.poll())
            run_id = bench.status()["run"]["run_id"]
            self.assertRegex(bench.run("runs").stdout, f"{run_id} .* running *\\n")
            bench.daemon.kill()
            bench.daemon.wait(DEADLINE_S)
            record = bench.newest_record()
            gone = "interrupted (its daemon is gone; the next start closes it)"
            self.assertIn(gone, bench.run("runs").stdout)
            self.assertIn(gone, " ".join(bench.run("show", record).stdout.split()))
            self.assertEqual(bench.json("runs")["runs"][0]["outcome"], "interrupted")
            self.assertEqual(json.loads((record / "run.json").read_text())["outcome"], "running")
            bench.start()
            run = json.loads((record / "run.json").read_text())
            self.assertEqual(run["outcome"], "interrupted")
            self.assertNotIn("its daemon is gone", bench.run("runs").stdout)
            self.assertGreater(run["end_utime"], run["start_utime"])
            self.assertIn(run_id, bench.daemon_log())
            self.assertEqual(bench.run("analyze", record).returncode, 0)
            # Nothing moves until somebody has said that he knows; no new start does so in his place.
            for _ in range(2):
                status = bench.status()
                self.assertIn(run_id, status["notices"][0]["text"])
                self.assertEqual(status["state"], "fault")
                self.assertIn(run_id, status["fault"]["message"])
                self.assertRegex(status["fault"]["message"], r"axis\.inner stands at -?[\d.]+ deg")
                self.assertIn("The virtual stand begins anew", status["fault"]["message"])
                self.assertNotIn("moved by", status["fault"]["message"])
                self.assertIn("axis.inner: at", "\n".join(status["fault"]["left"]))
                refused = bench.run("run", "turn")
                self.assertEqual(refused.returncode, 1)
                self.assertIn("gyrobench reset", refused.stderr)
                bench.stop()
                bench.start()
            self.assertEqual(bench.run("reset").returncode, 0)
            self.assertEqual(bench.status()["state"], "idle")
            self.assertEqual(bench.run("run", "turn", "--detach").returncode, 0)
            bench.run("stop")
            # Once is enough.
            bench.stop()
            bench.start()
            self.assertEqual(bench.status()["notices"], [])


class Resumed(unittest.TestCase):
    TURNS = ("scale", "-p", "turns=6", "-p", "initial_rest_s=8")

    def kill_within(self, bench, arguments, commands):
        """Id and record of a run whose daemon is killed once so many of its commands are on disk as over."""
        started = bench.json("run", *arguments, "--detach")
        record = pathlib.Path(started["record"])
        log = record / "events.lcmlog"
        while not log.exists() or log.read_bytes().count(b'"elapsed_s":') < commands:
            self.assertEqual(bench.status()["run"]["outcome"], "")
        bench.daemon.kill()
        bench.daemon.wait(DEADLINE_S)
        bench.start()
        return started["run_id"], record

    def scale_of(self, record):
        (scale,) = json.loads((record / "result.json").read_text())["scale"]
        return scale["alpha"], scale["alpha_std_error"], scale["turns"]

    def test_a_run_whose_daemon_was_killed_goes_on_and_gives_what_it_would_have(self):
        with Bench(extra=PACED.replace("20", "40")) as bench:
            self.assertEqual(bench.run("run", *self.TURNS).returncode, 0)
            alpha, error, turns = self.scale_of(bench.newest_record())
            run_id, record = self.kill_within(bench, self.TURNS, 7)
            before_reset = bench.run("resume", "latest")
            self.assertEqual(before_reset.returncode, 1)
            self.assertIn(run_id, before_reset.stderr)
            self.assertIn("gyrobench reset", before_reset.stderr)
            self.assertEqual(bench.run("reset").returncode, 0)
            resumed = pathlib.Path(bench.json("resume", "latest")["record"])
            run = json.loads((resumed / "run.json").read_text())
            self.assertEqual((run["outcome"], run["resumed_from"]), ("done", run_id))
            self.assertEqual(json.loads((record / "run.json").read_text())["resumed_by"], run["run_id"])
            self.assertEqual(run["start_utime"], json.loads((record / "run.json").read_text())["start_utime"])
            again, its_error, its_turns = self.scale_of(resumed)
            self.assertEqual(its_turns, turns)
            self.assertLess(abs(again - alpha), 4 * (error**2 + its_error**2)**0.5)
            # From the record alone the same comes out, and the gap is said.
            analysis = bench.json("analyze", resumed)
            self.assertEqual(analysis["scale"][0]["alpha"], again)
            self.assertIn("taken_up", [defect["kind"] for defect in analysis["defects"]])
            twice = bench.run("resume", run_id)
            self.assertEqual(twice.returncode, 1)
            self.assertIn(f"taken up already, by run {run['run_id']}", twice.stderr)
            self.assertIn(f"run {run_id} was taken up already", bench.run("resume", "latest").stderr)

    def test_what_cannot_go_on_is_refused_with_the_reason(self):
        own = HEAD.replace("measures", "resumable = true, measures") + "for i = 1, 9 do bench.rest{ duration_s=10 } end\nend\n"
        with Bench(extra=PACED, procedures={"rests": own}) as bench:
            for command, commands, reason in ((("bias",), 0, "without a break"), (("rests",), 0, "none of its commands was over"),
                                              (("rests",), 3, "the script of rests is not the one that it ran")):
                run_id, _ = self.kill_within(bench, command, commands)
                bench.run("reset")
                if commands == 3:
                    (bench.procedures / "rests.lua").write_text(own.replace("10", "11"))
                refused = bench.run("resume", run_id)
                self.assertEqual(refused.returncode, 1)
                self.assertIn(reason, refused.stderr)
            unknown = bench.run("resume", "20200101-000000-scale")
            self.assertEqual(unknown.returncode, 1)
            self.assertIn("there is no run", unknown.stderr)
            self.assertEqual(bench.status()["state"], "idle")


class ThreadsThatHang:
    """Within it, every thread of the process stands still but the first and the one that writes the log (ptrace(2), which
    takes one thread at a time)."""
    SEIZE, INTERRUPT, DETACH, WALL = 0x4206, 0x4207, 17, 0x40000000

    def __init__(self, process):
        tasks = pathlib.Path(f"/proc/{process}/task")
        self.threads = [int(task.name) for task in tasks.iterdir()
                        if int(task.name) != process and (task / "comm").read_text() != "log\n"]

    @classmethod
    def ask(cls, request, thread):
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.ptrace(ctypes.c_long(request), ctypes.c_long(thread), None, None) != 0:
            raise OSError(ctypes.get_errno(), "this machine lets no test hold a thread of its own child (ptrace)")

    def __enter__(self):
        for thread in self.threads:
            self.ask(self.SEIZE, thread)
            self.ask(self.INTERRUPT, thread)
            os.waitpid(thread, self.WALL)
        return self

    def __exit__(self, *_):
        for thread in self.threads:
            self.ask(self.DETACH, thread)


class Watchdog(unittest.TestCase):
    def test_the_service_manager_is_told_that_the_daemon_lives_for_as_long_as_its_threads_do(self):
        with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.bind(f"{folder}/notify")
            os.environ.update(NOTIFY_SOCKET=f"{folder}/notify", WATCHDOG_USEC="300000")
            try:
                with Bench() as bench:
                    self.assertIn("READY=1", self.told_until_fed(manager, bench))
                    with ThreadsThatHang(bench.daemon.pid):
                        self.await_log(manager, bench, "the thread of connections has been at one thing for")
                        # Before it is said, it is fed no more; what it was fed until then waits in the socket.
                        while self.told(manager, 0):
                            pass
                        self.assertIsNone(self.told(manager, 3), "fed while its threads hang")
                    self.told_until_fed(manager, bench)
            finally:
                del os.environ["NOTIFY_SOCKET"], os.environ["WATCHDOG_USEC"]

    @staticmethod
    def told(manager, patience_s):
        manager.settimeout(patience_s)
        try:
            return manager.recv(1000).decode()
        except (TimeoutError, BlockingIOError):
            return None

    def told_until_fed(self, manager, bench):
        told = []
        while told.count("WATCHDOG=1") < 3:
            self.assertIsNone(bench.daemon.poll())
            told.append(self.told(manager, DEADLINE_S))
            self.assertIsNotNone(told[-1])
        return told

    def await_log(self, manager, bench, words):
        deadline = time.monotonic() + DEADLINE_S
        while words not in bench.daemon_log():
            self.assertIsNone(bench.daemon.poll())
            self.assertLess(time.monotonic(), deadline, bench.daemon_log())
            self.told(manager, 1)  # the daemon waits for a manager that does not listen


class RecordsThatVanish(unittest.TestCase):
    def test_during_a_run_make_it_a_fault(self):
        with Bench(extra=PACED, procedures={"turn": LONG_TURN}) as bench:
            self.assertEqual(bench.run("run", "turn", "--detach").returncode, 0)
            while not bench.status()["run"]["segment"].startswith("inner"):
                self.assertIsNone(bench.daemon.poll())
            shutil.rmtree(bench.records)
            while not (run := bench.status()["run"])["outcome"]:
                self.assertIsNone(bench.daemon.poll())
            self.assertEqual(run["outcome"], "fault")
            self.assertIn("events.lcmlog: was removed", run["message"])

    def test_just_before_its_end_make_it_a_fault(self):
        short = HEAD + "bench.rest{ duration_s=5 }\nend\n"
        with Bench(procedures={"short": short}, extra="[virtual]\npace = 2\n") as bench:
            running = subprocess.Popen([BIN / "gyrobench", "run", "short"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                       env={**os.environ, "GYROBENCH_CONFIG": str(bench.config)}, text=True)
            while not (run := bench.status()["run"]) or not run["segment"].startswith("5 s"):
                self.assertIsNone(bench.daemon.poll())
            shutil.rmtree(bench.records)
            out, err = running.communicate(timeout=DEADLINE_S)
            self.assertEqual(running.returncode, 1, out + err)
            self.assertIn("fault", out + err)


if __name__ == "__main__":
    unittest.main()
