#include "report/page.hpp"

namespace odeval::report {

// The palette is Okabe and Ito's, darkened on white and lightened on black until thin lines are seen, with four more
// (dashed where they are used) for its tail.
constexpr std::string_view css = R"css(
:root {
  color-scheme: light dark;
  --paper: #fff; --ink: #1b1d21; --soft: #555b66; --rule: #d5d9e0; --raised: #f5f6f8; --link: #0b57b0;
  --grid: #e3e6eb; --shade: rgba(120, 128, 145, .22);
  --good: #0a6b3d; --good-back: #ddf3e6; --bad: #a12310; --bad-back: #fde5df;
  --limits: #7a5200; --limits-back: #fdf0cf; --none: #555b66; --none-back: #eceef2;
  --c0: #0072b2; --c1: #d55e00; --c2: #009e73; --c3: #b5568a; --c4: #1b1d21; --c5: #b97f00;
  --c6: #2e8fc7; --c7: #8f8500; --c8: #882255; --c9: #332288; --c10: #7a4b1e; --c11: #2f8f86;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --paper: #14161a; --ink: #e6e8ec; --soft: #a6acb8; --rule: #383d47; --raised: #1d2026; --link: #7db7ff;
    --grid: #2a2e36; --shade: rgba(150, 160, 180, .20);
    --good: #7fe0ab; --good-back: #143524; --bad: #ff9d8a; --bad-back: #431a13;
    --limits: #f3c969; --limits-back: #3c2e0b; --none: #a6acb8; --none-back: #2a2e36;
    --c0: #4aa8e8; --c1: #ff8a3c; --c2: #2fc79a; --c3: #e08fba; --c4: #e6e8ec; --c5: #e6a82b;
    --c6: #7cc8f2; --c7: #e8dc4a; --c8: #d4709c; --c9: #a79cf0; --c10: #c79a6b; --c11: #5fc0b5;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body {
  margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 72rem; background: var(--paper); color: var(--ink);
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
}
h1 { font-size: clamp(1.6rem, 4vw, 2.3rem); line-height: 1.2; margin: 0 0 1rem; }
h2 { font-size: 1.45rem; line-height: 1.25; margin: 0 0 .75rem; }
h3 { font-size: 1.08rem; line-height: 1.35; margin: 0 0 .4rem; }
p, ul, ol, dl { margin: 0 0 .9rem; }
header p, main p, main li, nav { max-width: 46rem; overflow-wrap: break-word; }
.lead { font-size: 1.12rem; }
section { margin-top: 3rem; }
article { border-top: 1px solid var(--rule); padding: 1rem 0 .3rem; }
a { color: var(--link); }
small, .note, figcaption, .legend, .settles { font-size: .9rem; }
small { color: var(--soft); }
code { font: .9em ui-monospace, SFMono-Regular, Menlo, Consolas, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
sup { line-height: 0; }
nav { margin-top: 3rem; }
nav ol { columns: 18rem auto; column-gap: 3rem; padding-left: 1.8rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .35rem .7rem; text-align: left; vertical-align: top; border-bottom: 1px solid var(--rule); }
thead th { border-bottom: 2px solid var(--rule); vertical-align: bottom; }
td.number { text-align: right; white-space: nowrap; }
th.number { text-align: right; }
.scroll { overflow-x: auto; max-width: 100%; }
.missing { color: var(--soft); font-style: italic; }
.note { color: var(--soft); margin: .4rem 0; }
figure { margin: 1.6rem 0 2rem; }
figure.table { max-width: 100%; }
figcaption { max-width: 46rem; margin-top: .5rem; }
figure.table figcaption { margin: 0 0 .5rem; }
.panels { display: grid; gap: 1rem; grid-template-columns: minmax(0, 42rem); }
svg.plot { display: block; width: 100%; height: auto; overflow: visible; }
svg.plot text { font-family: inherit; }
.legend { list-style: none; margin: .5rem 0 0; padding: 0; display: flex; flex-wrap: wrap; gap: .1rem 1.2rem; }
svg.swatch { width: 2.2rem; height: .78rem; vertical-align: middle; fill: none; stroke-width: 2; }
.picture img { display: block; max-width: 100%; height: auto; background: #fff; }
.verdict {
  display: inline-block; padding: .05rem .55rem; border-radius: .3rem; font-weight: 600; font-size: .88rem;
  color: var(--none); background: var(--none-back); white-space: nowrap;
}
.verdict.confirmed { color: var(--good); background: var(--good-back); }
.verdict.refuted { color: var(--bad); background: var(--bad-back); }
.verdict.confirmed-with-limits { color: var(--limits); background: var(--limits-back); }
.verdicts { width: 100%; }
.verdicts ul { list-style: none; margin: 0; padding: 0; }
.verdicts .claim { width: 34%; }
.verdicts small { white-space: nowrap; }
.conditions { padding-left: 1.3rem; }
.rule { margin-bottom: .2rem; }
.reading { border-left: 3px solid var(--rule); padding-left: .8rem; }
dl { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: .2rem 1.2rem; font-size: .9rem; }
dt { color: var(--soft); }
dd { margin: 0; overflow-wrap: anywhere; }
@media (min-width: 48rem), print {
  .panels { grid-template-columns: repeat(var(--columns), minmax(0, 42rem)); }
  .panels.in-1 svg.plot text { font-size: .8em; }
  .panels.in-2 svg.plot text { font-size: .88em; }
}
@media screen {
  .scroll td:first-child, .whole { white-space: nowrap; }
  .long { max-height: min(36rem, 80vh); overflow-y: auto; border-bottom: 1px solid var(--rule); }
  .long thead th { position: sticky; top: 0; background: var(--paper); box-shadow: inset 0 -2px var(--rule); }
}
@media screen and (max-width: 47.99rem) {
  body { padding: 1.2rem .9rem 3rem; }
  .verdicts, .verdicts tbody, .verdicts tr, .verdicts td, .verdicts th { display: block; border: 0; padding: .1rem 0; }
  .verdicts thead { display: none; }
  .verdicts tr { border-top: 1px solid var(--rule); padding: .8rem 0; }
  .verdicts .claim { width: auto; }
  dl { grid-template-columns: minmax(0, 1fr); gap: 0; }
  dd { margin-bottom: .5rem; }
}
@media print {
  :root { color-scheme: light; --link: var(--ink); }
  html { font-size: 9pt; }
  body { max-width: none; padding: 0; }
  .scroll { overflow: visible; }
  table { font-size: .76rem; width: 100%; }
  th, td { padding: .12rem .25rem; }
  .verdicts td:last-child { white-space: nowrap; }
  .long tbody tr:nth-child(n+25) { display: none; }
  .long::after { content: "Printed as far as row 24; all rows are in the CSV file."; font-size: .76rem; font-style: italic; }
  .picture img { max-height: 9cm; }
  figure, tr, article, .panels > * { break-inside: avoid; }
  figure.table { break-inside: auto; }
  h2, h3 { break-after: avoid; }
  .verdict { border: 1px solid currentColor; }
}
)css";

const std::string_view style_sheet = css;

}  // namespace odeval::report
