-- The loop closed by the stand itself: measure a little, trace, make the manoeuvre that tells the most, and again.
--
-- It begins with a short sequence that cannot tell much. Every manoeuvre of the menu is then rehearsed from where the
-- stand is, and the one is made from which the most is expected per minute: between the effects that still explain the
-- same and, with less weight, of every effect that could be there unseen. What is not to be separated on this stand is
-- said and not asked for again. It ends when the verdict is settled, when no manoeuvre tells anything more, or when the
-- budget of bench time is spent.

procedure = {
  summary = "Traces, chooses the next manoeuvre and makes it, until the verdict is settled",
  description = "Every choice is said with its reason, its cost and what it brought. Manoeuvres that the stand cannot "
    .. "make are left off the menu; without turns about z it is refused.",
  measures = { "bias", "scale" },
  parameters = {
    { name = "budget_min", type = "number", default = 30, unit = "min", min = 3, max = 1440,
      help = "time from the begin to the end of the last manoeuvre, an operator's included" },
    { name = "confirmations", type = "integer", default = 3, min = 0, max = 100,
      help = "manoeuvres that an effect must be named through for the verdict to be settled; twice as many for a step, "
        .. "which may be another effect's work" },
    { name = "small_percent", type = "number", default = 30, unit = "%", min = 0, max = 1000,
      help = "an effect whose own angle error is less than this share of the one that is left is named, and holds no "
        .. "verdict up beside larger ones; 0: every effect counts" },
    { name = "initial_rest_s", type = "number", default = 120, unit = "s", min = 10, max = 7200,
      help = "rest before the first turn" },
    { name = "rest_s", type = "number", default = 2, unit = "s", min = 0.5, max = 600,
      help = "rest between moves" },
    { name = "acceleration_deg_s2", type = "number", default = 80, unit = "deg/s^2", min = 0.1, max = 100000,
      help = "of all turns; an axis with a lower limit takes its limit" },
    { name = "fan", type = "boolean", default = true, help = "false: no fan, neither the stand's nor the operator's" },
    { name = "fan_cools_degC", type = "number", default = 8, unit = "degC", min = 0.5, max = 80,
      help = "by how much the fan is expected to cool the sensor" },
    { name = "heater_warms_degC", type = "number", default = 8, unit = "degC", min = 0.5, max = 80,
      help = "by how much a heater of the stand is expected to warm the sensor; nobody is asked for one" },
    { name = "patience_s", type = "number", default = 3600, unit = "s", min = 10, max = 43200,
      help = "how long the operator is waited for; then the run ends as an error" },
  },
}

local function turn(p, axis, angle_deg, rate_deg_s)
  bench.turn{ axis = axis.name, angle_deg = angle_deg, rate_deg_s = rate_deg_s,
    acceleration_deg_s2 = math.min(p.acceleration_deg_s2, axis.max_acceleration_deg_s2) }
  bench.rest{ duration_s = p.rest_s }
end

-- There and back, to the side that has the room; shorter where neither has. Rates above the limit are taken at it.
local function there_and_back(p, name, angle_deg, rate_deg_s)
  local axis = bench.axes()[name]
  local above, below = axis.max_deg - axis.angle_deg, axis.angle_deg - axis.min_deg
  local way_deg = math.min(angle_deg, math.max(above, below))
  if way_deg < 1 then return end
  if way_deg > above then way_deg = -way_deg end
  local rate = math.min(rate_deg_s, axis.max_rate_deg_s)
  turn(p, axis, way_deg, rate)
  turn(p, bench.axes()[name], -way_deg, rate)
end

local function turns(pose, list)
  return function(p)
    local name = bench.take_pose(pose).axis
    bench.rest{ duration_s = p.rest_s }
    for _, item in ipairs(list) do
      there_and_back(p, name, item[2], item[1])
    end
  end
end

local speeds = { { 40, 360 }, { 5, 45 }, { 25, 225 }, { 12, 120 }, { 32, 300 }, { 2.5, 20 }, { 18, 170 }, { 8, 80 } }
local few = { { 40, 360 }, { 12, 120 }, { 25, 240 } }

local function swings(pose)
  return function(p)
    local name = bench.take_pose(pose).axis
    bench.rest{ duration_s = p.rest_s }
    for _, motion in ipairs{ { 0.2, 10 }, { 0.4, 5 }, { 0.6, 5 }, { 0.8, 5 } } do
      local frequency_hz = motion[1]
      local amplitude_deg = math.min(motion[2], bench.swing_room{ axis = name, frequency_hz = frequency_hz })
      if amplitude_deg >= 0.2 then
        bench.swing{ axis = name, amplitude_deg = amplitude_deg, frequency_hz = frequency_hz,
          periods = math.floor(15 * frequency_hz + 0.5) }
        bench.rest{ duration_s = p.rest_s }
      end
    end
  end
