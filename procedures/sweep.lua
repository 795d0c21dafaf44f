-- Sinusoidal motion over frequencies.
--
-- Latency, the sensor's bandwidth and mechanical play look alike at one frequency; over several they part: a
-- latency's phase grows with frequency at constant amplitude, a low-pass filter also takes amplitude away, and
-- play does neither.

procedure = {
  summary = "Sinusoidal motion over frequencies, within the drive's limits",
  description = "Swings about one sensor axis at each frequency. Amplitudes shrink to what rate, acceleration and soft "
    .. "limits allow; frequencies at which less than least_amplitude_deg is left are left out and named.",
  measures = { "scale" },
  resumable = true,
  parameters = {
    { name = "about", type = "choice", default = "z", choices = { "x", "y", "z" },
      help = "sensor axis that is turned about" },
    { name = "frequencies_hz", type = "numbers", default = "0.2, 0.4, 0.6, 0.8, 1.2, 1.6", unit = "Hz",
      min = 0.01, max = 20, help = "frequencies of the motion" },
    { name = "amplitude_deg", type = "number", default = 5, unit = "deg", min = 0.01, max = 360,
      help = "amplitude of the table, where the limits leave it" },
    { name = "least_amplitude_deg", type = "number", default = 0.2, unit = "deg", min = 0.01, max = 360,
      help = "below it a frequency is left out" },
    { name = "duration_s", type = "number", default = 15, unit = "s", min = 1, max = 3600,
      help = "of the motion at each frequency, in whole periods" },
    { name = "rest_s", type = "number", default = 2, unit = "s", min = 0.5, max = 600,
      help = "rest after each frequency" },
    { name = "initial_rest_s", type = "number", default = 30, unit = "s", min = 0, max = 7200,
      help = "rest before the first motion" },
  },
}

function run(p)
  local pose = bench.find_pose{ about = p.about }
  if not pose.possible then
    bench.fail("this stand cannot turn about " .. p.about .. ": " .. pose.reason)
  end
  local axis = bench.axes()[pose.axis]
  -- From the middle of the way where there is not room enough on both sides of the pose.
  local half_way_deg = (axis.max_deg - axis.min_deg) / 2
  local room_deg = math.min(p.amplitude_deg, half_way_deg)
  local centre_deg = math.max(axis.min_deg + room_deg,
    math.min(axis.max_deg - room_deg, pose.angles_deg[pose.axis]))

  local swings, left_out = {}, {}
  for _, frequency_hz in ipairs(p.frequencies_hz) do
    local amplitude_deg = math.min(room_deg,
      bench.swing_room{ axis = pose.axis, frequency_hz = frequency_hz, angle_deg = centre_deg })
    if amplitude_deg < p.least_amplitude_deg * (1 - 1e-6) then
      left_out[#left_out + 1] = string.format("%g Hz: axis.%s allows an amplitude of %.3g deg",
        frequency_hz, pose.axis, amplitude_deg)
    else
      swings[#swings + 1] = { axis = pose.axis, amplitude_deg = amplitude_deg, frequency_hz = frequency_hz,
        periods = math.max(1, math.floor(p.duration_s * frequency_hz + 0.5)) }
    end
  end
  if #swings == 0 then
    bench.fail("no frequency is possible with least_amplitude_deg = " .. p.least_amplitude_deg .. " deg; "
      .. table.concat(left_out, "; "))
  end
  for _, text in ipairs(left_out) do
    bench.say("left out, " .. text)
  end

  bench.take_pose{ about = p.about, axis = pose.axis }
  bench.move_to{ axis = pose.axis, angle_deg = centre_deg, rate_deg_s = axis.max_rate_deg_s / 2 }
  bench.rest{ duration_s = p.initial_rest_s }
  for _, swing in ipairs(swings) do
    bench.say(string.format("%.3g deg at %g Hz", swing.amplitude_deg, swing.frequency_hz))
    bench.swing(swing)
    bench.rest{ duration_s = p.rest_s }
  end
end
