#!/usr/bin/env python3
"""Wiring mistakes, one at a time and in pairs, on the virtual stand: whether `gyrobench run commission` names them all and
nothing else, whether the stand file that it writes works, how far the tables turned and how long it took.

  tests/commission/campaign.py --seeds 3            # every mistake, and every pair of them, with three draws of axes each
  tests/commission/campaign.py --pairs 12 --seeds 1

The virtual stand is wired as `right.toml` says (`virtual.wired_as`); the daemon is given a stand file with mistakes. How far
the tables turned is the stand's own truth. The daemon is that of GYROBENCH_BIN, build/dev/bin unless given.
"""
import argparse
import itertools
import json
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "end_to_end"))
import bench as benches  # noqa: E402

AXES = ("outer", "middle", "inner")
UNITS = {axis: number for number, axis in enumerate(AXES)}  # drives 1 to 3, encoders 11 to 13
FARTHEST_DEG = 20.0
LONGEST_S = 300.0
SCENARIO = 'include = "{root}/config/scenarios/typical.toml"\n'


class Mistake:
    """What is wrong. lines: of the stand file, key to value. scenario: of the virtual stand, TOML. lines_mend: whether a
    corrected stand file makes it right."""

    def __init__(self, finding, lines=None, scenario="", lines_mend=True):
        self.finding, self.lines, self.scenario, self.lines_mend = finding, lines or {}, scenario, lines_mend


def exchanged(device, first_unit, draw):
    one, other = draw.sample(AXES, 2)
    return {f"axis.{one}.{device}.unit": first_unit + UNITS[other],
            f"axis.{other}.{device}.unit": first_unit + UNITS[one]}


def counts(draw):
    axis, bits = draw.choice(AXES), draw.choice((10, 12, 13, 14, 16, 18, 19))
    return {f"axis.{axis}.encoder.counts_per_turn": 2 ** bits, f"axis.{axis}.encoder.range_counts": 2 ** (bits + 12)}


# By name, drawn: each of another kind.
MISTAKES = {
    "exchanged encoders": lambda draw: Mistake("exchanged encoders", exchanged("encoder", 11, draw)),
    "exchanged drives": lambda draw: Mistake("exchanged drives", exchanged("drive", 1, draw)),
    "reversed encoder": lambda draw: Mistake(
        "reversed encoder", {f"axis.{draw.choice(AXES)}.encoder.sign": -1}),
    "reversed drive": lambda draw: Mistake("reversed drive", {f"axis.{draw.choice(AXES)}.drive.sign": -1}),
    "gear ratio": lambda draw: Mistake(
        "gear ratio", {f"axis.{draw.choice(AXES)}.gear_ratio": draw.choice((10, 20, 36.5, 50.4, 80, 100))}),
    "counts per turn": lambda draw: Mistake("counts per turn", counts(draw)),
    "pulses per turn": lambda draw: Mistake(
        "pulses per turn", {f"axis.{draw.choice(AXES)}.drive.pulses_per_turn": draw.choice((1600, 5000, 20000))}),
    "word order": lambda draw: Mistake(
        "word order", {f"axis.{draw.choice(AXES)}.encoder.word_order": '"low_first"'}),
    "mounting": lambda draw: Mistake(
        "mounting", {f"geometry.mount_{draw.choice('xyz')}_deg": draw.choice((90, -90, 180, 30))}),
    "delay of the reference": lambda draw: Mistake(
        "delay of the reference", scenario=f"[encoder]\nlatency_s = {draw.uniform(0.01, 0.08):.4f}\n"),
    "play": lambda draw: Mistake(
        "play", scenario=f"[mechanics]\nbacklash_deg = {draw.uniform(0.2, 0.5):.3f}\n", lines_mend=False),
    "slipping encoder": lambda draw: Mistake(
        "slipping encoder", lines_mend=False, scenario=f'[[fault]]\ndevice = "{draw.choice(AXES)}.encoder"\n'
        f'kind = "loose"\namount = {draw.uniform(0.1, 0.5):.2f}\n'),
}


def toml_of(lines):
    """Dotted keys as tables."""
    tables = {}
    for key, value in lines.items():
        table, name = key.rsplit(".", 1)
        tables.setdefault(table, []).append(f"{name} = {value}")
    return "".join(f"[{table}]\n" + "\n".join(keys) + "\n" for table, keys in tables.items())


def draw_set(names, seed):
    """The mistakes of these names. Two that would be on one key are drawn anew."""
    draw = random.Random(f"{'+'.join(names)}/{seed}")
    while True:
        mistakes = [MISTAKES[name](draw) for name in names]
        keys = [key for mistake in mistakes for key in mistake.lines]
        if len(keys) == len(set(keys)):
            return mistakes


