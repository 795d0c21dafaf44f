-- The full sequence: what leaves nothing in the dark.
--
-- Warm-up at rest, eight speeds both ways with z up, horizontal and down, turns about the other axes upright and
-- lying, cooling and warming again, and sinusoidal motion: after it no effect of the catalogue hides behind another.

procedure = {
  summary = "The full sequence: rest, speeds in all poses, cooling and warming, sinusoidal motion",
  description = "About 38 minutes. Parts that the stand cannot do are left out and named; without turns about z with z "
    .. "up it is refused. Where the stand switches no fan, the operator is asked to.",
  measures = { "bias", "scale" },
  parameters = {
    { name = "warm_up_s", type = "number", default = 900, unit = "s", min = 0, max = 21600,
      help = "rest at the begin, z up, from cold" },
    { name = "rest_s", type = "number", default = 2, unit = "s", min = 0.5, max = 600,
      help = "rest between moves" },
    { name = "acceleration_deg_s2", type = "number", default = 80, unit = "deg/s^2", min = 0.1, max = 100000,
      help = "of all turns; an axis with a lower limit takes its limit" },
    { name = "fan", type = "boolean", default = true,
      help = "false: no fan, neither the stand's nor the operator's; that part is left out" },
    { name = "patience_s", type = "number", default = 3600, unit = "s", min = 10, max = 43200,
      help = "how long the operator is waited for; then the run ends as an error" },
  },
}

local angles_deg = { [2.5] = 36, [5] = 72, [8] = 90, [12] = 135, [18] = 180, [25] = 270, [32] = 360, [40] = 360 }

local parts = {
  { name = "z up", rates_deg_s = { 2.5, 5, 8, 12, 18, 25, 32, 40 }, poses = { { about = "z", up = "+z" } } },
  { name = "z horizontal", rates_deg_s = { 2.5, 5, 8, 12, 18, 25, 32, 40 },
    poses = { { about = "z", up = "+y" }, { about = "z", up = "-y" }, { about = "z", up = "+x" } } },
  { name = "z down", rates_deg_s = { 2.5, 5, 8, 12, 18, 25, 32, 40 }, poses = { { about = "z", up = "-z" } } },
  { name = "x vertical", rates_deg_s = { 12, 25, 40 },
    poses = { { about = "x", up = "+x" }, { about = "x", up = "-x" } } },
  { name = "y vertical", rates_deg_s = { 12, 25, 40 },
    poses = { { about = "y", up = "+y" }, { about = "y", up = "-y" } } },
  { name = "x horizontal", rates_deg_s = { 8, 18, 32 }, poses = { { about = "x", axis = "middle" } } },
}

-- Of cooling and of warming.
local least_change_degC = 1

local function leave_out(what, reason)
  bench.say("left out, " .. what .. ": " .. reason)
end

-- The first of the poses that the stand can take, taken; nil where there is none.
local function take_first(what, poses)
  local reason
  for _, pose in ipairs(poses) do
    local found = bench.find_pose(pose)
    if found.possible then
      bench.say(what)
      local taken = bench.take_pose(pose)
      return taken.axis
    end
    reason = reason or found.reason
  end
  leave_out(what, reason)
  return nil
end

local function shuffled(list)
  local copy = { table.unpack(list) }
  for i = #copy, 2, -1 do
    local j = math.random(i)
    copy[i], copy[j] = copy[j], copy[i]
  end
  return copy
end

local function acceleration_of(p, axis)
  return math.min(p.acceleration_deg_s2, axis.max_acceleration_deg_s2)
end

local function turn(p, axis, angle_deg, rate_deg_s)
  bench.turn{ axis = axis.name, angle_deg = angle_deg, rate_deg_s = rate_deg_s,
    acceleration_deg_s2 = acceleration_of(p, axis) }
  bench.rest{ duration_s = p.rest_s }
end

