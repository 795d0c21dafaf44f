"""The main job as a user does it: start the daemon, run procedures by name, read the results."""
import json
import math
import signal
import subprocess
import unittest

from bench import BIN, DEADLINE_S, Bench, have_multicast

SHORT_SCALE = ["run", "scale", "-p", "turns=4", "-p", "rest_s=1", "-p", "initial_rest_s=5"]


class MainJob(unittest.TestCase):
    def test_scale_gives_a_result_that_its_record_and_its_table_reproduce(self):
        # The sensor lies on its side: the inner axis turns its y axis.
        with Bench(extra="[geometry]\nmount_x_deg = 90\n",
                   scenario='include = "{root}/config/scenarios/typical.toml"\n'
                            "[site]\nmount_deg = [90, 0, 0]\n") as bench:
            done = bench.run(*SHORT_SCALE)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            record = bench.newest_record()
            result = json.loads((record / "result.json").read_text())
            self.assertEqual(json.loads((record / "run.json").read_text())["outcome"], "done")
            self.assertEqual([scale["axis"] for scale in result["scale"]], ["y"])
            scale = result["scale"][0]
            self.assertGreater(scale["turns"], 7)
            self.assertLess(abs(scale["scale_error"]), 0.05)
            self.assertGreater(scale["alpha_std_error"], 0)

            # To the last digit: the same text.
            analysed = bench.json("analyze", record)
            analysed = analysed[0] if isinstance(analysed, list) else analysed
            self.assertEqual(json.dumps(analysed["scale"]), json.dumps(result["scale"]))
            self.assertEqual(json.dumps(analysed["bias"]), json.dumps(result["bias"]))

            table = bench.folder / "run.csv.gz"
            self.assertEqual(bench.run("export", record.name, "-o", table).returncode, 0)
            from_table = bench.json("analyze", table)
            from_table = from_table[0] if isinstance(from_table, list) else from_table
            self.assertAlmostEqual(from_table["scale"][0]["alpha"] / scale["alpha"], 1, delta=1e-7)

    def test_the_references_certificate_goes_from_stand_file_to_record_table_and_analysis(self):
        u = 0.003
        with Bench(extra=f"[reference]\nscale_uncertainty = {u}\n") as bench:
            self.assertEqual(bench.run(*SHORT_SCALE).returncode, 0)
            record, table = bench.newest_record(), bench.folder / "run.csv"
            self.assertEqual(bench.run("export", record.name, "-o", table).returncode, 0)
            self.assertIn(f"# ref_scale_uncertainty = {u}", table.read_text().splitlines())
            live = json.loads((record / "result.json").read_text())["scale"][0]
            for source in (record, table):
                scale = bench.json("analyze", source)["scale"][0]
                expected = math.hypot(scale["alpha_statistical_std_error"], u * scale["alpha"])
                self.assertAlmostEqual(scale["alpha_std_error"] / expected, 1, delta=1e-9)
                self.assertAlmostEqual(scale["alpha_std_error"] / live["alpha_std_error"], 1,
                                       delta=1e-6)

    def test_a_run_ends_with_its_trace_and_report_which_the_record_reproduces(self):
        with Bench() as bench:
            done = bench.run(*SHORT_SCALE)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("Trace\n", done.stdout)
            record = bench.newest_record()
            trace = json.loads((record / "trace.json").read_text())
            self.assertEqual(trace["format"], "gyrobench.trace/1")
            self.assertEqual(json.dumps(bench.json("trace", record)["channels"]), json.dumps(trace["channels"]))
            for channel in trace["channels"]:
                self.assertIn(f"gyro {channel['gyro']}: ", bench.run("show", "latest").stdout)
            first = (record / "report.html").read_text()
            self.assertIn(record.name, first)
            (record / "report.html").unlink()
            self.assertEqual(bench.run("report", "latest").returncode, 0)
            self.assertIn(record.name, (record / "report.html").read_text())

    def test_a_record_is_calibrated_and_applied_like_a_table(self):
        with Bench() as bench:
            bench.run(*SHORT_SCALE)
            record, calibration = bench.newest_record(), bench.folder / "cal.json"
            self.assertEqual(bench.run("trace", record, "-q", "--calibration", calibration).returncode, 0)
            files = {i["file"] for i in json.loads(calibration.read_text())["inputs"]}
            self.assertEqual(files, {f"{record.name}/events.lcmlog", f"{record.name}/run.json"})
            out = bench.folder / "out.csv"
            summary = bench.json("apply", calibration, record, "-o", out)
            lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
            self.assertEqual(len(lines) - 1, summary["rows"])
            self.assertIn("gyro_z_deg_s", lines[0])
            self.assertEqual([f.name for f in bench.folder.glob("out.csv*")], ["out.csv"])

    def test_a_procedure_may_ask_for_a_trace_on_its_way(self):
        with Bench() as bench:
            scripts = bench.folder / "procedures"
            scripts.mkdir()
            (scripts / "asking.lua").write_text(
                "procedure = { summary = 'asks', measures = { 'scale' } }\n"
                "function run(p)\n"
                "  bench.rest{ duration_s = 5 }\n"
                "  for _, turns in ipairs{ 2, -2, 1, -1 } do\n"
                "    bench.turn{ axis = 'inner', shaft_turns = turns, rate_deg_s = 15 }\n"
                "    bench.rest{ duration_s = 2 }\n"
                "  end\n"
                "  bench.say('verdict ' .. bench.trace().z.verdict)\n"
                "end\n")
            bench.stop()
            bench.config.write_text(f'procedures = ["{scripts}"]\n' + bench.config.read_text())
            bench.start()
            done = bench.run("run", "asking")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            log = (bench.newest_record() / "events.lcmlog").read_bytes()
            self.assertRegex(log, rb"verdict (none|explained|partly_explained|unexplained)")

    def test_bias_asks_the_operator_and_fits_a_curve(self):
        with Bench() as bench:
            done = bench.run("run", "bias", "-p", "max_duration_s=900")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            result = json.loads((bench.newest_record() / "result.json").read_text())
            self.assertEqual(len(result["bias"]), 3)
            for bias in result["bias"]:
                self.assertGreater(bias["max_temperature_degC"], bias["min_temperature_degC"] + 5)
                self.assertGreater(len(bias["coefficients"]), 1)

    def test_the_procedures_that_move_all_axes_run_to_their_end(self):
        runs = [["poses", "-p", "poses=6", "-p", "rest_s=3", "-p", "initial_rest_s=5"],
                ["rates", "-p", "rates_deg_s=20,40", "-p", "angle_deg=60", "-p", "initial_rest_s=5"],
                ["sweep", "-p", "frequencies_hz=0.4,0.8", "-p", "duration_s=5", "-p", "initial_rest_s=5"],
                ["thermal", "-p", "warm_up_s=20", "-p", "cooling_s=90", "-p", "rewarming_s=90"]]
        with Bench() as bench:
            for arguments in runs:
                with self.subTest(procedure=arguments[0]):
                    self.check_runs_as_planned(bench, arguments)

    def test_the_full_sequence_adapts_to_a_one_axis_table(self):
        with Bench(base="one-axis.toml") as bench:
            self.check_runs_as_planned(bench, ["full", "-p", "warm_up_s=5", "-p", "fan=false"])

    def check_runs_as_planned(self, bench, arguments):
        planned_s = bench.json("check", *arguments)["duration_s"]
        done = bench.run("run", *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        run = json.loads((bench.newest_record() / "run.json").read_text())
        self.assertEqual(run["outcome"], "done")
        # Bench time: each move takes some moments that no plan knows.
        taken_s = (run["end_utime"] - run["start_utime"]) * 1e-6
        self.assertGreater(taken_s, 0.95 * planned_s)
        self.assertLess(taken_s, 1.35 * planned_s + 5)

    def test_a_one_axis_table_refuses_what_it_cannot_do_before_motion(self):
        with Bench(base="one-axis.toml") as bench:
            done = bench.run("run", "poses")
            self.assertEqual(done.returncode, 1)
            self.assertIn("the stand has no outer and no middle axis", done.stderr + done.stdout)
            self.assertFalse(bench.records.exists() and list(bench.records.iterdir()))
            checked = bench.run("check", "rates")
            self.assertEqual(checked.returncode, 0, checked.stderr)
            self.assertIn("note: left out, turning with +x up", checked.stdout)

    def samples_of_two_runs(self, requests_before_each):
        """The tables of two runs of one daemon, before each of which it answers so many requests."""
        tables = []
        with Bench() as bench:
            for number in (1, 2):
                for _ in range(requests_before_each):
                    self.assertTrue(bench.json("status")["time_stands_still"])
                self.assertEqual(bench.run(*SHORT_SCALE).returncode, 0)
                table = bench.folder / f"run{number}.csv"
                self.assertEqual(bench.run("export", "latest", "-o", table).returncode, 0)
                tables.append([line for line in table.read_text().splitlines() if not line.startswith("#")])
        return tables

    # A finding can be gone back to only if nothing but stand file, seed and commands is in a record.
    def test_the_same_seed_and_commands_give_the_same_samples_however_long_the_daemon_idled(self):
        at_once = self.samples_of_two_runs(requests_before_each=0)
        later = self.samples_of_two_runs(requests_before_each=150)
        self.assertGreater(len(at_once[0]), 1000)
        self.assertNotEqual(at_once[0], at_once[1])
        for one, other in zip(at_once, later):
            self.assertEqual(len(one), len(other))
            # The first line that differs, not a megabyte of them.
            self.assertIsNone(next(((i, a, b) for i, (a, b) in enumerate(zip(one, other)) if a != b), None))

    def test_a_stop_between_runs_is_carried_out_while_time_stands_still(self):
        with Bench() as bench:
            before = bench.json("status")["utime"]
            self.assertEqual(bench.run("stop").returncode, 0)
            self.assertEqual(bench.run(*SHORT_SCALE).returncode, 0)
            self.assertLess(before, bench.json("status")["utime"])
            self.assertTrue(all(device["ok"] for device in bench.json("status")["devices"]))

    def test_the_record_does_not_know_the_truth_of_the_simulation(self):
        with Bench() as bench:
            bench.run(*SHORT_SCALE)
            text = (bench.newest_record() / "run.json").read_text()
            self.assertNotIn("scenario", text)
            self.assertNotIn("seed", text)

    @unittest.skipUnless(have_multicast(), "no multicast route on this machine")
    def test_another_process_receives_every_result_and_loses_no_live_message(self):
        with Bench() as bench:
            with subprocess.Popen([BIN / "gyrobench", "--config", bench.config, "watch", "--json",
                                   "--data", "--until-stop"], stdout=subprocess.PIPE, text=True) as watch:
                # The subscriber is there once it has shown a status.
                lines = [watch.stdout.readline()]
                bench.run(*SHORT_SCALE)
                lines += watch.communicate(timeout=DEADLINE_S)[0].splitlines()
            messages = [json.loads(line) for line in lines if line.strip()]
            scales = [m for m in messages if m["channel"] == "SCALE_RESULT"]
            segments = [m for m in messages if m.get("event") == "segment_end"]
            self.assertGreater(len(segments), 8)
            self.assertGreater(len(scales), len(segments) / 2)
            traces = [m for m in messages if m["channel"] == "TRACE_RESULT"]
            verdicts = [m for m in traces if m["effect_index"] == -1]
            self.assertTrue(verdicts)
            self.assertEqual(len(traces), sum(1 + m["effect_count"] for m in verdicts))
            kept = json.loads((bench.newest_record() / "trace.json").read_text())["channels"]
            self.assertEqual([(m["sensor_axis"], m["verdict"]) for m in verdicts],
                             [(c["gyro"], c["verdict"]) for c in kept])
            for channel in {m["channel"] for m in messages}:
                numbers = [m["seq"] for m in messages if m["channel"] == channel]
                self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))), channel)


    def test_the_three_axes_are_sent_as_one_once_all_were_turned(self):
        with Bench() as bench:
            # To a file: a run of minutes says more than a pipe holds while nobody reads it.
            heard = bench.folder / "heard.json"
            with heard.open("w") as out, subprocess.Popen(
                    [BIN / "gyrobench", "--config", bench.config, "watch", "--json", "--until-stop"], stdout=out) as watch:
                self.assertEqual(bench.run("run", "poses").returncode, 0)
                watch.wait(DEADLINE_S)
            messages = [json.loads(line) for line in heard.read_text().splitlines()]
            model, = [m for m in messages if m["channel"] == "MODEL_RESULT"]
            self.assertTrue(model["final"])
            kept = json.loads((bench.newest_record() / "trace.json").read_text())
            self.assertEqual(model["a_deg_s_per_lsb"], kept["vector"]["matrix"]["a"])
            for axis, row in enumerate(model["a_deg_s_per_lsb"]):
                self.assertAlmostEqual(row[axis] * 131.0, 1.0, delta=0.05)


