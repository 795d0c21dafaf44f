-- Still and turning while the sensor warms and cools.
--
-- One warm-up alone cannot tell an offset that follows the temperature from one that follows its change, or from
-- one that fades with time: the temperature has to go up, down and up again. Where the stand switches no fan and no
-- heater, the operator is asked to.

procedure = {
  summary = "Still and turning while the sensor warms, cools and warms again",
  description = "Three phases: the warm-up, cooling by a fan, warming again without it. A heater of the stand ([relays]) "
    .. "helps to warm; where it is alone, cooling is its rest. Without either the operator is asked to switch a fan, and "
    .. "without cooling and without a heater, a heater. In each phase the stand rests and turns about one sensor axis both ways, in turn.",
  measures = { "bias", "scale" },
  parameters = {
    { name = "about", type = "choice", default = "z", choices = { "x", "y", "z" },
      help = "sensor axis that is turned about" },
    { name = "rates_deg_s", type = "numbers", default = "12, 40, 18, 32", unit = "deg/s", min = 0.1, max = 1000,
      help = "rates of the turns, one after the other" },
    { name = "angle_deg", type = "number", default = 180, unit = "deg", min = 1, max = 3600,
      help = "angle of each turn, or as much of it as the limits leave" },
    { name = "rest_s", type = "number", default = 30, unit = "s", min = 1, max = 3600,
      help = "rest between the turns" },
    { name = "warm_up_s", type = "number", default = 900, unit = "s", min = 0, max = 21600,
      help = "first phase: the sensor warms up by itself, or by a heater that has no fan beside it" },
    { name = "cooling_s", type = "number", default = 600, unit = "s", min = 0, max = 21600,
      help = "second phase: the fan blows; without a fan the heater rests" },
    { name = "rewarming_s", type = "number", default = 600, unit = "s", min = 0, max = 21600,
      help = "third phase: the fan rests, a heater warms" },
    { name = "least_change_degC", type = "number", default = 1, unit = "degC", min = 0, max = 100,
      help = "the operator is asked again where cooling or warming changes the temperature by less" },
    { name = "patience_s", type = "number", default = 3600, unit = "s", min = 10, max = 43200,
      help = "how long the operator is waited for; then the run ends as an error" },
  },
}

-- The rates that the axis can turn at, with angles within its limits.
local function turns_of(p, axis)
  local turns, left_out = {}, {}
  local angle_deg = math.min(p.angle_deg, axis.max_deg - axis.min_deg)
  for _, rate_deg_s in ipairs(p.rates_deg_s) do
    if rate_deg_s > axis.max_rate_deg_s then
      left_out[#left_out + 1] = string.format("%g deg/s: axis.%s turns at %g deg/s at most", rate_deg_s, axis.name,
        axis.max_rate_deg_s)
    elseif angle_deg < 4 * rate_deg_s * rate_deg_s / axis.max_acceleration_deg_s2 then
      left_out[#left_out + 1] = string.format("%g deg/s: the limits leave axis.%s a turn of %g deg, which is too short",
        rate_deg_s, axis.name, angle_deg)
    else
      turns[#turns + 1] = { axis = axis.name, angle_deg = angle_deg, rate_deg_s = rate_deg_s }
    end
  end
  if #turns == 0 then
    bench.fail("none of the rates is possible; " .. table.concat(left_out, "; "))
  end
  for _, text in ipairs(left_out) do
    bench.say("left out, " .. text)
  end
  return turns
end

-- Rests and turns, there and back, until the phase is over.
local function phase(p, turns, duration_s, number)
  local end_s = bench.elapsed() + duration_s
  while bench.elapsed() < end_s do
    bench.rest{ duration_s = math.min(p.rest_s, end_s - bench.elapsed()) }
    if bench.elapsed() >= end_s then break end
    local turn = turns[number % #turns + 1]
    number = number + 1
    bench.turn(turn)
    bench.rest{ duration_s = 2 }
    bench.turn{ axis = turn.axis, angle_deg = -turn.angle_deg, rate_deg_s = turn.rate_deg_s }
  end
  return number
end

-- Who cools and who warms: the stand with what it has, else the operator, with a fan, or with a heater where nothing was
-- cooled.
local function thermal_hands(p)
  local stand, on = bench.outputs(), {}
  local fan = p.cooling_s > 0 and (stand.fan or not stand.heater)
  local function switch(output, wanted)
    if (on[output] or false) == wanted then return end
    on[output] = wanted
    bench.switch{ output = output, on = wanted, timeout_s = p.patience_s }
  end
  return {
    begin = function()
      if stand.heater and p.warm_up_s > 0 and p.cooling_s > 0 and not fan then switch("heater", true) end
    end,
    cool = function()
      switch("heater", false)
      if fan then switch("fan", true) end
    end,
    warm = function()
      switch("fan", false)
      if stand.heater or not fan then switch("heater", true) end
    end,
    -- At the end nobody is waited for.
    rest = function()
      for _, output in ipairs{ "heater", "fan" } do
        if stand[output] then
          switch(output, false)
        elseif on[output] then
          bench.say("switch the " .. output .. " off")
          on[output] = false
        end
      end
    end,
  }
end

-- A fan that does not blow, or a heater that does not heat, is the operator's to mend.
local function watch(p, what, before_degC, now_degC, sign)
  if not before_degC or not now_degC then
    bench.say("the temperature is not known: nobody can say whether " .. what .. " had an effect")
    return
  end
  local change_degC = (now_degC - before_degC) * sign
  if change_degC >= p.least_change_degC then return end
  local text = string.format("%s changed the gyro's own thermometer by %+.2f degC (%.2f to %.2f degC), expected "
    .. "%+g degC or more: does the fan run and blow at the sensor only while it should, and is a heater connected?",
    what, now_degC - before_degC, before_degC, now_degC, sign * p.least_change_degC)
  local answer = bench.ask{ id = "no_change", choices = { "go on", "end" }, timeout_s = p.patience_s,
    text = text .. " Go on all the same, or end the run?" }
  if answer == "end" then bench.fail(text) end
end

function run(p)
  local pose = bench.find_pose{ about = p.about }
  if not pose.possible then
    bench.fail("this stand cannot turn about " .. p.about .. ": " .. pose.reason)
  end
  local turns = turns_of(p, bench.axes()[pose.axis])
  bench.take_pose{ about = p.about, axis = pose.axis }
  local axis = bench.axes()[pose.axis]
  if axis.angle_deg + turns[1].angle_deg > axis.max_deg then
    bench.move_to{ axis = pose.axis, angle_deg = axis.max_deg - turns[1].angle_deg,
      rate_deg_s = axis.max_rate_deg_s / 2 }
  end

  local hands = thermal_hands(p)
  hands.begin()
  local number = phase(p, turns, p.warm_up_s, 0)
  if p.cooling_s > 0 then
    local before_degC = bench.temperature()
    hands.cool()
    number = phase(p, turns, p.cooling_s, number)
    watch(p, "cooling", before_degC, bench.temperature(), -1)
  end
  if p.rewarming_s > 0 then
    local before_degC = bench.temperature()
    hands.warm()
    phase(p, turns, p.rewarming_s, number)
    local after_degC = bench.temperature()
    hands.rest()  -- before anybody is asked: a heater that the thermometer does not see heats all the same
    watch(p, "warming", before_degC, after_degC, 1)
  end
  hands.rest()
end