-- Turns at `rate_deg_s` to the side of `sign`, or to the other where the limits are in the way. Returns the way.
local function leg(p, name, rate_deg_s, sign)
  local axis = bench.axes()[name]
  if rate_deg_s > axis.max_rate_deg_s then
    leave_out(string.format("%g deg/s", rate_deg_s),
      string.format("axis.%s turns at %g deg/s at most", name, axis.max_rate_deg_s))
    return nil
  end
  local angle_deg = math.min(angles_deg[rate_deg_s], axis.max_deg - axis.min_deg)
  if angle_deg < 2 * rate_deg_s * rate_deg_s / acceleration_of(p, axis) then
    leave_out(string.format("%g deg/s", rate_deg_s),
      string.format("the limits leave axis.%s a turn of %.3g deg, too short to keep that rate for half of the way",
        name, angle_deg))
    return nil
  end
  local function fits(way_deg)
    local end_deg = axis.angle_deg + way_deg
    return end_deg <= axis.max_deg and end_deg >= axis.min_deg
  end
  local way_deg = sign * angle_deg
  if not fits(way_deg) then way_deg = -way_deg end
  if not fits(way_deg) then
    bench.move_to{ axis = name, angle_deg = axis.max_deg, rate_deg_s = axis.max_rate_deg_s / 2 }
    bench.rest{ duration_s = p.rest_s }
    way_deg = -angle_deg
  end
  turn(p, axis, way_deg, rate_deg_s)
  return way_deg
end

local function random_sign()
  return math.random(2) == 1 and 1 or -1
end

local function both_ways(p, name, rates_deg_s)
  for _, rate_deg_s in ipairs(shuffled(rates_deg_s)) do
    local way_deg = leg(p, name, rate_deg_s, random_sign())
    if way_deg then turn(p, bench.axes()[name], -way_deg, rate_deg_s) end
  end
end

-- One way, and the next back.
local function to_and_fro(p, name, rates_deg_s)
  local sign = random_sign()
  for _, rate_deg_s in ipairs(rates_deg_s) do
    leg(p, name, rate_deg_s, sign)
    sign = -sign
  end
end

-- What was to show another history of the temperature has to change it.
local function check_change(what, before_degC, sign)
  local now_degC = bench.temperature()
  if before_degC and now_degC and (now_degC - before_degC) * sign >= least_change_degC then return end
  if not before_degC or not now_degC then
    bench.say("the temperature is not known: nobody can say whether " .. what .. " had an effect")
  else
    bench.say(string.format("%s changed the gyro's own thermometer by %+.2f degC (%.2f to %.2f degC), expected %+g degC "
      .. "or more: effects of the temperature's history will hide; check the fan, and run thermal", what,
      now_degC - before_degC, before_degC, now_degC, sign * least_change_degC))
  end
end

local function cool_and_warm(p)
  local name = take_first("cooling and warming, z up", parts[1].poses)
  local before_degC = bench.temperature()
  bench.switch{ output = "fan", on = true, timeout_s = p.patience_s }
  bench.rest{ duration_s = 60 }
  to_and_fro(p, name, { 18, 32 })
  bench.rest{ duration_s = 60 }
  check_change("cooling", before_degC, -1)
  before_degC = bench.temperature()
  bench.switch{ output = "fan", on = false, timeout_s = p.patience_s }
  bench.rest{ duration_s = 60 }
  to_and_fro(p, name, { 12, 40 })
  bench.rest{ duration_s = 120 }
  check_change("warming", before_degC, 1)
end

local function swing(p)
  local name = take_first("sinusoidal motion, z horizontal", parts[2].poses)
    or take_first("sinusoidal motion, z up", parts[1].poses)
  bench.rest{ duration_s = p.rest_s }
  for _, motion in ipairs{ { 0.2, 10 }, { 0.4, 5 }, { 0.6, 5 }, { 0.8, 5 } } do
    local frequency_hz = motion[1]
    local amplitude_deg = math.min(motion[2], bench.swing_room{ axis = name, frequency_hz = frequency_hz })
    if amplitude_deg < 0.2 then
      leave_out(string.format("%g Hz", frequency_hz),
        string.format("axis.%s has room for %.2g deg at %g deg", name, amplitude_deg, bench.axes()[name].angle_deg))
    else
      bench.swing{ axis = name, amplitude_deg = amplitude_deg, frequency_hz = frequency_hz,
        periods = math.floor(15 * frequency_hz + 0.5) }
      bench.rest{ duration_s = p.rest_s }
    end
  end
end

function run(p)
  local z_up = bench.find_pose(parts[1].poses[1])
  if not z_up.possible then
    bench.fail("the sequence needs turns about z with z up: " .. z_up.reason)
  end
  bench.take_pose(parts[1].poses[1])
  bench.rest{ duration_s = p.warm_up_s }

  for _, part in ipairs(parts) do
    local name = take_first(part.name, part.poses)
    if name then
      bench.rest{ duration_s = p.rest_s }
      both_ways(p, name, part.rates_deg_s)
    end
  end
  if p.fan then cool_and_warm(p) end
  swing(p)
  bench.take_pose(parts[1].poses[1])
  bench.rest{ duration_s = p.rest_s }
end
