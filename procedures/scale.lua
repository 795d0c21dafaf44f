-- Scale factor from turns of known angle.
--
-- The table turns by whole turns of its shaft (360 deg of the shaft, 9 deg of the table at a ratio of 40), with
-- a rest after each, first all one way and then all the way back. Turns one way add up to a long angle that the
-- error of a single stop hardly matters to; the way back brings the table home and shows an asymmetry.

procedure = {
  summary = "Scale factor, from shaft turns with rests, there and back",
  measures = { "scale" },
  resumable = true,
  parameters = {
    { name = "axis", type = "choice", default = "inner", choices = { "outer", "middle", "inner" },
      help = "axis of the stand that turns" },
    { name = "turns", type = "integer", default = 40, min = 1, max = 4000,
      help = "turns of the shaft one way; as many lead back" },
    { name = "rate_deg_s", type = "number", default = 20, unit = "deg/s", min = 0.1, max = 1000,
      help = "rate of the table" },
    { name = "rest_s", type = "number", default = 2, unit = "s", min = 0.5, max = 600,
      help = "rest after each turn" },
    { name = "initial_rest_s", type = "number", default = 60, unit = "s", min = 0, max = 3600,
      help = "rest before the first turn" },
  },
}

function run(p)
  bench.rest{ duration_s = p.initial_rest_s }

  local done = 0
  for _, direction in ipairs{ 1, -1 } do
    for _ = 1, p.turns do
      bench.turn{ axis = p.axis, shaft_turns = direction, rate_deg_s = p.rate_deg_s }
      bench.rest{ duration_s = p.rest_s }
      done = done + 1
      bench.progress(done / (2 * p.turns))
    end
  end

  local scale = bench.estimate("scale_factor")
  -- A dry run measures nothing: it answers with the nominal value, and no error.
  if scale and scale.std_error > 0 then
    bench.say(string.format("scale factor %.8g ± %.2g %s", scale.value, scale.std_error, scale.unit))
  end
end
