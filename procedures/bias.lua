-- Zero-rate offset against temperature.
--
-- A cold gyro is put on the resting stand. While it warms up to the room its output, turned by nothing, is
-- its offset: the run records it until the temperature settles, and the analysis fits a curve beta(T).

procedure = {
  summary = "Offset against temperature, from a cold start at rest",
  description = "The operator cools the gyro and places it; the stand rests until its temperature settles.",
  measures = { "bias" },
  parameters = {
    { name = "initial_rest_s", type = "number", default = 10, unit = "s", min = 0, max = 3600,
      help = "rest after placing, before the temperature is watched" },
    { name = "drift_degC", type = "number", default = 0.1, unit = "degC", min = 0.01, max = 5,
      help = "settled when the temperature changes by less than this within window_s" },
    { name = "window_s", type = "number", default = 120, unit = "s", min = 10, max = 3600,
      help = "time over which the change is judged" },
    { name = "max_duration_s", type = "number", default = 3600, unit = "s", min = 60, max = 43200,
      help = "end of the wait, settled or not" },
  },
}

function run(p)
  if p.window_s > p.max_duration_s then
    bench.fail("window_s = " .. p.window_s .. " s is longer than max_duration_s = " .. p.max_duration_s .. " s")
  end

  bench.ask{ id = "cool", choices = { "done" },
    text = "Cool the gyro below 0 degC, within its operating range. Done?" }
  bench.ask{ id = "place", choices = { "done" },
    text = "Place the cold gyro on the stand, and touch nothing from now on. Done?" }

  bench.rest{ duration_s = p.initial_rest_s }
  local soak = bench.soak{ drift_degC = p.drift_degC, window_s = p.window_s, max_s = p.max_duration_s }

  if soak.settled then
    bench.say(string.format("settled at %.2f degC after %.0f s", soak.temperature_degC, soak.duration_s))
  else
    bench.say(string.format("not settled after %.0f s: the curve ends at %.2f degC",
      soak.duration_s, soak.temperature_degC))
  end
end