end

local function rests(ups)
  return function(p)
    for _, up in ipairs(ups) do
      if bench.find_pose{ up = up }.possible then
        bench.take_pose{ up = up }
        bench.rest{ duration_s = 20 }
      end
    end
  end
end

local z_up = { about = "z", up = "+z" }
local z_level = { about = "z", up = "+y" }
local z_level_x = { about = "z", up = "+x" }
local z_down = { about = "z", up = "-z" }

local function switched(p, output)
  local name = bench.take_pose(z_up).axis
  bench.switch{ output = output, on = true, timeout_s = p.patience_s }
  bench.rest{ duration_s = 60 }
  there_and_back(p, name, 360, 40)
  bench.rest{ duration_s = 60 }
  there_and_back(p, name, 170, 18)
  bench.switch{ output = output, on = false, timeout_s = p.patience_s }
  bench.rest{ duration_s = p.rest_s }
end

local menu = {
  { name = "several speeds both ways, z up", pose = z_up, make = turns(z_up, speeds) },
  { name = "three speeds both ways, z up", pose = z_up, make = turns(z_up, few) },
  { name = "several speeds both ways, z level", pose = z_level, make = turns(z_level, speeds) },
  { name = "three speeds both ways, z level", pose = z_level, make = turns(z_level, few) },
  { name = "three speeds both ways, z level the other way", pose = z_level_x, make = turns(z_level_x, few) },
  { name = "several speeds both ways, z down", pose = z_down, make = turns(z_down, speeds) },
  { name = "three speeds both ways, z down", pose = z_down, make = turns(z_down, few) },
  { name = "slow turns, z up", pose = z_up, make = turns(z_up, { { 2.5, 36 }, { 5, 90 }, { 8, 180 } }) },
  { name = "full turns, z up", pose = z_up, make = turns(z_up, { { 32, 360 }, { 18, 360 } }) },
  { name = "short turns to and fro, z up", pose = z_up,
    make = turns(z_up, { { 12, 10 }, { 25, 20 }, { 40, 30 }, { 18, 15 }, { 5, 8 }, { 32, 25 } }) },
  { name = "speeds between, z up", pose = z_up,
    make = turns(z_up, { { 6.5, 60 }, { 10, 90 }, { 15, 120 }, { 21, 160 }, { 28, 200 }, { 36, 240 } }) },
  { name = "sinusoidal motion, z level", pose = z_level, make = swings(z_level) },
  { name = "sinusoidal motion, z up", pose = z_up, make = swings(z_up) },
  { name = "turns about x", pose = { about = "x" }, make = turns({ about = "x" }, few) },
  { name = "turns about y", pose = { about = "y" }, make = turns({ about = "y" }, few) },
  { name = "rest in six poses", pose = { up = "+z" }, make = rests{ "+z", "+y", "-z", "-y", "-x", "+x" } },
  { name = "rest, z up", pose = { up = "+z" }, make = function(p)
    bench.take_pose{ up = "+z" }
    bench.rest{ duration_s = 180 }
  end },
  { name = "turns while a fan cools the sensor", pose = z_up, make = function(p) switched(p, "fan") end, output = "fan" },
  { name = "turns while a heater warms the sensor", pose = z_up, make = function(p) switched(p, "heater") end,
    output = "heater" },
}

local function baseline(p)
  local pose = bench.find_pose(z_up)
  if not pose.possible then
    pose = bench.find_pose{ about = "z" }
    if not pose.possible then
      bench.fail("the loop begins with turns about z: " .. pose.reason)
    end
    bench.take_pose{ about = "z" }
  else
    bench.take_pose(z_up)
  end
  bench.rest{ duration_s = p.initial_rest_s }
  there_and_back(p, pose.axis, 180, 20)
end

