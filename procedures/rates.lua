-- Turns about each sensor axis, at several rates, both ways, with the axis up and down.
--
-- Rates of both signs separate scale, asymmetry and even terms; the axis up and down separates what gravity does
-- to offset and scale; the axes that do not turn show the cross-axis terms.

procedure = {
  summary = "Turns about each sensor axis at a list of rates, both ways, axis up and down",
  description = "The stand puts the sensor axis upright, up and then down, and turns about it there and back at each "
    .. "rate. An axis that cannot be upright is turned as it lies. What the stand cannot do is left out and named.",
  measures = { "scale" },
  resumable = true,
  parameters = {
    { name = "axes", type = "choice", default = "all", choices = { "all", "x", "y", "z" },
      help = "sensor axes that are turned about" },
    { name = "rates_deg_s", type = "numbers", default = "5, 10, 20, 40", unit = "deg/s", min = 0.1, max = 1000,
      help = "rates of the table, each taken both ways" },
    { name = "angle_deg", type = "number", default = 180, unit = "deg", min = 1, max = 3600,
      help = "angle of each turn, or as much of it as the limits leave" },
    { name = "rest_s", type = "number", default = 2, unit = "s", min = 0.5, max = 600,
      help = "rest after each turn" },
    { name = "initial_rest_s", type = "number", default = 60, unit = "s", min = 0, max = 7200,
      help = "rest before the first turn" },
  },
}

-- The ways in which the stand can turn about a sensor axis: upright where it can.
local function ways_about(name, left_out)
  local ways, reason = {}, ""
  for _, sign in ipairs{ "+", "-" } do
    local way = { about = name, up = sign .. name }
    local pose = bench.find_pose(way)
    if pose.possible then
      ways[#ways + 1] = way
    else
      reason = pose.reason
      left_out[#left_out + 1] = "turning with " .. way.up .. " up: " .. reason
    end
  end
  if #ways == 0 and bench.find_pose{ about = name }.possible then
    ways[1] = { about = name }
  end
  return ways
end

-- Turns by `angle_deg` and back, from where the axis has room for it.
local function there_and_back(p, pose, rate_deg_s)
  local axis = bench.axes()[pose.axis]
  local acceleration_deg_s2 = axis.max_acceleration_deg_s2 / 2
  local angle_deg = math.min(p.angle_deg, axis.max_deg - axis.min_deg)
  if rate_deg_s > axis.max_rate_deg_s then
    return string.format("axis.%s turns at %g deg/s at most", pose.axis, axis.max_rate_deg_s)
  end
  if angle_deg < 2 * rate_deg_s * rate_deg_s / acceleration_deg_s2 then
    return string.format("a turn of %g deg is too short to keep that rate for half of the way", angle_deg)
  end
  local way_deg = angle_deg * pose.sense
  local end_deg = axis.angle_deg + way_deg
  if end_deg > axis.max_deg or end_deg < axis.min_deg then
    local start_deg = way_deg > 0 and axis.max_deg - angle_deg or axis.min_deg + angle_deg
    bench.move_to{ axis = pose.axis, angle_deg = start_deg, rate_deg_s = axis.max_rate_deg_s / 2 }
    bench.rest{ duration_s = p.rest_s }
  end
  for _, angle in ipairs{ way_deg, -way_deg } do
    bench.turn{ axis = pose.axis, angle_deg = angle, rate_deg_s = rate_deg_s,
      acceleration_deg_s2 = acceleration_deg_s2 }
    bench.rest{ duration_s = p.rest_s }
  end
  return nil
end

function run(p)
  local ways, left_out, said, turned = {}, {}, {}, 0
  for _, name in ipairs(p.axes == "all" and { "z", "y", "x" } or { p.axes }) do
    for _, way in ipairs(ways_about(name, left_out)) do
      ways[#ways + 1] = way
    end
  end
  if #ways == 0 then
    bench.fail("this stand cannot turn about the axes asked for; " .. table.concat(left_out, "; "))
  end

  bench.rest{ duration_s = p.initial_rest_s }
  for _, way in ipairs(ways) do
    bench.say(string.format("about %s, %s", way.about, way.up and way.up .. " up" or "lying"))
    local pose = bench.take_pose(way)
    bench.rest{ duration_s = p.rest_s }
    for _, rate_deg_s in ipairs(p.rates_deg_s) do
      local reason = there_and_back(p, pose, rate_deg_s)
      if reason then
        local text = string.format("%g deg/s about %s: %s", rate_deg_s, way.about, reason)
        if not said[text] then  -- there may be several ways about one axis
          left_out[#left_out + 1], said[text] = text, true
        end
      else
        turned = turned + 1
      end
    end
  end
  if turned == 0 then
    bench.fail("none of the rates is possible; " .. table.concat(left_out, "; "))
  end
  for _, text in ipairs(left_out) do
    bench.say("left out, " .. text)
  end
end