def commission(bench):
    """The run as JSON; an error's text in place of its wiring."""
    done = bench.run("run", "commission", "--json")
    answer = json.loads(done.stdout) if done.stdout else {"message": done.stderr}
    run = json.loads((bench.newest_record() / "run.json").read_text())
    answer["bench_s"] = (run["end_utime"] - run["start_utime"]) * 1e-6
    return answer


def findings_of(answer):
    wiring = answer.get("wiring")
    return sorted({one["what"] for one in wiring["findings"]}) if wiring else [f"error: {answer['message']}"]


def farthest_deg(truth):
    """Of any table from its mark, by what the stand wrote down."""
    angles = (line.split(",") for line in truth.read_text().splitlines() if ",angle," in line)
    return max((abs(float(words[3])) for words in angles), default=0.0)


class Outcome:
    """What came of a set of mistakes."""

    def __init__(self, names, seed):
        self.names, self.seed = names, seed
        self.mistakes = draw_set(names, seed)
        self.expected = sorted(mistake.finding for mistake in self.mistakes)
        self.found, self.left, self.turned_deg, self.bench_s = [], None, 0.0, 0.0

    def expected_left(self):
        return sorted(mistake.finding for mistake in self.mistakes if not mistake.lines_mend)

    def named(self):
        """A middle axis that turns the other way is, to all that the bench can feel, one that turns the right way under a
        sensor that is mounted half a turn off: beside a wrong mounting its encoder may be named for its drive."""
        same = {"reversed drive": "reversed", "reversed encoder": "reversed"} if "mounting" in self.expected else {}
        return {same.get(one, one) for one in self.found} == {same.get(one, one) for one in self.expected}

    def good(self):
        return (self.named() and self.left == self.expected_left()
                and self.turned_deg <= FARTHEST_DEG and self.bench_s <= LONGEST_S)

    def try_out(self):
        lines = toml_of({key: value for mistake in self.mistakes for key, value in mistake.lines.items()})
        # Sections of one name in one scenario are one.
        scenario = SCENARIO + "".join(sorted(mistake.scenario for mistake in self.mistakes))
        with benches.Bench(scenario=scenario, start=False) as bench:
            right = bench.folder / "right.toml"
            right.write_text(bench.config.read_text())
            virtual = f'wired_as = "{right}"\ntruth = "{bench.folder}/truth"\n[virtual.answers]\nmarks = "done"\n' \
                      'write_stand_file = "write"\n'
            wrong = right.read_text() + virtual + lines
            bench.config.write_text(wrong)
            bench.start()
            answer = commission(bench)
            bench.stop()
            self.found, self.bench_s = findings_of(answer), answer["bench_s"]
            self.turned_deg = farthest_deg(bench.folder / "truth")
            written = bench.folder / "stand.commissioned.toml"
            if written.exists():
                bench.config = written
            bench.start()
            self.left = findings_of(commission(bench))
        return self

    def line(self):
        found = ", ".join(self.found) or "nothing"
        left = "" if self.left == self.expected_left() else f"; afterwards: {', '.join(self.left or ['nothing'])}"
        return (f"{' + '.join(self.names) or 'nothing wrong':<48} seed {self.seed}: {'ok' if self.good() else 'MISSED'}; "
                f"{self.turned_deg:.1f} deg, {self.bench_s:.0f} s" + ("" if self.good() else f"; found {found}{left}"))


def sets(pairs, seeds, first_seed):
    """Nothing, each mistake, and pairs: so many, drawn, or all."""
    all_pairs = list(itertools.combinations(MISTAKES, 2))
    if pairs is not None:
        all_pairs = random.Random(first_seed).sample(all_pairs, pairs)
    for seed in range(first_seed, first_seed + seeds):
        for names in [(), *((name,) for name in MISTAKES), *all_pairs]:
            yield names, seed


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--pairs", type=int, help="so many pairs of mistakes; all of them unless given")
    options = parser.parse_args(arguments)
    outcomes = []
    for names, seed in sets(options.pairs, options.seeds, options.first_seed):
        outcomes.append(Outcome(names, seed).try_out())
        print(outcomes[-1].line(), flush=True)
    for count, what in ((0, "nothing wrong"), (1, "one mistake"), (2, "two mistakes")):
        some = [outcome for outcome in outcomes if len(outcome.names) == count]
        if some:
            print(f"{what}: {sum(outcome.good() for outcome in some)} of {len(some)} named as they are and mended; "
                  f"turned by {max(outcome.turned_deg for outcome in some):.1f} deg at most, in "
                  f"{max(outcome.bench_s for outcome in some):.0f} s of bench time at most")
    return 0 if all(outcome.good() for outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
