"""What the virtual stand says really happened, and whether that was allowed."""
import collections

STOPPED_WITHIN_S = 1.0   # from a stop to standstill: the drive's ramp, with room
STILL_DEG = 0.1          # worm and play settle
RAN_AWAY_S = 3.0         # that an axis nobody commanded may turn before it is stopped
BEYOND_DEG = 5.0         # past a limit, at rest; and half a second of motion

Line = collections.namedtuple("Line", "t_s what device value")


class Truth:
    def __init__(self, path):
        head, _, *rows = path.read_text().splitlines()
        self.power_on_utime = int(head.rsplit(" ", 1)[1])
        self.lines = [Line(float(t), what, device, float(value)) for t, what, device, value in
                      (row.split(",") for row in rows if row.count(",") == 3)]
        self.angles = {axis: [(line.t_s, line.value) for line in self.lines
                              if line.what == "angle" and line.device == axis]
                       for axis in ("outer", "middle", "inner")}

    def of(self, what, device=None):
        return [line for line in self.lines if line.what == what and device in (None, line.device)]

    def fault_s(self):
        """When the fault began; None where it did not."""
        faults = self.of("fault")
        return faults[0].t_s if faults else None

    def heater_on(self):
        """At the end."""
        switched = self.of("heater")
        return bool(switched) and switched[-1].value > 0

    def angle(self, axis, t_s):
        before = [deg for at_s, deg in self.angles[axis] if at_s <= t_s]
        return before[-1] if before else 0.0

    def commanded_deg(self, axis, from_s):
        """How far the drive was told to go from then on; of a move under way, what was left of it."""
        commands = [line for line in self.lines if line.what in ("move", "stop") and line.device == axis]
        way, at_deg = 0.0, self.angle(axis, from_s)
        last = [line for line in commands if line.t_s <= from_s][-1:]
        for line in last + [line for line in commands if line.t_s > from_s]:
            if line.what == "move":
                way += abs(line.value - at_deg)
                at_deg = line.value
        return way

    def astray_deg(self, axis, from_s):
        """How far the table was, at most, from where its drive was told to go, when the next command came."""
        commands = [line for line in self.lines if line.what in ("move", "stop") and line.device == axis]
        ends_s = [line.t_s for line in commands[1:]] + [float("inf")]
        return max((abs(line.value - self.angle(axis, end_s)) for line, end_s in zip(commands, ends_s)
                    if line.what == "move" and end_s >= from_s), default=0.0)

    def breaches(self, limit_deg, runaway=None):
        """runaway: axis and rate of the one that turns by itself, if any."""
        return (self.beyond(limit_deg, abs(runaway[1]) if runaway else 0.0) + self.moved_after_stop()
                + (self.ran_away(runaway[0]) if runaway else []))

    def beyond(self, limit_deg, rate_deg_s):
        allowed = limit_deg + BEYOND_DEG + 0.5 * rate_deg_s
        return [f"{axis} axis went to {max(map(abs, degs)):.1f} deg, its limit is {limit_deg:g} deg"
                for axis, angles in self.angles.items()
                if max(map(abs, degs := [deg for _, deg in angles] or [0.0])) > allowed]

    def moved_after_stop(self):
        """Between a stop and the next move, or the fault that moves it, nothing may turn."""
        found = []
        for axis in self.angles:
            commands = [line for line in self.lines if (line.what in ("move", "stop") and line.device == axis)
                        or (line.what == "fault" and line.device == f"{axis}.drive")]
            for command, following in zip(commands, [*commands[1:], None]):
                if command.what != "stop":
                    continue
                end_s = following.t_s if following else float("inf")
                rest_s = command.t_s + STOPPED_WITHIN_S
                degs = [deg for t_s, deg in self.angles[axis] if rest_s < t_s < end_s]
                moved = max(degs) - min(degs) if degs else 0.0
                if moved > STILL_DEG:
                    found.append(f"{axis} axis turned by {moved:.1f} deg after its stop at {command.t_s:.2f} s")
        return found

    def ran_away(self, axis):
        begin_s = self.fault_s()
        if begin_s is None:
            return []
        stops = [line.t_s for line in self.of("stop", axis) if line.t_s > begin_s]
        last_s = self.angles[axis][-1][0] if self.angles[axis] else begin_s
        end_s = stops[0] if stops else last_s
        if end_s - begin_s <= RAN_AWAY_S:
            return []
        way = abs(self.angle(axis, end_s) - self.angle(axis, begin_s))
        return [f"{axis} axis ran away for {end_s - begin_s:.1f} s, {way:.0f} deg, "
                + ("before it was stopped" if stops else "and was never stopped")]
