"""What the tracer said of one set, against what is true of it."""

SHARED = ("angle.", "bandwidth.", "time.")  # effects of the reference or of the whole sensor


def names_of(effect):
    """An effect as named: its id and its rivals."""
    return [effect["id"]] + list(effect.get("rivals") or [])


def traced(channel):
    return (channel.get("baseline") or {}).get("whitened_rms") is not None


def excused(effect, truth, channel):
    """An effect that this bench has without its being hidden, as of a thermometer that lags."""
    hidden = [t["id"] for t in truth["effects"]] if channel == truth["channel"] else []
    # A latency that the bench has is told from its rivals.
    names = [effect["id"]] if truth["bench"].get("stamped_late") else names_of(effect)
    return any(n in truth["tolerated"] and n not in hidden for n in names)


def verdict_on(channel, truth_ids):
    """One word on the channel that has the effects.

    exact: the true set, nothing else, no rivals; among: the true set, with rivals; extra: the true ones and more;
    partial: some of the true ones; wrong: names, none of them true; listed: silent, and the truth is listed as not
    identifiable; nothing.
    """
    effects = channel["effects"]
    left, matched = list(truth_ids), 0
    for effect in effects:
        hit = next((t for t in left if t in names_of(effect)), None)
        if hit:
            left.remove(hit)
            matched += 1
    if not effects:
        unseen = [u["id"] for u in channel.get("unidentifiable") or []]
        return "listed" if all(t in unseen for t in truth_ids) else "nothing"
    if matched == 0:
        return "wrong"
    if left:
        return "partial" if matched == len(effects) else "extra"
    if matched < len(effects):
        return "extra"
    return "among" if any(effect.get("rivals") for effect in effects) else "exact"


def verdict_on_unknown(channel, copies):
    """Of an effect out of the catalogue: recognised, false (a physical name alone), or nothing.

    copies: names that are as right on these data, as a step in time of a jump at a temperature that is passed once.
    """
    def invented(effect):
        return all(not n.startswith(("composed", "empirical", "unexplained")) and n not in copies
                   for n in names_of(effect))
    if any(invented(e) for e in channel["effects"]):
        return "false"
    if channel["effects"] or channel["verdict"] in ("unexplained", "partly_explained"):
        return "recognised"
    return "nothing"


def false_names(channel, allowed):
    """Ids named of which neither themselves nor a rival is among the allowed ones."""
    return [e["id"] for e in channel["effects"] if not any(n in allowed for n in names_of(e))]


def parameter_errors(effect, true, scale):
    """Error over the bound, and whether the stated 95 % interval holds, of each linear parameter that is named.

    scale: what the tracer's unit of rate is in true ones (its sensitivity is that of the turns where none is given).
    Of a wave the amplitude is compared, which has no sign.
    """
    waves = [p for p in effect["parameters"] if p["name"].startswith("amplitude")]
    if waves:
        mine = [p for p in waves if true["axis"] and p["name"].endswith(true["axis"])] or waves
        return [_error(mine[0], true["amplitude"], true["amplitude_std_error"], scale)]
    firsts = effect["parameters"][:len(true["values"])]
    sense = -1.0 if effect["id"] in OPPOSITE else 1.0
    return [_error(p, sense * v, s, scale)
            for p, v, s in zip(firsts, true["values"], true["std_errors"]) if s is not None]


# The equation here is eps t w, as in effects.md, the tracer's -eps t w.
OPPOSITE = {"angle.clock_drift"}
UNITS = {"ppm": 1e-6, "ms": 1e-3, "%": 1e-2}


def _error(parameter, value, std_error, scale):
    unit = UNITS.get(parameter.get("unit"), 1.0) * scale
    found = parameter["value"] or 0.0  # null: held at 0, as not to be told from the rest of the model
    miss = abs(found) * unit - abs(value)
    # None: what these data do not determine has no interval, and none is counted.
    stated = None if parameter.get("std_error") is None else parameter["std_error"] * unit
    return dict(name=parameter["name"], error=miss / std_error,
                inside=None if stated is None else bool(abs(miss) <= 1.96 * stated),
                stated=None if stated is None else stated / std_error,
                wrong_sign=bool(found * value < 0.0 and abs(value) > 5.0 * std_error))


def score(truth, answer):
    """One record of a set: the word on the channel, false names elsewhere, errors of parameters, held-out figures.

    answer: the tracer's JSON, or None when it failed.
    """
    record = {key: truth[key] for key in ("bench_class", "kind", "level", "seed", "channel", "permitted_alone",
                                          "permitted_among", "kept_by_walk", "cannot_show", "ideal", "ideal_named")}
    record["truth"] = [e["id"] for e in truth["effects"]]
    channels = {c["gyro"]: c for c in (answer or {}).get("channels", [])}
    record.update(word="refused", said=[], errors=[], silent=[], heldout=[], remarks=[])
    if truth["channel"] not in channels:
        return record
    for each in channels.values():
        each["effects"] = [e for e in each["effects"] if not excused(e, truth, each["gyro"])]
    channel = channels[truth["channel"]]
    record["word"] = _word(truth, channel)
    record["verdict"], record["traced"] = channel["verdict"], traced(channel)
    record["said"] = [" or ".join(names_of(e)) for e in channel["effects"]]
    record["remarks"] = _remarks(answer, channel)
    if record["word"] == "exact" and truth["kind"] in ("single", "pair"):
        record["errors"] = _errors(truth, channel)
    _others(record, truth, channels)
    return record


def _word(truth, channel):
    if not truth["effects"]:
        return "false" if channel["effects"] else "silent"
    if truth["kind"] == "unknown":
        return verdict_on_unknown(channel, truth["copies"])
    return verdict_on(channel, [e["id"] for e in truth["effects"]])


def _errors(truth, channel):
    given = truth["bench"]["nominal_key"] or truth["bench"]["output"] in ("deg_s", "rad_s")
    own = truth["m"]["xyz".index(channel["gyro"])]["xyz".index(channel["gyro"])]
    found = []
    for effect in channel["effects"]:
        if effect["id"] in truth["tolerated"]:
            continue  # what the bench itself has of it is in the parameter
        true = next(t for t in truth["effects"] if t["id"] == effect["id"])
        shared = effect["id"].startswith(SHARED)
        scale = 1.0 if given or shared else own
        found += [dict(e, id=effect["id"]) for e in parameter_errors(effect, true, scale)]
    return found


def _others(record, truth, channels):
    """False names on every channel on which they would be, and held-out figures of all channels."""
    true = [e["id"] for e in truth["effects"]]
    shared = [t for t in true if t.startswith(SHARED)]
    for name, channel in channels.items():
        if not traced(channel):
            continue
        after = (channel.get("heldout_whitened_rms") or {}).get("after")
        if after is not None:
            record["heldout"].append(dict(channel=name, after=after))
        if name == truth["channel"] and true:
            continue
        if truth["kind"] == "unknown" and name == truth["channel"]:
            continue
        record["silent"].append(dict(channel=name, shared=bool(shared), false=false_names(channel, shared)))


def _remarks(answer, channel):
    def text(remark):
        return remark if isinstance(remark, str) else str(remark.get("says", remark))
    return [text(r) for r in (channel.get("remarks") or []) + (answer.get("remarks") or [])][:4]
