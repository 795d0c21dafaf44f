"""The campaign's tables, as plain text."""
import math
from collections import defaultdict

import numpy as np

SINGLE_WORDS = ("exact", "among", "wrong", "extra", "partial", "nothing", "listed", "refused")


def wilson(hits, n, z=1.96):
    """95 % limits of a share, in percent."""
    if n == 0:
        return 0.0, 100.0
    p, d = hits / n, 1.0 + z * z / n
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / d
    middle = (p + z * z / (2 * n)) / d
    return 100 * (middle - half), 100 * (middle + half)


def share(hits, n):
    low, high = wilson(hits, n)
    return f"{100 * hits / n:5.1f} [{low:4.1f},{high:5.1f}]" if n else "    -             "


def grouped(records, key):
    groups = defaultdict(list)
    for record in records:
        groups[key(record)].append(record)
    return dict(sorted(groups.items(), key=lambda item: str(item[0])))


def hidden(records):
    return [r for r in records if r["truth"] and r["kind"] in ("single", "pair")]


def by_kind(records):
    print("\n(a) by kind and level, percent; 'among' counts exact ones too")
    print(f"{'kind':8}{'level':>6}{'sets':>6}  {'exact':19} {'among':19}" +
          "".join(f"{w:>9}" for w in SINGLE_WORDS[2:]) + "   permitted exact, among; walk unknown; "
          "an ideal tracer on these data")
    for (kind, level), group in grouped(hidden(records), lambda r: (r["kind"], r["level"])).items():
        print(f"{kind:8}{level:6g}{len(group):6}  " + words(group))
    for level, group in grouped([r for r in records if r["kind"] == "unknown" and r["truth"]],
                                lambda r: r["level"]).items():
        n = len(group)
        counts = {w: sum(r["word"] == w for r in group) for w in ("recognised", "false", "nothing", "refused")}
        print(f"{'unknown':8}{level:6g}{n:6}  " + ", ".join(f"{w} {100 * c / n:.1f}" for w, c in counts.items()))


def words(group):
    n = len(group)
    count = {w: sum(r["word"] == w for r in group) for w in SINGLE_WORDS}
    text = f"{share(count['exact'], n):19} {share(count['exact'] + count['among'], n):19}"
    text += "".join(f"{100 * count[w] / n:9.1f}" for w in SINGLE_WORDS[2:])
    permitted = [(r["permitted_alone"], r["permitted_among"]) for r in group if r["permitted_alone"] is not None]
    if permitted:
        alone, among = np.mean(permitted, axis=0)
        text += f"   {100 * alone:5.1f} {100 * among:5.1f}"
        kept = [r["kept_by_walk"] for r in group]
        if None not in kept:
            text += "   {:5.1f} {:5.1f}".format(*100 * (np.array(kept) @ np.array(permitted)) / n)
        ideal = [r["ideal"] for r in group]
        if None not in ideal:
            found = [ideal.count("exact"), ideal.count("exact") + ideal.count("among")]
            text += "   {:5.1f} {:5.1f}".format(*(100 * k / n for k in found))
    return text


def by_class(records):
    print("\n(b) by class: exact of single sets in percent (permitted), wrong, false names on silent channels, "
          "held out")
    levels = sorted({r["level"] for r in records if r["kind"] == "single" and r["truth"]})
    print(f"{'class':22}" + "".join(f"{f'{x:g} sigma':>22}" for x in levels) +
          f"{'wrong':>8}{'refused':>9}{'false/silent':>14}{'held out':>10}{'worst':>9}")
    for name, group in grouped(records, lambda r: r["bench_class"]).items():
        cells = "".join(f"{class_cell(group, level):>22}" for level in levels)
        single = [r for r in group if r["kind"] == "single" and r["truth"]]
        wrong = sum(r["word"] == "wrong" for r in single)
        silent = [s for r in group for s in r["silent"] if not s["shared"]]
        after = [h["after"] for r in group for h in r["heldout"]]
        print(f"{name:22}{cells}{100 * wrong / max(1, len(single)):8.1f}"
              f"{sum(r['word'] == 'refused' for r in group):9}"
              f"{sum(bool(s['false']) for s in silent):8}/{len(silent):<5}"
              f"{np.mean(after) if after else math.nan:10.3f}{max(after, default=math.nan):9.2f}")