-- Rehearses the menu; returns the items in the order of the rehearsals, and whether there is time for any.
local function rehearse(p, left_s)
  local items, any = {}, false
  local warms_degC = { none = 0, fan = p.fan and -p.fan_cools_degC,
    heater = bench.outputs().heater and p.heater_warms_degC }
  for _, item in ipairs(menu) do
    if warms_degC[item.output or "none"] and bench.find_pose(item.pose).possible then
      bench.rehearse()
      item.make(p)
      local affordable = bench.rehearsed{ name = item.name, warms_degC = warms_degC[item.output or "none"],
        at_most_s = left_s }
      any = any or affordable
      items[#items + 1] = item
    end
  end
  return items, any
end

local function has_rival(effect, id)
  for _, rival in ipairs(effect.rivals) do
    if rival == id then return true end
  end
  return false
end

-- Whether one effect is called what the other might be instead.
local function may_be_one(one, other)
  return has_rival(one, other.id) or has_rival(other, one.id)
end

local function same_name(one, other) return one.id == other.id end

-- The effects of a trace, each with how many manoeuvres it has been named through. `before`: of the trace before, each
-- of which goes on as one effect at most, under its own name if that is there.
local function named_in(traced, before)
  local out, taken = {}, {}
  for _, axis in ipairs{ "x", "y", "z" } do
    for _, effect in ipairs(traced and traced[axis] and traced[axis].effects or {}) do
      out[#out + 1] = { axis = axis, effect = effect }
    end
  end
  for _, is_one in ipairs{ same_name, may_be_one } do
    for _, one in ipairs(out) do
      for _, known in ipairs(before) do
        if not one.outlived and not taken[known] and known.axis == one.axis and is_one(known.effect, one.effect) then
          one.outlived, taken[known] = known.outlived + 1, true
        end
      end
    end
  end
  for _, one in ipairs(out) do one.outlived = one.outlived or 0 end
  return out
end

-- Whether each effect that is not small has been named for long enough.
local function all_outlived(p, named, small)
  for _, one in ipairs(named) do
    local wanted = p.confirmations * (one.effect.may_be_a_step and 2 or 1)
    if not small[one.axis .. " " .. one.effect.id] and one.outlived < wanted then return false end
  end
  return true
end

local function small_in_words(p, choice)
  return string.format("effects of which each makes less than %g %% of the angle error that is left (small_percent): %s",
    p.small_percent, choice.small_pairs)
end

local function settled_but_for(p, choice)
  local words = {}
  if choice.never ~= "" then
    words[#words + 1] = "what no manoeuvre was expected to tell apart in the time that there was: " .. choice.never
  end
  if choice.small_pairs ~= "" then words[#words + 1] = small_in_words(p, choice) end
  return #words == 0 and "settled: nothing else of the catalogue explains the same"
    or "settled but for " .. table.concat(words, "; and for ")
end

-- Empty where there is nothing to say, as in a dry run.
local function verdict_of(traced)
  if not traced then return "Nothing to trace yet." end
  local words = {}
  for _, axis in ipairs{ "x", "y", "z" } do
    local one = traced[axis]
    if one and one.summary ~= "" then words[#words + 1] = axis .. ": " .. one.summary end
  end
  return table.concat(words, " ")
end

function run(p)
  local begin_s = bench.elapsed()
  local function left_s()
    return 60 * p.budget_min - (bench.elapsed() - begin_s)
  end
  baseline(p)
  local number, named = 0, {}
  while true do
    local traced = bench.trace()
    named = named_in(traced, named)
    local verdict = verdict_of(traced)
    if verdict ~= "" then bench.say(string.format("after %.1f min: %s", (bench.elapsed() - begin_s) / 60, verdict)) end
    if not traced then
      bench.fail("the rest and the first turn gave nothing that can be traced: is the gyro sampled, and the reference?")
    end
    local items, any = rehearse(p, left_s())
    if #items == 0 then
      bench.say("the stand can make no manoeuvre of the menu")
      return
    end
    local choice = bench.choose{ small_below = p.small_percent / 100 }
    if choice.newly_closed ~= "" then
      bench.say(string.format("no manoeuvre is expected to tell them apart in the %.1f min that are left, and none is made for "
        .. "it as long as the first of them is what is named: %s",
        left_s() / 60, choice.newly_closed))
    end
    if choice.settled and all_outlived(p, named, choice.small) then
      bench.say(settled_but_for(p, choice))
      return
    end
    if not choice.index then
      bench.say((any and "no manoeuvre of the menu tells more" or "the budget of bench time is spent")
        .. (choice.open ~= "" and "; open: " .. choice.open or "")
        .. (choice.never ~= "" and "; no manoeuvre tells these apart: " .. choice.never or "")
        .. (choice.small_pairs ~= "" and "; open, of " .. small_in_words(p, choice) or ""))
      return
    end
    number = number + 1
    local because = choice.because ~= "" and
      string.format("; it %s (chi-square %.1f expected)", choice.because, 2 * choice.nats) or ""
    local open = choice.settled and "whether it stays" or choice.open
    bench.say(string.format("manoeuvre %d: %s, %.1f min%s%s", number, choice.name, choice.duration_s / 60, because,
      open ~= "" and "; open: " .. open or ""))
    items[choice.index].make(p)
    bench.progress(math.min(0.99, 1 - left_s() / (60 * p.budget_min)))
  end
end
