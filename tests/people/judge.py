"""What a trace says against what is true of the world, and what an outcome was: counts, no opinion."""


def names_of(effect):
    """An effect is said as "this or that": its id and its rivals."""
    return [effect["id"], *effect["rivals"]]


def shown(effect):
    """id and size of an effect on one line."""
    numbers = ", ".join(f"{p['name']} = {number(p['value'])} +- {number(p['std_error'])} {p['unit']}".rstrip()
                        for p in effect["parameters"])
    rivals = f" (or {', '.join(effect['rivals'])})" if effect["rivals"] else ""
    return f"{effect['id']}{rivals}: {numbers}"


def number(value):
    return "unknown" if value is None else f"{value:.4g}"


def of_one_channel(effect):
    """What acts in the sensor; what acts in the reference, in time or in the filter, all channels share."""
    return effect is not None and effect.startswith(("bias.", "scale."))


def judge(trace, truth, hidden=None):
    """Counts of one trace.

    false: effects of which neither the id nor a rival is true of that channel. wrong: those of them in a channel that
    does not name what was hidden, although it is there to be found. true: effects whose id, or a rival, is true.
    truth: ids that are true of every channel, and `hidden`, which is true of z alone where it acts in the sensor.
    """
    out = {"false": [], "true": [], "wrong": [], "verdicts": {}, "hidden_named": False}
    for channel in trace["channels"]:
        verdict = channel["verdict"]
        out["verdicts"][verdict] = out["verdicts"].get(verdict, 0) + 1
        true_here = truth - {hidden} if of_one_channel(hidden) and channel["gyro"] != "z" else truth
        named = {name for effect in channel["effects"] for name in names_of(effect)} & true_here
        found_hidden = hidden is not None and hidden in named
        out["hidden_named"] = out["hidden_named"] or found_hidden
        for effect in channel["effects"]:
            finding = {"gyro": channel["gyro"], "says": shown(effect), "id": effect["id"], "effect": effect}
            if true_here.intersection(names_of(effect)):
                out["true"].append(finding)
                continue
            out["false"].append(finding)
            # What is hidden is in the z axis, or in the reference of all.
            if hidden is not None and not found_hidden and channel["gyro"] == "z":
                out["wrong"].append(finding)
    return out


def loop_of(run):
    """How close_loop ended: settled or not, after how many minutes and manoeuvres, and why."""
    said = run.get("said", [])
    last = said[-1]["text"] if said else ""
    return {"settled": last.startswith("settled"), "ended": last,
            "minutes": (run["end_utime"] - run["start_utime"]) * 1e-6 / 60,
            "manoeuvres": sum(one["text"].startswith("manoeuvre ") for one in said)}
