"""Whether a result is wrong, against a clean run of the same part, and whether its reader is told that something was."""
import math

WRONG_BY_SIGMA = 6.0
WRONG_SCALE_REL, WRONG_BIAS_LSB = 5e-4, 13.1  # 0.1 deg/s at 131 LSB; smaller errors are no fault's


def curve(bias, degC):
    """Value and standard error of an offset's curve at a temperature."""
    powers = [(degC - bias["reference_temperature_degC"]) ** k for k in range(len(bias["coefficients"]))]
    variance = sum(powers[i] * powers[k] * bias["covariance"][i][k]
                   for i in range(len(powers)) for k in range(len(powers)))
    return sum(c * power for c, power in zip(bias["coefficients"], powers)), math.sqrt(max(variance, 0.0))


def pairs(hurt, whole):
    """(what, value and error of the one, of the other, least difference that is called wrong)."""
    for one, other in ((s, c) for s in hurt["scale"] for c in whole["scale"] if s["axis"] == c["axis"]):
        if one["alpha_std_error"] is not None and other["alpha_std_error"] is not None:
            yield (f"scale of {one['axis']}", (one["alpha"], one["alpha_std_error"]),
                   (other["alpha"], other["alpha_std_error"]), WRONG_SCALE_REL * abs(other["alpha"]))
    for one, other in ((s, c) for s in hurt["bias"] for c in whole["bias"] if s["axis"] == c["axis"]):
        low = max(one["min_temperature_degC"], other["min_temperature_degC"])
        high = min(one["max_temperature_degC"], other["max_temperature_degC"])
        if low <= high:  # elsewhere the curves have nothing to do with each other
            middle = 0.5 * (low + high)
            yield f"bias of {one['axis']}", curve(one, middle), curve(other, middle), WRONG_BIAS_LSB


def spoilt(hurt, whole):
    """What is wrong, in words; empty where nothing is."""
    found = []
    if hurt[0] is None or whole[0] is None:
        return ""
    for what, (value, error), (expected, expected_error), least in pairs(hurt[0], whole[0]):
        off = abs(value - expected)
        if not math.isfinite(off) or off > max(least, WRONG_BY_SIGMA * math.hypot(error, expected_error)):
            found.append(f"{what} is {value:.6g} +- {error:.2g}, expected {expected:.6g} +- {expected_error:.2g}")
    return "; ".join(found)


def words(result, trace):
    """All that result and trace say beside figures: defects, remarks, effects."""
    said = set()
    for defect in (result or {}).get("defects", []):
        said.add("defect: " + (defect if isinstance(defect, str) else defect.get("kind", str(defect))))
    for part in [result or {}, *(result or {}).get("scale", []), *(result or {}).get("bias", [])]:
        said.update("remark: " + shape(text) for text in part.get("remarks", []))
    for channel in (trace or {}).get("channels", []):
        said.update(f"effect: {effect['id']} of {channel['gyro']}" for effect in channel["effects"])
        said.update("finding: " + shape(str(finding)) for finding in channel["remaining"]["findings"])
        said.update("remark: " + shape(text) for text in channel["remarks"])
    return said


def shape(text):
    """Without its figures, which differ from run to run."""
    return "".join("#" if letter.isdigit() else letter for letter in text).replace("#", "")


def marked(hurt, whole):
    """What the reader is told that a clean run does not say; empty where it is nothing."""
    return "; ".join(sorted(words(*hurt) - words(*whole)))
