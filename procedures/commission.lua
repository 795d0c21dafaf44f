-- Commissioning: how the stand is really wired.
--
-- Each drive turns its table a little, by the drive's own count and at low speed, whatever the stand file says of it. The gyro
-- feels which axis turns, which way and how far; the encoders show which of them follows. What does not agree with the
-- stand file is named with its reason, and a stand file with the wrong lines corrected can be written.

procedure = {
  summary = "Finds out how the stand is wired, and corrects the stand file",
  description = "For a new stand, or one whose cables were changed: exchanged or reversed drives and encoders, wrong gear "
    .. "ratio, pulses or counts per turn, word order, play, an encoder that slips, the mounting of the gyro, the delay of "
    .. "the reference. No table turns farther than 12 deg from where it stands. All devices must answer (gyrobench "
    .. "devices), and the axes stand at their marks.",
  commissions = true,
  parameters = {},
}

local function tell(report)
  for _, note in ipairs(report.notes) do
    bench.say("as it should be: " .. note)
  end
  local corrections = 0
  for number, finding in ipairs(report.findings) do
    bench.say(string.format("%d. %s: %s", number, finding.what, finding.reason))
    for _, line in ipairs(finding.lines) do
      bench.say("   " .. line)
    end
    corrections = corrections + #finding.lines
  end
  return corrections
end

local function readings()
  local words = {}
  for _, name in ipairs{ "outer", "middle", "inner" } do
    local axis = bench.axes()[name]
    if axis then
      words[#words + 1] = string.format("%s reads %.2f deg", name, axis.angle_deg)
    end
  end
  return table.concat(words, ", ")
end

function run()
  bench.ask{ id = "marks", choices = { "done" }, text = string.format(
    "Are all axes at their marks, and free to turn by 12 deg both ways (%s)? If they are, answer done. If not, abort, "
    .. "turn them there, and begin again", readings()) }
  local report = bench.find_wiring()
  local corrections = tell(report)
  if report.measured and #report.findings == 0 then
    bench.say("the stand is wired as its file says")
    return
  end
  if report.measured and corrections == 0 then
    bench.say("no line of the stand file mends this")
    return
  end
  local answer = bench.ask{ id = "write_stand_file", choices = { "leave", "write" },
    text = string.format("Write a stand file with %s corrected, as %s? The one that is used stays as it is",
      corrections == 1 and "this line" or string.format("these %d lines", corrections), report.file) }
  if answer == "write" and report.measured then
    bench.say("written: " .. bench.write_stand_file() .. "; look it through, start the daemon with it, and run "
      .. "commission once more")
  elseif report.measured then
    bench.say("no stand file was written")
  end
end
