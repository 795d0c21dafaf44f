"""At how many places a tracer has to look for an effect of which it does not know where it is.

As so many tests that have nothing in common count which pass a gain (2 log-likelihood) of 25 as often as the largest of
all places does, where the data have noise alone.
"""
import math

import catalogue

GAIN = 25.0  # near what is asked for; of it the numbers depend little


def count(scene, candidate, channel):
    """Of frequencies, periods of a turn, speeds, shapes; 1 of what has no place. Steps: of_steps.

    Of frequencies between which a wave of free phase and size is looked for over a time T, the largest of all passes z
    of log-likelihood by sqrt(4 pi / 12) T (f_max - f_min) sqrt(z) exp(-z) (Baluev 2008, 6). Of resonances there is one
    in twice a usual width. Shapes of one parameter, which overlap widely, count as the few that are tried.
    """
    duration_s = sum(table.end_s - table.start_s for table in scene.plan.tables)
    low_hz, high_hz = catalogue.TONES_HZ
    tones = math.sqrt(4.0 * math.pi / 12.0) * duration_s * (high_hz - low_hz) * math.sqrt(0.5 * GAIN)
    return {"bias.tone": tones, "angle.ripple": catalogue.RIPPLES[1] - catalogue.RIPPLES[0],
            "bias.vibration": abs(scene.w_deg_s[channel]).max() / 6.5,
            "bias.hysteresis": 3.0, "bias.warm_up": 3.0}.get(candidate.effect, 1.0)


SPACINGS = (1, 8, 64)  # readings between places of a step


def beside(scene, candidate):
    """The steps so many readings later, one for each of SPACINGS; none of what is no step."""
    if candidate.effect not in ("bias.step", "angle.step"):
        return []
    return [catalogue.Candidate(candidate.effect, candidate.axis,
                                **dict(candidate.nonlinear, t0_s=candidate.nonlinear["t0_s"] + k * reading_s(scene)))
            for k in SPACINGS]


def reading_s(scene):
    return 1.0 / min(scene.bench["reference_rate_hz"], scene.bench["gyro_rate_hz"])


def of_steps(scene, candidate, correlations):
    """Of an effect whose step may be at any reading. correlations: of scores of some steps with those of the steps beside
    them, (steps, SPACINGS). An axis's angle steps where the axis turns.

    All places pass at least as often as every k-th of them does. Near a place what the noise of the readings leaves of
    two steps is nearly the same, farther away the formula holds: the largest of all spacings is the count.
    """
    duration_s = sum(table.end_s - table.start_s for table in scene.plan.tables
                     if candidate.axis is None or table.turning_axes()[candidate.axis])
    return max(duration_s / (k * reading_s(scene)) *
               sum(tests_to_the_next(1.0 - min(1.0, abs(step[i]))) for step in correlations) / len(correlations)
               for i, k in enumerate(SPACINGS))


def tests_to_the_next(apart, gain=GAIN):
    """Tests that a place adds to the one before it, whose score has a correlation of 1 - apart with its own.

    The largest of a row of such scores passes the root of the gain by gain * apart * v(sqrt(2 gain apart)) as often as
    one score does, v the correction for going in jumps (Siegmund, Sequential Analysis, 1985, 10.2):
    v(x) = (2/x) (Phi(x/2) - 1/2) / ((x/2) Phi(x/2) + phi(x/2)).
    """
    half = math.sqrt(0.5 * gain * apart)
    if half < 1e-6:
        return gain * apart
    below = 0.5 * math.erfc(-half / math.sqrt(2.0))
    density = math.exp(-0.5 * half * half) / math.sqrt(2.0 * math.pi)
    return min(1.0, gain * apart * (below - 0.5) / half / (half * below + density))