def class_cell(group, level):
    mine = [r for r in group if r["kind"] == "single" and r["level"] == level and r["truth"]]
    if not mine:
        return "-"
    exact = sum(r["word"] == "exact" for r in mine)
    return f"{exact}/{len(mine)} ({100 * np.mean([r['permitted_alone'] for r in mine]):.0f} %)"


def by_effect(records):
    print("\n(c) by effect: single sets exact/all (permitted) at each level; parameters in units of the bound "
          "(RMS), stated error over the bound, 95 % intervals that hold")
    single = [r for r in records if r["kind"] == "single" and r["truth"]]
    levels = sorted({r["level"] for r in single})
    for effect, group in grouped(single, lambda r: r["truth"][0].split("(")[0]).items():
        cells = "".join(f"{class_cell(group, level):>18}" for level in levels)
        print(f"{effect:24}{cells}   " + parameters([e for r in group for e in r["errors"]]))
    everything = [e for r in hidden(records) for e in r["errors"]]
    print(f"{'all, singles and pairs':24}{'':{18 * len(levels)}}   " + parameters(everything))


def parameters(errors):
    if not errors:
        return "-"
    rms = math.sqrt(np.mean([e["error"] ** 2 for e in errors]))
    median = np.median([abs(e["error"]) for e in errors]) / 0.6745
    inside = [e["inside"] for e in errors if e["inside"] is not None]
    stated = [e["stated"] for e in errors if e["stated"] is not None]
    return (f"rms {rms:6.2f}  by median {median:5.2f}  stated {np.median(stated) if stated else math.nan:5.2f}"
            f"  hold {share(sum(inside), len(inside))} of {len(inside)}"
            f"  wrong signs {sum(e['wrong_sign'] for e in errors)}")


def false_discovery(records):
    silent = [s for r in records for s in r["silent"]]
    print("\n(d) false names on silent channels")
    for shared in (False, True):
        mine = [s for s in silent if s["shared"] == shared]
        what = "that share an effect of the reference or of time" if shared else "in which nothing is hidden"
        print(f"  channels {what}: {share(sum(bool(s['false']) for s in mine), len(mine))} of {len(mine)}")
    names = grouped([dict(id=n) for s in silent for n in s["false"]], lambda r: r["id"])
    print("  named: " + ", ".join(f"{k} {len(v)}" for k, v in sorted(names.items(), key=lambda i: -len(i[1]))))


def heldout(records):
    after = [h["after"] for r in records for h in r["heldout"]]
    if after:
        print(f"\n(e) held-out whitened RMS after: mean {np.mean(after):.4f}, median {np.median(after):.4f}, "
              f"worst {max(after):.3f}, beyond 1.02 in {100 * np.mean(np.array(after) > 1.02):.1f} % of {len(after)}")


def badness(record):
    worst = max((h["after"] for h in record["heldout"]), default=1.0)
    falses = sum(bool(s["false"]) for s in record["silent"])
    order = dict(refused=6, wrong=5, false=4, extra=3, partial=2, nothing=1)
    missed = order.get(record["word"], 0)
    if record["word"] == "nothing" and record["kind"] != "unknown":
        missed = 2.5 * (record["permitted_alone"] or 0.0) if record["level"] >= 20 else 0.5
    return missed + 2 * falses + min(math.log10(max(worst, 1.0)), 2.0)


def worst(records, count=20):
    print(f"\n(f) the {count} worst sets")
    for r in sorted(records, key=badness, reverse=True)[:count]:
        if badness(r) < 0.3:
            break
        outs = "; ".join(f"{s['channel']}: {', '.join(s['false'])}" for s in r["silent"] if s["false"])
        after = ", ".join(f"{h['after']:.3g}" for h in r["heldout"])
        print(f"{r['bench_class']}:{r['kind']}:{r['level']:g}:{r['seed']}  {r['channel']}: truth "
              f"{' and '.join(r['truth']) or '-'}; {r['word']}: {', '.join(r['said']) or '-'}"
              + (f"; false on {outs}" if outs else "") + f"; held out {after}")
        for remark in r["remarks"][:2]:
            print(f"      {remark[:180]}")


def print_all(records):
    for part in (by_kind, by_class, by_effect, false_discovery, heldout, worst):
        part(records)
