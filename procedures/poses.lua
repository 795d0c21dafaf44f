-- Still in many orientations.
--
-- Gravity turns through all directions of the sensor while nothing else turns but the Earth: what changes from
-- pose to pose is the gyro's sensitivity to gravity and its squares, and the accelerometer's scale, offset and
-- misalignment.

procedure = {
  summary = "Still in six and more orientations",
  description = "Rests with each sensor axis up and down, then with edges and corners of the cube up. Poses that the "
    .. "stand cannot take are left out and named. The bias of the result is the mean over the poses; where the trace "
    .. "names bias.g_linear or bias.g_squared, its baseline is the bias without gravity.",
  measures = { "bias" },
  resumable = true,
  parameters = {
    { name = "poses", type = "choice", default = "18", choices = { "6", "18", "26" },
      help = "6: faces of the cube, 18: edges too, 26: corners too" },
    { name = "rest_s", type = "number", default = 20, unit = "s", min = 1, max = 3600,
      help = "rest in each pose" },
    { name = "initial_rest_s", type = "number", default = 60, unit = "s", min = 0, max = 7200,
      help = "rest before the first pose" },
    { name = "rate_deg_s", type = "number", default = 30, unit = "deg/s", min = 0.1, max = 1000,
      help = "rate between poses; axes that are slower go at their limit" },
    { name = "least_poses", type = "integer", default = 4, min = 2, max = 26,
      help = "refused where the stand can take fewer" },
  },
}

-- Each next to its opposite or a neighbour, so that the ways are short.
local faces = { "+z", "+y", "-z", "-y", "-x", "+x" }
local edges = { "+x+y", "+x+z", "+x-y", "+x-z", "-y-z", "+y-z", "+y+z", "-y+z", "-x+z", "-x+y", "-x-z", "-x-y" }
local corners = { "+x+y+z", "+x+y-z", "+x-y-z", "+x-y+z", "-x-y+z", "-x-y-z", "-x+y-z", "-x+y+z" }

local function wanted(count)
  local list = {}
  for _, group in ipairs{ faces, count ~= "6" and edges or {}, count == "26" and corners or {} } do
    for _, up in ipairs(group) do
      list[#list + 1] = up
    end
  end
  return list
end

function run(p)
  local reached, left_out = {}, {}
  for _, up in ipairs(wanted(p.poses)) do
    local pose = bench.find_pose{ up = up }
    if pose.possible then
      reached[#reached + 1] = up
    else
      left_out[#left_out + 1] = up .. " up: " .. pose.reason
    end
  end
  if #reached < p.least_poses then
    bench.fail(string.format("the stand can take %d of these poses, fewer than least_poses = %d; %s",
      #reached, p.least_poses, table.concat(left_out, "; ")))
  end
  for _, text in ipairs(left_out) do
    bench.say("left out, " .. text)
  end

  bench.rest{ duration_s = p.initial_rest_s }
  for number, up in ipairs(reached) do
    bench.say(string.format("pose %d of %d: %s up", number, #reached, up))
    bench.take_pose{ up = up, rate_deg_s = p.rate_deg_s }
    bench.rest{ duration_s = p.rest_s }
  end
end
