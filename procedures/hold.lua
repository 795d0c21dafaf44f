-- Held poses: a calibration without a stand.
--
-- The sensor is held still in one pose after the other, and turned by hand from each to the next. Gravity at rest
-- before and after each turn is the reference, so that no axis and no angle sensor is needed. What turns the sensor
-- is a hand, or the axes of the stand in its place.

procedure = {
  summary = "Poses held still with turns between them: gyro and accelerometer without a stand",
  description = "Asks for the six faces first, then for poses between them, and says which are still missing. "
    .. "Afterwards `gyrobench hold latest` gives matrix, offset, g-sensitivity and the accelerometer's calibration. "
    .. "Where the stand's axes take the part of the hand, its angle sensors are not looked at.",
  measures = { "bias" },
  parameters = {
    { name = "poses", type = "integer", default = 20, min = 10, max = 26,
      help = "poses in all: six faces, then edges, then corners of the cube" },
    { name = "rest_s", type = "number", default = 4, unit = "s", min = 2, max = 60,
      help = "how long each pose is held" },
    { name = "rate_deg_s", type = "number", default = 40, unit = "deg/s", min = 1, max = 1000,
      help = "rate of the stand's axes where they take the part of the hand; slower axes go at their limit" },
  },
}

-- Faces first; each pose far from the one before, so that the turns are long.
local ups = { "+z", "-x", "+y", "-z", "+x", "-y",
  "+x+y", "-x-z", "+y+z", "-x-y", "+x+z", "-y-z", "-x+y", "+x-z", "-y+z", "+x-y", "-x+z", "+y-z",
  "+x+y+z", "-x-y+z", "+x-y-z", "-x+y-z", "+x+y-z", "-x-y-z", "+x-y+z", "-x+y+z" }

local function still_missing(from, last)
  local names = {}
  for number = from, math.min(last, from + 5) do
    names[#names + 1] = ups[number]
  end
  return table.concat(names, ", ") .. (last > from + 5 and " ..." or "")
end

-- The poses that the stand can take.
local function within_reach(count)
  local reached = {}
  for number = 1, count do
    local pose = bench.find_pose{ up = ups[number] }
    if pose.possible then
      reached[#reached + 1] = ups[number]
    else
      bench.say("left out, " .. ups[number] .. " up: " .. pose.reason)
    end
  end
  if #reached < 10 then
    bench.fail(string.format("the axes can take %d of these poses, fewer than 10: answer hand, and hold the sensor",
      #reached))
  end
  return reached
end

local function by_stand(p)
  local reached = within_reach(p.poses)
  for number, up in ipairs(reached) do
    bench.say(string.format("pose %d of %d: %s up", number, #reached, up))
    bench.take_pose{ up = up, rate_deg_s = p.rate_deg_s }
    bench.rest{ duration_s = p.rest_s }
    bench.progress(number / #reached)
  end
end

local function by_hand(p)
  for number = 1, p.poses do
    bench.ask{ id = "pose", choices = { "done" }, text = string.format(
      "Pose %d of %d: turn the sensor within 1 to 4 s until its %s points up, hold it still or lay it down, and "
      .. "answer done. Still missing: %s", number, p.poses, ups[number], still_missing(number, p.poses)) }
    bench.rest{ duration_s = p.rest_s }
    bench.progress(number / p.poses)
  end
end

function run(p)
  local who = bench.ask{ id = "hold", choices = { "hand", "stand" },
    text = "Who turns the sensor: a hand, with the sensor off the stand, or the stand's axes in its place?" }
  if who == "stand" then
    by_stand(p)
  else
    by_hand(p)
  end
  bench.say("gyrobench hold latest gives the calibration of these poses")
end