class BadInput(unittest.TestCase):
    def check_refused(self, bench, status, words, *arguments):
        for command in ("check", "run"):
            done = bench.run(command, *arguments)
            self.assertEqual(done.returncode, status, done.stderr + done.stdout)
            for word in words:
                self.assertIn(word, done.stderr + done.stdout)
        self.assertFalse(bench.records.exists() and list(bench.records.iterdir()),
                         "refused before anything moves, so there is no record")

    def test_a_folder_of_procedures_that_is_not_there_is_named_before_the_daemon_starts(self):
        with Bench() as bench:
            moved = bench.folder / "moved.toml"
            moved.write_text('procedures = ["nowhere"]\n' + bench.config.read_text())
            done = subprocess.run([BIN / "gyrobenchd", "--config", moved, "--check"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertIn("nowhere: no such folder", done.stderr)

    def test_records_that_cannot_be_kept_are_refused_by_the_check_and_said_at_the_start(self):
        with Bench(start=False) as bench:
            text = bench.config.read_text()
            (bench.folder / "file").write_text("in the way")
            # As root nothing but the kernel refuses to write.
            for place, cause in ((bench.folder / "file" / "records", "Not a directory"), ("/proc/records", "/proc cannot be")):
                bench.config.write_text(text.replace(str(bench.records), str(place)))
                check = subprocess.run([BIN / "gyrobenchd", "--config", bench.config, "--check"],
                                       capture_output=True, text=True, timeout=DEADLINE_S)
                self.assertEqual(check.returncode, 1)
                # What moves on the stand has to be seen to: the daemon starts, and no run begins.
                bench.start()
                done = bench.run(*SHORT_SCALE)
                self.assertEqual(done.returncode, 1)
                self.assertIn(str(place), done.stderr + done.stdout)
                bench.stop()
                for said in (check.stderr, bench.daemon_log()):
                    for word in (str(place), cause, "set `records`"):
                        self.assertIn(word, said)

    def test_what_is_wrong_is_refused_before_anything_moves(self):
        with Bench() as bench:
            self.check_refused(bench, 2, ["scael", "scale"], "scael")
            self.check_refused(bench, 2, ["turns", "0"], "scale", "-p", "turns=0")
            self.check_refused(bench, 2, ["rate_deg_s"], "scale", "-p", "rate_deg_s=fast")
            self.check_refused(bench, 2, ["nonsense"], "scale", "-p", "nonsense=1")
            self.check_refused(bench, 1, ["scale.lua:", "soft limit"], "scale", "-p", "turns=1000")

    def test_sigterm_in_the_middle_of_a_run_stops_in_order_with_the_record_closed(self):
        with Bench(extra="[virtual]\npace = 20\n") as bench:
            self.assertEqual(bench.run("run", "scale", "--detach").returncode, 0)
            while bench.json("status")["run"]["segments_done"] < 1:
                self.assertIsNone(bench.daemon.poll())
            bench.daemon.send_signal(signal.SIGTERM)
            self.assertEqual(bench.daemon.wait(DEADLINE_S), 0)
            record = bench.newest_record()
            self.assertEqual(json.loads((record / "run.json").read_text())["outcome"], "aborted")
            self.assertEqual(bench.run("analyze", record).returncode, 0)

    def test_a_run_that_ends_while_it_prepares_says_so_and_leaves_a_whole_record(self):
        with Bench(extra="[virtual]\npace = 0.2\nidle_pace = 0.2\n") as bench:
            self.assertEqual(bench.run("run", "scale", "--detach").returncode, 0)
            while "preparing" not in bench.run("status").stdout:
                self.assertIsNone(bench.daemon.poll())
            self.assertEqual(bench.run("pause").stdout,
                             "preparing: the pause is made as soon as there is a segment to end\n")
            self.assertEqual(bench.run("resume").stdout, "preparing\n")
            self.assertEqual(bench.run("abort").stdout, "stopping\n")
            while bench.json("status")["state"] != "idle":
                self.assertIsNone(bench.daemon.poll())
            record = bench.newest_record()
            self.assertTrue((record / "events.lcmlog").exists())
            shown = bench.run("show", "latest")
            self.assertEqual(shown.returncode, 0, shown.stderr)
            self.assertIn("aborted", shown.stdout)
            self.assertIn("the gyro gave no sample", shown.stdout)
            analysed = bench.run("analyze", record)
            self.assertEqual(analysed.returncode, 1)
            self.assertIn("no gyro sample", analysed.stderr)

    def test_a_record_folder_that_cannot_be_written_any_more_prevents_the_run(self):
        with Bench() as bench:
            bench.records.write_text("in the way")
            done = bench.run(*SHORT_SCALE)
            self.assertEqual(done.returncode, 1)
            self.assertIn(str(bench.records), done.stderr + done.stdout)


if __name__ == "__main__":
    unittest.main()
