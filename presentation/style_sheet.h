// How the report looks, on a light screen and on A4.
#pragma once

namespace gyrobench::presentation {

inline constexpr const char* kStyleSheet = R"css(
:root { color-scheme: light; --ink: #1d2329; --soft: #5b6670; --line: #cfd6dc; --after: #123f5f; }
* { box-sizing: border-box; }
body { margin: 0; background: #fff; color: var(--ink);
  font: 15px/1.5 "Source Sans 3", "Noto Sans", "Helvetica Neue", Arial, "DejaVu Sans", sans-serif;
  font-variant-numeric: tabular-nums lining-nums; }
main { max-width: 880px; margin: 0 auto; padding: 32px 24px 64px; }
h1, h2, h3, h4 { line-height: 1.25; break-after: avoid; }
h1 { font-size: 16px; font-weight: 600; letter-spacing: .02em; margin: 0; }
h2 { font-size: 20px; font-weight: 600; margin: 0 0 12px; }
h3 { font-size: 16px; font-weight: 600; margin: 20px 0 8px; }
h4 { font-size: 15px; margin: 0 0 8px; }
p { margin: 0 0 8px; overflow-wrap: anywhere; }
ul { margin: 8px 0; padding-left: 20px; }
section { margin-top: 40px; }
code { font-family: "Source Code Pro", "Noto Sans Mono", "DejaVu Sans Mono", Consolas, monospace;
  font-size: .9em; overflow-wrap: anywhere; }
.note, .run { color: var(--soft); font-size: 14px; }
header { display: flex; flex-wrap: wrap; gap: 4px 24px; justify-content: space-between;
  align-items: baseline; border-bottom: 1px solid var(--line); padding-bottom: 10px; }
header p { margin: 0; white-space: pre-wrap; }

.verdict { margin-top: 28px; padding-left: 20px; border-left: 6px solid var(--ink); }
.verdict.none { border-left: 6px double var(--soft); }
.verdict.partly { border-left-style: dashed; }
.verdict.unexplained { border-left-style: dotted; }
.verdict.cannot-be { border-left: 12px double var(--ink); }
.verdict h2 { display: flex; gap: 16px; align-items: baseline; margin-bottom: 6px; }
.verdict .axis { color: var(--soft); font-weight: 400; }
.verdict .summary { font-size: 24px; line-height: 1.35; margin-bottom: 10px; text-wrap: pretty; }
.figures { display: grid; grid-template-columns: repeat(3, 1fr); gap: 8px 28px; margin-top: 16px; }
.figures p { margin: 0; }
.figures .what { color: var(--soft); font-size: 13.5px; line-height: 1.35; min-height: 2.7em; }
.figures .figure { font-size: 22px; font-weight: 600; color: var(--after); white-space: nowrap; }
.figures .interval { font-size: 13.5px; line-height: 1.35; }

.charts { display: grid; grid-template-columns: 1fr 1fr; gap: 20px 24px; }
.charts .wide { grid-column: 1 / -1; }
figure { margin: 0; break-inside: avoid; }
figure svg { display: block; width: 100%; height: auto; overflow: visible; }
figure svg text, figure svg tspan { font-family: "Source Sans 3", "Noto Sans", "Helvetica Neue",
  Arial, "DejaVu Sans", sans-serif; font-variant-numeric: tabular-nums; }
figcaption { color: var(--soft); font-size: 13.5px; line-height: 1.35; margin-top: 2px; }
figcaption b { color: var(--ink); }
.no-chart, .no-chart + ul { color: var(--soft); font-size: 13.5px; margin: 8px 0 0; }
.no-chart { break-after: avoid; }
.no-chart + ul { margin-top: 0; break-inside: avoid; }

div.table { overflow-x: auto; margin: 6px 0 10px; }
table { border-collapse: collapse; width: 100%; font-size: 14px; }
th { text-align: left; font-weight: 600; color: var(--soft); font-size: 13px; vertical-align: bottom;
  border-bottom: 1.5px solid var(--ink); }
td { vertical-align: top; border-bottom: 1px solid var(--line); overflow-wrap: break-word; }
th, td { padding: 5px 14px 5px 0; }
th:last-child, td:last-child { padding-right: 0; }
td code { white-space: nowrap; }
code.long { white-space: normal; overflow-wrap: anywhere; }
td.number, td .number { white-space: nowrap; overflow-wrap: normal; }
.number { text-align: right; }
.group td { font-weight: 600; padding-top: 12px; }
tr { break-inside: avoid; }
tr.group { break-after: avoid; }
thead { display: table-header-group; }
.files code { font-size: 11px; }

article { border-top: 1px solid var(--line); padding: 12px 0 6px; break-inside: avoid; }
article h4 .axis { color: var(--soft); font-weight: 400; margin-right: 14px; }
dl { display: grid; grid-template-columns: 150px 1fr; gap: 3px 16px; margin: 0 0 10px; }
dt { color: var(--soft); }
dd { margin: 0; overflow-wrap: anywhere; }

@media (max-width: 700px) {
  .charts, .figures { grid-template-columns: 1fr; }
  dl { grid-template-columns: 1fr; }
}
@page { size: A4; margin: 15mm 15mm 17mm;
  @bottom-right { content: counter(page) " / " counter(pages); font: 9pt sans-serif; color: #555; } }
@media print {
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  section { margin-top: 22px; }
  .verdict { break-inside: avoid; }
  .verdict .summary { font-size: 16pt; }
  .figures { gap: 6px 20px; }
  .short { break-inside: avoid; }
  .charts { gap: 10px 18px; }
  div.table { overflow-x: visible; }
  table { font-size: 9.5pt; }
  .files code { font-size: 7.5pt; }
}
)css";

}  // namespace gyrobench::presentation
